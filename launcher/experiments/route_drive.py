"""One drive of the route experiment: guidance, agent, base and camera of one vehicle in one process, in simulated time."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.control import CONTROLLERS
from agents.drivers import OdometryReading
from agents.estimation import DEFAULT_ESTIMATOR, ESTIMATORS
from agents.motion import Twist
from agents.pacing import CONTROL_RATE_HZ
from agents.pilot import Pilot
from geometry import SE2
from lab.world import World
from launcher.errors import UsageError
from launcher.experiments.fusion_camera import Camera
from launcher.experiments.route_camera import CeilingCamera
from launcher.experiments.route_courses import Point, RouteCourse
from protocol.lab import Lab, VehicleSpec
from protocol.messages import (
    Command,
    EmergencyStop,
    Movement,
    Outcome,
    Reason,
    ReasonCode,
    Target,
    TrackedPose,
    TruePose,
)
from server.guidance.following import RouteFollower, Sight
from server.guidance.parameters import GuidanceParameters
from server.guidance.route_plan import Progress, RoutePlan, resolve
from server.guidance.snapshot import extrapolated

Array = NDArray[np.float64]

WAIT_S = 3.0
"""The vehicle stands at first, and its estimator finds out where."""
RADIUS_M = 0.15
"""Waypoints count as reached within this distance, the report's tolerance."""
RADII_M = {"go_to_goal": 0.25}
"""A controller that turns off 0.2 m before a point never comes within less."""
COMMAND_DELAY_S = 0.04
COMMAND_LOSS = 0.01
_JITTER = 0.5
_START_SPREAD = (0.02, 0.02, math.radians(3.0))
_STANDS_S = 1.0
_SLOWEST_RATIO = 4.0
_SPARE_S = 40.0
_REST_MPS, _REST_RADPS = 0.01, 0.03
_MOVES_MPS, _MOVES_RADPS = 0.005, 0.02


@dataclass(frozen=True, slots=True)
class Trial:
    """Which vehicle drives which course under which controller, at which speed, seen by which camera."""

    vehicle: VehicleSpec
    controller: str
    course: RouteCourse
    camera: Camera
    speed_mps: float
    seed: int


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """The truth, every step of the world from the first command to drive on: `seconds` (N,), `poses` (N, 3) in m and rad, the
    `twists` (N, 2) of the rotation centre in m/s and rad/s and the `setpoints` (N, 2) that the agent gave. `arrived`: whether the
    agent said that it had reached the course's end, in time."""

    trial: Trial
    seconds: Array
    poses: Array
    twists: Array
    setpoints: Array
    arrived: bool

    @property
    def duration_s(self) -> float:
        """Until the vehicle stands for good."""
        moves = (np.abs(self.twists[:, 0]) > _MOVES_MPS) | (np.abs(self.twists[:, 1]) > _MOVES_RADPS)
        moving = np.flatnonzero(moves)
        return float(self.seconds[moving[-1]]) if len(moving) else 0.0


def ideal_s(trial: Trial) -> float:
    """The course's length at the set speed, with speeding up and braking at the vehicle's acceleration, as if corners cost
    nothing; and the last turn at its yaw rate."""
    course, limits = trial.course, trial.vehicle.limits
    seconds = course.length_m / trial.speed_mps + trial.speed_mps / limits.acceleration_mps2
    if course.yaw_rad is not None:
        (ax, ay), (bx, by) = course.points[-2:]
        turn = abs(math.remainder(course.yaw_rad - math.atan2(by - ay, bx - ax), math.tau))
        seconds += turn / limits.yaw_rate_radps
    return seconds


def drive(lab: Lab, trial: Trial) -> Track:
    """Drives the course to its end, or until it has taken far too long."""
    return _Drive(lab, trial).run()


class _Guidance:
    """The server's rules for one robot on an empty floor, ten times a second, from what the camera has said."""

    def __init__(self, trial: Trial, area: str) -> None:
        route, waypoints = trial.course.plan(area, trial.speed_mps, RADII_M.get(trial.controller, RADIUS_M))
        plan = resolve(route, waypoints)
        if isinstance(plan, str):
            raise UsageError(f"course {trial.course.name}: no waypoint {plan}")
        self._plan: RoutePlan = plan
        self._parameters = GuidanceParameters()
        self._follower = RouteFollower(self._parameters)
        self._progress = Progress(0, 0)
        self._robot = trial.vehicle.id
        self._speed_mps = trial.speed_mps
        self._sequence = 0
        self._path: tuple[Point, ...] = ()

    def command(self, seen: TrackedPose | None, at_rest: bool, now_ns: int, now_s: float, *, go: bool) -> Command:
        """At the end the last order is kept up: when the robot has done it is the robot's to say."""
        if seen is None or not go:
            return self._command(now_ns, Movement.WAITING)
        sight = Sight(SE2(seen.x, seen.y, seen.yaw), at_rest, now_s)
        progress = self._progress if self._progress.done else self._follower.advance(self._plan, self._progress, sight)
        self._progress = progress
        if progress.done:
            stop = self._plan.stops[-1]
            x, y = stop.point
            final = Target(x=x, y=y, yaw=stop.waypoint.yaw)
            if stop.waypoint.yaw is not None:
                return self._command(now_ns, Movement.ROTATE, final, final=True)
            return self._command(now_ns, Movement.MOVE_TO, final, self._speed_mps, final=True, path=self._path)
        here = extrapolated(seen, (now_ns - seen.stamp_ns) / 1e9)
        goal = self._follower.goal(self._plan, progress.leg, Sight(here, at_rest, now_s), self._speed_mps)
        if goal.turn_to is not None:
            return self._command(now_ns, Movement.ROTATE, goal.target, final=True)
        self._path = self._follower.path_ahead(self._plan, progress.leg, here)
        return self._command(now_ns, Movement.MOVE_TO, goal.target, goal.speed_mps, final=goal.final, path=self._path)

    def _command(
        self,
        now_ns: int,
        movement: Movement,
        target: Target | None = None,
        speed_mps: float = 0.0,
        *,
        final: bool = False,
        path: tuple[Point, ...] = (),
    ) -> Command:
        self._sequence += 1
        return Command(
            robot=self._robot,
            epoch=1,
            sequence=self._sequence,
            stamp_ns=now_ns,
            deadline_ns=now_ns + round(self._parameters.command_lifetime_s * 1e9),
            movement=movement,
            reason=Reason(code=ReasonCode.ROUTE),
            target=target,
            speed_mps=speed_mps,
            final=final,
            path=path,
        )


