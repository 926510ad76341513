"""The robot's mind without its senses: commands, poses and odometry come in, twists, responses and the status come out.

No I/O but the log and no clock, so everything that decides about motion can be tested by telling it times. `agents.agent`
is the shell around it. One round of the control loop: `add_odometry` (or `odometry_failed`), then `decide`.
"""

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass

from agents.answering import Answers
from agents.control import Executor, PathController, turning_constants
from agents.drivers import OdometryReading
from agents.estimation import Localization, NisReport, PoseEstimator
from agents.geofence import Geofence
from agents.motion import STOP, Twist
from agents.protection import ProtectiveGuard, RangeScan
from agents.safety import (
    BatteryWatch,
    CommandGate,
    EmergencyStopLatch,
    FrontGuard,
    Since,
    Situation,
    Verdict,
    why_still,
)
from geometry import SE2
from protocol.lab import Lab, VehicleSpec
from protocol.messages import (
    Command,
    EmergencyStop,
    Mode,
    Movement,
    Reason,
    Response,
    Status,
    TrackedPose,
)

_logger = logging.getLogger(__name__)
_FAR_M = 1e5
_AHEAD_NS = 500_000_000
_FAULTS = 4
_FAULT_LENGTH = 120


@dataclass(frozen=True, slots=True)
class Decision:
    """The twist to send, why the robot itself holds still (None when it obeys), and responses for the server."""

    twist: Twist
    stopped_by: Reason | None
    responses: tuple[Response, ...]


