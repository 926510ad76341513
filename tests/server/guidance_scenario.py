"""A small world for guidance's tests: a lab, a snapshot builder, and robots that obey as the real ones do."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from msgspec import structs
from shapely.geometry import Polygon

from agents.control import Executor
from agents.control.gpss import GpssController
from agents.motion import Twist
from geometry import SE2
from mapping.grid import FloorGrid
from protocol.channels import LAB_INSTANCE
from protocol.lab import Lab, load_lab
from protocol.messages import (
    Assignment,
    AssignmentState,
    Command,
    EmergencyStop,
    FloorRaster,
    Leg,
    ManualDrive,
    Movement,
    RobotSettings,
    Route,
    SpeedZone,
    Status,
    TrackedPose,
    Waypoint,
)
from server.guidance.fleet import Guidance
from server.guidance.parameters import GuidanceParameters
from server.guidance.snapshot import Outcome, Snapshot

START_NS = 1_700_000_000_000_000_000
LAB = load_lab("labs/gulliver.yaml")
ROBOT, OTHER = "wifibot-14", "wifibot-15"


def raster(
    pallets: Sequence[Sequence[tuple[float, float]]] = (), stamp_ns: int = START_NS, lab: Lab = LAB
) -> FloorRaster:
    """Everything seen; occupied where a pallet (polygon, metres) is."""
    return structs.replace(_raster(tuple(map(tuple, pallets)), lab.bounds()), stamp_ns=stamp_ns)


@lru_cache(maxsize=64)
def _raster(
    pallets: tuple[tuple[tuple[float, float], ...], ...], bounds: tuple[float, float, float, float]
) -> FloorRaster:
    grid = FloorGrid.covering(bounds)
    occupied = np.zeros_like(grid.occupied)
    rows, columns = np.indices(occupied.shape)
    for pallet in pallets:
        x = grid.origin_x + (columns + 0.5) * grid.cell_m
        y = grid.origin_y + (rows + 0.5) * grid.cell_m
        low_x, low_y, high_x, high_y = Polygon(pallet).bounds
        half = grid.cell_m / 2
        occupied |= (x > low_x - half) & (x < high_x + half) & (y > low_y - half) & (y < high_y + half)
    return grid.with_cells(occupied, np.ones_like(occupied)).to_raster(LAB_INSTANCE, START_NS)


def square(x: float, y: float, side: float = 0.4) -> list[tuple[float, float]]:
    half = side / 2
    return [(x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)]


def tracked(
    robot: str, x: float, y: float, yaw: float = 0.0, stamp_ns: int = START_NS, speed: float = 0.0
) -> TrackedPose:
    covariance = (1e-5, 0.0, 0.0, 1e-5, 0.0, 1e-4)
    vx, vy = speed * math.cos(yaw), speed * math.sin(yaw)
    return TrackedPose(robot, stamp_ns, x, y, yaw, vx, vy, 0.0, covariance, ("cam0",), "camp")


def status(robot: str, stamp_ns: int = START_NS, linear: float = 0.0, angular: float = 0.0) -> Status:
    return Status(robot=robot, sequence=1, stamp_ns=stamp_ns, linear_mps=linear, angular_radps=angular)


def assignment(
    robot: str = ROBOT, state: AssignmentState = AssignmentState.RUNNING, route: str = "r", leg: int = 0
) -> Assignment:
    return Assignment(
        id=f"{robot}-{route}", robot=robot, route=route, state=state, leg=leg, started_ns=START_NS, changed_ns=START_NS
    )


@dataclass(slots=True)
class Course:
    """Waypoints w0, w1, ... and the route `r` through them."""

    points: Sequence[tuple[float, float]]
    radius: float = 0.15
    speed: float = 0.3
    loop: bool = False
    yaws: Mapping[int, float] = field(default_factory=dict[int, float])
    legs: Mapping[int, Mapping[str, Any]] = field(default_factory=dict[int, Mapping[str, Any]])
    """More of single legs: stays, actions, movements."""

    def waypoints(self) -> dict[str, Waypoint]:
        return {
            f"w{i}": Waypoint(id=f"w{i}", area="camp", x=x, y=y, radius_m=self.radius, yaw=self.yaws.get(i))
            for i, (x, y) in enumerate(self.points)
        }

    def routes(self) -> dict[str, Route]:
        legs = tuple(
            Leg(waypoint=f"w{i}", speed_mps=self.speed, **self.legs.get(i, {})) for i in range(len(self.points))
        )
        return {"r": Route(id="r", legs=legs, loop=self.loop)}


class Robot:
    """A robot on the floor: late motors, limited acceleration, the report's controller, its own dead-man's switch."""

    def __init__(self, robot: str, x: float, y: float, yaw: float = 0.0) -> None:
        self.id = robot
        self.limits = LAB.vehicle(robot).limits
        self.pose = SE2(x, y, yaw)
        self.twist = Twist(0.0, 0.0)
        self._executor = Executor(GpssController(self.limits), self.limits)
        self.command: Command | None = None

    def step(self, now_ns: int, dt: float) -> None:
        wanted = Twist(0.0, 0.0)
        if self.command is not None and now_ns <= self.command.deadline_ns:
            wanted = self._executor.execute(self.command, self.pose, self.twist, now_ns / 1e9).twist
        rise = (
            self.limits.acceleration_mps2 if wanted.linear_mps > self.twist.linear_mps else self.limits.braking_mps2
        ) * dt
        turn = self.limits.yaw_acceleration_radps2 * dt
        v = self.twist.linear_mps + min(rise, max(-rise, wanted.linear_mps - self.twist.linear_mps))
        w = self.twist.angular_radps + min(turn, max(-turn, wanted.angular_radps - self.twist.angular_radps))
        self.twist = Twist(v, w)
        self.pose = self.pose @ SE2.exp(v * dt, 0.0, w * dt)

    def seen(self, stamp_ns: int) -> TrackedPose:
        vx, vy = self.twist.linear_mps * math.cos(self.pose.yaw), self.twist.linear_mps * math.sin(self.pose.yaw)
        covariance = (1e-5, 0.0, 0.0, 1e-5, 0.0, 1e-4)
        pose = self.pose
        return TrackedPose(
            self.id, stamp_ns, pose.x, pose.y, pose.yaw, vx, vy, self.twist.angular_radps, covariance, ("cam0",), "camp"
        )


class Simulation:
    """Robots and guidance in a closed loop: poses at 15 Hz, 70 ms old when they arrive; commands at 10 Hz, 40 ms on the way;
    an obstacle on the raster 200 ms after it came."""

    def __init__(
        self, course: Course, robots: Sequence[Robot], parameters: GuidanceParameters | None = None, lab: Lab = LAB
    ) -> None:
        self.course, self.robots = course, {robot.id: robot for robot in robots}
        self.parameters, self.lab = parameters, lab
        self.guidance = Guidance(lab, parameters)
        self.waypoints, self.routes = course.waypoints(), course.routes()
        self.assignments = {robot.id: assignment(robot.id) for robot in robots}
        self.settings: dict[str, RobotSettings] = {}
        self.speed_zones: dict[str, SpeedZone] = {}
        self.battery: float | None = None
        self.pallets: list[list[tuple[float, float]]] = []
        self.emergency_stop: EmergencyStop | None = None
        self.manual: dict[str, ManualDrive] = {}
        self.nearest: dict[str, list[float]] = {robot.id: [math.inf] * len(course.points) for robot in robots}
        self.events: list[str] = []
        self.outcome: Outcome | None = None
        self.elapsed_s = 0.0
        self._ticks = 0
        self._poses: list[tuple[float, dict[str, TrackedPose]]] = []
        self._commands: list[tuple[float, dict[str, Command]]] = []
        self._rasters: list[tuple[float, list[list[tuple[float, float]]]]] = []
        self._known_poses: dict[str, TrackedPose] = {}
        self._known_pallets: list[list[tuple[float, float]]] = []

    @property
    def now_ns(self) -> int:
        return START_NS + round(self.elapsed_s * 1e9)

    def restart_guidance(self) -> None:
        """Another process takes over: nothing is remembered but what is durable."""
        self.guidance = Guidance(self.lab, self.parameters)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.01)):
            self._tick()

    def run_until_over(self, robot: str = ROBOT, limit_s: float = 120.0) -> AssignmentState:
        while self.elapsed_s < limit_s and self.assignments[robot].state is AssignmentState.RUNNING:
            self._tick()
        return self.assignments[robot].state

    def _tick(self) -> None:
        now_s, self._ticks = self.elapsed_s, self._ticks + 1
        if self._ticks % 7 == 1:
            seen = {name: robot.seen(self.now_ns) for name, robot in self.robots.items()}
            self._poses.append((now_s + 0.07, seen))
        if self._ticks % 10 == 1:
            self._rasters.append((now_s + 0.2, list(self.pallets)))
        while self._poses and self._poses[0][0] <= now_s:
            self._known_poses = self._poses.pop(0)[1]
        while self._rasters and self._rasters[0][0] <= now_s:
            self._known_pallets = self._rasters.pop(0)[1]
        if self._ticks % 10 == 5:
            self.outcome = self.guidance.cycle(self.snapshot(), epoch=1)
            for change in self.outcome.changes:
                self.assignments[change.before.robot] = change.after
            self.events += [f"{event.kind}: {event.text}" for event in self.outcome.events]
            self._commands.append((now_s + 0.04, dict(self.outcome.commands)))
        while self._commands and self._commands[0][0] <= now_s:
            for name, command in self._commands.pop(0)[1].items():
                if name in self.robots:
                    self.robots[name].command = command
        for name, robot in self.robots.items():
            robot.step(self.now_ns, 0.01)
            # What counts as reaching a waypoint is being there while driving towards it.
            leg = self.assignments[name].leg
            x, y = self.course.points[leg]
            self.nearest[name][leg] = min(self.nearest[name][leg], math.hypot(robot.pose.x - x, robot.pose.y - y))
        self.elapsed_s += 0.01

    def snapshot(self) -> Snapshot:
        statuses = {
            name: status(name, self.now_ns, robot.twist.linear_mps, robot.twist.angular_radps).model_copy(
                update={"battery": self.battery}
            )
            for name, robot in self.robots.items()
        }
        return Snapshot(
            now_ns=self.now_ns,
            now_s=self.elapsed_s,
            poses=self._known_poses,
            statuses=statuses,
            manual=self.manual,
            emergency_stop=self.emergency_stop,
            obstacles=raster(self._known_pallets, self.now_ns),
            waypoints=self.waypoints,
            routes=self.routes,
            assignments=self.assignments,
            settings=self.settings,
            speed_zones=self.speed_zones,
        )

    def movement(self, robot: str = ROBOT) -> Movement:
        assert self.outcome is not None
        return self.outcome.commands[robot].movement
