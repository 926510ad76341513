"""A robot's agent in the closed loop: the pilot, as `agents.agent` runs it, with links instead of sockets."""

from collections.abc import Callable, Sequence

from agents.control import CONTROLLERS, controller_name
from agents.drivers import OdometryReading
from agents.drivers.sim import range_scan
from agents.estimation import DEFAULT_ESTIMATOR, ESTIMATORS
from agents.motion import STOP, Twist
from agents.pilot import Decision, Pilot
from agents.safety import Verdict
from geometry import SE2
from protocol.lab import Lab, VehicleSpec
from protocol.messages import Command, EmergencyStop, Movement, Odometry, Scan, Status, TrackedPose


class SimulatedAgent:
    """Pure but for what it is told: odometry, scans and messages go in, `send` is called with every set-point."""

    def __init__(
        self,
        lab: Lab,
        vehicle: VehicleSpec,
        send: Callable[[Twist], None],
        *,
        sequence: int = 0,
        estimator: str = DEFAULT_ESTIMATOR,
    ) -> None:
        self.pilot = Pilot(lab, vehicle, ESTIMATORS[estimator](), CONTROLLERS[controller_name(vehicle)](vehicle))
        self.decision: Decision | None = None
        self._vehicle = vehicle
        self._send = send
        self._sequence = sequence
        self._battery: float | None = None

    def hear(self, messages: Sequence[Command | EmergencyStop], now_ns: int, now_s: float) -> None:
        """The server's stream of events."""
        for message in messages:
            if isinstance(message, Command):
                verdict = self.pilot.command(message, now_ns, now_s)
                if verdict is Verdict.OBEYED and message.movement in (Movement.WAITING, Movement.NO_ACTION):
                    self._send(STOP)
            elif self.pilot.emergency_stop(message):
                self._send(STOP)

    def see(self, poses: Sequence[TrackedPose], now_ns: int, now_s: float) -> None:
        """The tracker's datagrams."""
        for pose in poses:
            self.pilot.camera_pose(pose, now_ns, now_s)

    def scan(self, scan: Scan, now_s: float) -> None:
        """A turn of the scanner."""
        assert self._vehicle.scanner is not None
        if self.pilot.scan(range_scan(scan, self._vehicle.scanner), now_s):
            self._send(STOP)

    def control(self, said: Odometry, now_ns: int, now_s: float) -> None:
        """One round of the control loop."""
        pose, twist = SE2(said.x, said.y, said.yaw), Twist(said.linear_mps, said.angular_radps)
        self._battery = said.battery
        self.pilot.battery(said.battery)
        self.pilot.odometry(OdometryReading(said.stamp_ns, said.session, pose, twist, said.range_front_m))
        self.decision = self.pilot.decide(now_ns, now_s)
        self._send(self.decision.twist)

    def status(self, now_ns: int, now_s: float) -> Status:
        self._sequence += 1
        return self.pilot.status(self._sequence, now_ns, now_s, ip="", battery=self._battery, faults=())