class _Drive:
    def __init__(self, lab: Lab, trial: Trial) -> None:
        self._trial = trial
        vehicle = trial.vehicle
        alone = lab.model_copy(update={"vehicles": (vehicle,)})
        self._world = World(alone, trial.seed)
        self._rng = np.random.default_rng([trial.seed, 79])
        x, y, yaw = (float(value) for value in self._rng.uniform(-1.0, 1.0, 3) * _START_SPREAD)
        start = trial.course.points[0]
        self._world.place(vehicle.id, SE2(start[0] + x, start[1] + y, yaw))
        self._camera = CeilingCamera(trial.camera, vehicle, trial.seed)
        self._guidance = _Guidance(trial, lab.areas[0].id)
        controller = CONTROLLERS[trial.controller](vehicle)
        self._pilot = Pilot(alone, vehicle, ESTIMATORS[DEFAULT_ESTIMATOR](), controller)
        self._pilot.emergency_stop(EmergencyStop(engaged=False))
        self._seen: TrackedPose | None = None
        self._commands: deque[tuple[int, Command]] = deque()
        self._reading: OdometryReading | None = None
        self._setpoint = Twist(0.0, 0.0)
        self._arrived_s: float | None = None

    def run(self) -> Track:
        world, trial = self._world, self._trial
        step_s = world.step_s
        every = {
            name: round(1.0 / (rate * step_s)) for name, rate in (("control", CONTROL_RATE_HZ), ("guidance", 10.0))
        }
        longest_s = WAIT_S + _SLOWEST_RATIO * ideal_s(trial) + _SPARE_S
        rows: list[tuple[float, ...]] = []
        step = 0
        while step * step_s < longest_s:
            step += 1
            world.step()
            now_ns, now_s = world.stamp_ns, step * step_s
            true = world.truth().vehicles[trial.vehicle.id]
            self._look(true, now_ns, now_s)
            if step % every["guidance"] == 0:
                self._guide(now_ns, now_s)
            if step % 2 == 0:
                self._read()
            if step % every["control"] == 0:
                self._control(now_ns, now_s)
            if now_s >= WAIT_S:
                given = self._setpoint
                rows.append(
                    (
                        now_s - WAIT_S,
                        true.x,
                        true.y,
                        true.yaw,
                        true.linear_mps,
                        true.angular_radps,
                        given.linear_mps,
                        given.angular_radps,
                    )
                )
            if self._arrived_s is not None and now_s - self._arrived_s > _STANDS_S:
                break
        table = np.array(rows)
        poses = table[:, 1:4].copy()
        poses[:, 2] = np.unwrap(poses[:, 2])
        return Track(trial, table[:, 0], poses, table[:, 4:6], table[:, 6:8], self._arrived_s is not None)

    def _look(self, true: TruePose, now_ns: int, now_s: float) -> None:
        for pose in self._camera.look(true, now_ns, now_s):
            self._pilot.camera_pose(pose, now_ns, now_s)
            if self._seen is None or pose.stamp_ns > self._seen.stamp_ns:
                self._seen = pose

    def _guide(self, now_ns: int, now_s: float) -> None:
        """Sends a command; takes those that have arrived."""
        reading = self._reading
        at_rest = (
            reading is not None
            and abs(reading.twist.linear_mps) < _REST_MPS
            and abs(reading.twist.angular_radps) < _REST_RADPS
        )
        command = self._guidance.command(self._seen, at_rest, now_ns, now_s, go=now_s >= WAIT_S)
        delay_s = COMMAND_DELAY_S * (1.0 + float(self._rng.uniform(-_JITTER, _JITTER)))
        if self._rng.random() >= COMMAND_LOSS:
            self._commands.append((now_ns + round(delay_s * 1e9), command))

    def _read(self) -> None:
        """A base reports fifty times a second; the agent has the newest report."""
        said = self._world.odometry(self._trial.vehicle.id)
        twist = Twist(said.linear_mps, said.angular_radps)
        self._reading = OdometryReading(said.stamp_ns, said.session, SE2(said.x, said.y, said.yaw), twist)

    def _control(self, now_ns: int, now_s: float) -> None:
        while self._commands and self._commands[0][0] <= now_ns:
            self._pilot.command(self._commands.popleft()[1], now_ns, now_s)
        if self._reading is not None:
            self._pilot.odometry(self._reading)
        decision = self._pilot.decide(now_ns, now_s)
        self._setpoint = decision.twist
        self._world.set_drive(self._trial.vehicle.id, decision.twist.linear_mps, decision.twist.angular_radps)
        for response in decision.responses:
            ends = response.movement is (
                Movement.ROTATE if self._trial.course.yaw_rad is not None else Movement.MOVE_TO
            )
            if response.outcome is Outcome.REACHED and ends and self._arrived_s is None:
                self._arrived_s = now_s