class Pilot:
    """One robot's."""

    def __init__(self, lab: Lab, vehicle: VehicleSpec, estimator: PoseEstimator, controller: PathController) -> None:
        self.gate = CommandGate(vehicle.id)
        self.latch = EmergencyStopLatch()
        self.poses_rejected = 0
        self._lab = lab
        self._vehicle = vehicle
        self._estimator = estimator
        self._executor = Executor(controller, vehicle.limits, turning_constants(vehicle))
        self._fence = Geofence(lab.areas, vehicle.limits)
        self._protection = ProtectiveGuard(vehicle)
        self._front = FrontGuard()
        self._battery = BatteryWatch(vehicle.battery.empty)
        self._since = Since()
        self._answers = Answers(vehicle)
        self._reading: OdometryReading | None = None
        self._fault: str | None = "no odometry yet"
        self._pose_received_s = -math.inf
        self._stopped_by: Reason | None = None
        self._obeyed: Command | None = None
        self._ignored_release: int | None = None

    def command(self, command: Command, now_ns: int, now_s: float) -> Verdict:
        """A command arrived; whether it is obeyed from now on is in the verdict."""
        verdict = self.gate.offer(command, now_ns, now_s)
        self._answers.arrived(command, verdict, now_ns)
        return verdict

    def emergency_stop(self, event: EmergencyStop) -> bool:
        """Whether the robot must stop now, without waiting for the next round."""
        if not self.latch.update(event):
            self._tell_ignored(event)
        return self.latch.forbids() is not None

    def camera_pose(self, pose: TrackedPose, now_ns: int, now_s: float) -> bool:
        """Whether the pose was used. Another vehicle's, one from the future and one beyond any floor are not."""
        plausible = abs(pose.x) < _FAR_M and abs(pose.y) < _FAR_M and abs(pose.yaw) < _FAR_M
        used = (
            plausible
            and pose.vehicle == self._vehicle.id
            and pose.stamp_ns <= now_ns + _AHEAD_NS
            and self._estimator.add_camera_pose(pose)
        )
        if used:
            self._pose_received_s = now_s
        else:
            self.poses_rejected += 1
        return used

    def odometry(self, reading: OdometryReading, faults: Sequence[str] = ()) -> None:
        """What the base says now; with any fault the robot stands still. Numbers beyond any floor are a fault themselves."""
        if max(abs(reading.pose.x), abs(reading.pose.y)) > _FAR_M:
            self._fault = f"the base claims to be at ({reading.pose.x:.3g}, {reading.pose.y:.3g}) m"
            return
        self._reading = reading
        self._fault = faults[0] if faults else None
        self._estimator.add_odometry(reading)

    def scan(self, scan: RangeScan, now_s: float) -> bool:
        """One turn of the safety scanner; whether the robot must stop now, without waiting for the next round."""
        return self._protection.scan(scan, STOP if self._reading is None else self._reading.twist, now_s)

    def battery(self, share: float | None) -> None:
        """The share of a full charge, 0 to 1; None while unknown. One that is empty is not driven by guidance any more."""
        self._battery.update(share)

    def odometry_failed(self, why: str) -> None:
        """The base says nothing, so nobody knows what its wheels do: the robot stands still."""
        self._fault = why

    def decide(self, now_ns: int, now_s: float) -> Decision:
        """What to do in this round of the control loop."""
        estimate = self._estimator.estimate(now_ns)
        command = self.gate.fresh(now_ns, now_s)
        stop = why_still(
            Situation(
                latch=self.latch.forbids(),
                fault=self._fault,
                command=command,
                command_age_s=self.gate.age_s(now_s),
                pose_age_s=self._pose_age_s(now_ns, now_s),
                battery_empty=self._battery.empty,
            )
        )
        twist = STOP
        reached = False
        self._obeyed = None
        if stop is None and command is not None and estimate.pose is not None and self._reading is not None:
            execution = self._executor.execute(command, estimate.pose, self._reading.twist, now_s)
            twist, stop = self._guarded(execution.twist, estimate.pose, self._reading, now_s)
            self._obeyed, reached = command, execution.reached
        else:
            self._executor.reset()
            self._protection.halt()
        stop = self._stopped_by = self._since.of(stop, now_ns)
        self._answers.decided(command, stop, reached, now_ns)
        return Decision(twist, stop, self._answers.take())

    def status(
        self, sequence: int, now_ns: int, now_s: float, *, ip: str, battery: float | None, faults: Sequence[str]
    ) -> Status:
        """What the robot says of itself; `faults` are the driver's and the agent's own."""
        estimate = self._estimator.estimate(now_ns)
        pose, twist = estimate.pose, self._reading.twist if self._reading and self._fault is None else STOP
        area = None if pose is None else self._lab.area_at(pose.x, pose.y)
        obeyed, accepted = self._obeyed, self.gate.current
        return Status(
            robot=self._vehicle.id,
            sequence=sequence,
            stamp_ns=now_ns,
            x=None if pose is None else pose.x,
            y=None if pose is None else pose.y,
            yaw=None if pose is None else pose.yaw,
            linear_mps=twist.linear_mps,
            angular_radps=twist.angular_radps,
            ip=ip,
            area=None if area is None else area.id,
            battery=battery,
            mode=Mode.MANUAL if obeyed is not None and obeyed.movement is Movement.DRIVE else Mode.AUTOMATIC,
            faults=tuple(fault[:_FAULT_LENGTH] for fault in faults[:_FAULTS]),
            # Accepted, obeyed now or not: a guidance that has lost its epochs learns from it what it must exceed.
            command_order=None if accepted is None else accepted.order,
            stopped_by=self._stopped_by,
            pose_age_s=self._pose_age_s(now_ns, now_s),
            command_age_s=self.gate.age_s(now_s),
            command_loss=self.gate.loss(now_s),
            stop_epoch=self.latch.epoch if self.latch.engaged else None,
        )

    def consistency(self) -> NisReport | None:
        """How well the estimator's covariances agree with what cameras say; None where it has none."""
        return self._estimator.consistency()

    def _guarded(self, wanted: Twist, pose: SE2, reading: OdometryReading, now_s: float) -> tuple[Twist, Reason | None]:
        """What the robot's own protection leaves of the twist that the command asks for, and why when it is a stop."""
        twist, fenced = self._fence.limit(wanted, pose)
        twist, blocked = self._protection.limit(twist, reading.twist, now_s)
        twist, near = self._front.limit(twist, reading.front_range_m)
        return twist, fenced or blocked or near

    def _tell_ignored(self, release: EmergencyStop) -> None:
        """One line per epoch: the server repeats what it says, and one overtaken on the way is no fault."""
        if not self.latch.engaged or release.epoch == self._ignored_release:
            return
        self._ignored_release = release.epoch
        _logger.warning(
            "ignored a release of the emergency stop: its epoch %d is not greater than the engagement's, %d; "
            "release it again, or restart this agent if the epochs have started over",
            release.epoch,
            self.latch.epoch,
        )

    def _pose_age_s(self, now_ns: int, now_s: float) -> float | None:
        estimate = self._estimator.estimate(now_ns)
        if estimate.localization is not Localization.ALIGNED or estimate.camera_stamp_ns is None:
            return None
        return max(0.0, (now_ns - estimate.camera_stamp_ns) / 1e9, now_s - self._pose_received_s)
