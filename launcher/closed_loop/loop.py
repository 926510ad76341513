"""The closed loop itself: who does what when, and how long everything takes on the way.

The latencies stand for the deployed system: a frame that is captured now becomes a pose at the robot `pose_s` later and a raster
`raster_s` later, for frames `raster_period_s` apart; the mapper merges at 10 Hz and guidance decides at 10 Hz, each from what it
has then; a command is `command_s` on its way, and the robot acts on it in the next round of its control loop.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from msgspec.structs import replace
from shapely.geometry.base import BaseGeometry

from agents.estimation import DEFAULT_ESTIMATOR
from agents.motion import Twist
from lab.world import World
from launcher.closed_loop.agent import SimulatedAgent
from launcher.closed_loop.links import Link
from launcher.closed_loop.sight import Sight
from launcher.closed_loop.store import SimulatedStore
from protocol.lab import Lab
from protocol.messages import Command, EmergencyStop, FloorRaster, Status, TrackedPose
from server.guidance.fleet import Guidance
from server.guidance.parameters import GuidanceParameters
from server.guidance.snapshot import Outcome


@dataclass(frozen=True, slots=True)
class Latencies:
    """Seconds. `pose_s`: from capture to the robot and to Redis; `raster_s`: from capture to the mapper."""

    pose_period_s: float = 1 / 15
    pose_s: float = 0.09
    raster_period_s: float = 2 / 15
    raster_s: float = 0.15
    mapper_period_s: float = 0.1
    guidance_period_s: float = 0.1
    command_s: float = 0.03
    control_period_s: float = 0.05
    status_period_s: float = 0.1
    status_s: float = 0.01
    drive_s: float = 0.001


class Beat:
    """Says when something that happens every `period_s` is due, from `phase` (0 to 1) of a period on."""

    def __init__(self, period_s: float, phase: float) -> None:
        self._period_s, self._next_s = period_s, phase * period_s

    def due(self, now_s: float) -> bool:
        if now_s + 1e-9 < self._next_s:
            return False
        self._next_s += self._period_s
        return True


class Robot:
    """One robot's ends: its agent (None while it is dead) and its links."""

    def __init__(self, number: int, seed: int, times: Latencies, phase: float, scan_period_s: float | None) -> None:
        self.agent: SimulatedAgent | None = None
        self.poses = Link[TrackedPose]([seed, number, 1], times.pose_s)
        self.stream = Link[Command | EmergencyStop]([seed, number, 2], times.command_s, stream=True)
        self.statuses = Link[Status]([seed, number, 3], times.status_s)
        self.drives = Link[Twist]([seed, number, 4], times.drive_s)
        self.stream_open = False
        self.control = Beat(times.control_period_s, phase)
        self.report = Beat(times.status_period_s, phase)
        self.scanner = None if scan_period_s is None else Beat(scan_period_s, phase)


class ClosedLoop:
    """Steps through the world's time. What may fail: `server_up`, `intake_up`, `guidance_up`, `tracker_up`, the store's `up`, the
    sight's `dark` cameras, each robot's agent, its links, and the links between the others: `tracked` from the cameras by way
    of the tracker to Redis, `rasters` from the cameras to the mapper, `orders` from guidance to the server. `obstacles_seen` is
    false where no camera is to see what stands on the floor."""

    def __init__(
        self,
        lab: Lab,
        seed: int,
        *,
        latencies: Latencies | None = None,
        parameters: GuidanceParameters | None = None,
        scanners: bool = True,
        range_sensors: bool = True,
        estimator: str = DEFAULT_ESTIMATOR,
    ) -> None:
        self.lab, self.seed = lab, seed
        self.times = latencies or Latencies()
        self.world = World(lab, seed)
        self.store, self.sight = SimulatedStore(), Sight(lab, seed)
        self.server_up = self.intake_up = self.guidance_up = self.tracker_up = True
        self.obstacles_seen = True
        self.outcome: Outcome | None = None
        self.now_s = 0.0
        self._parameters, self._estimator, self._range_sensors = parameters, estimator, range_sensors
        self._guidance: Guidance | None = None
        self.rasters = Link[FloorRaster]([seed, 1], self.times.raster_s)
        self._raster: FloorRaster | None = None
        self.tracked = Link[dict[str, TrackedPose]]([seed, 2], self.times.pose_s, stream=True)
        self.orders = Link[Command]([seed, 3], 0.0, stream=True)
        self._phase = (seed * 0.618034) % 1.0
        times, phase = self.times, self._phase
        self._frames = Beat(times.pose_period_s, phase)
        self._looks = Beat(times.raster_period_s, (phase + 0.3) % 1.0)
        self._merges = Beat(times.mapper_period_s, (phase * 7) % 1.0)
        self._cycles = Beat(times.guidance_period_s, (phase * 13) % 1.0)
        self.robots: dict[str, Robot] = {}
        for number, name in enumerate(self.world.vehicle_ids):
            scanner = lab.vehicle(name).scanner if scanners else None
            period_s = None if scanner is None else 1.0 / scanner.rate_hz
            self.robots[name] = Robot(number, seed, times, (phase * (number + 2) * 3) % 1.0, period_s)
            self.start_agent(name)

    @property
    def now_ns(self) -> int:
        return self.world.stamp_ns

    def start_agent(self, name: str) -> None:
        """An agent that knows nothing yet."""
        robot = self.robots[name]
        sequence = round(self.now_s * 1000)

        def send(twist: Twist) -> None:
            robot.drives.send(twist, self.now_s)

        robot.agent = SimulatedAgent(
            self.lab, self.lab.vehicle(name), send, sequence=sequence, estimator=self._estimator
        )
        robot.stream_open = False

    def kill_agent(self, name: str) -> None:
        robot = self.robots[name]
        robot.agent = None
        robot.drives.clear()
        robot.stream.clear()

    def kill_guidance(self) -> None:
        """The process is gone, with all that it remembered."""
        self.guidance_up, self._guidance = False, None

    def run(self, seconds: float, each_step: Callable[[], None] | None = None) -> None:
        for _ in range(round(seconds / self.world.step_s)):
            self.step()
            if each_step is not None:
                each_step()

    def step(self) -> None:
        """One step of the world, and all that happens at its end."""
        self.world.step()
        self.now_s += self.world.step_s
        self._look()
        self._guide()
        self._forward()
        for name, robot in self.robots.items():
            self._serve(robot)
            for status in robot.statuses.due(self.now_s):
                if self.intake_up and self.store.up:
                    self.store.statuses[name] = status
            if robot.agent is not None:
                self._act(name, robot, robot.agent)
            for twist in robot.drives.due(self.now_s):
                self.world.set_drive(name, twist.linear_mps, twist.angular_radps)

    def _look(self) -> None:
        """Cameras, tracker and mapper."""
        if self._frames.due(self.now_s) and self.tracker_up:
            seen = self.sight.poses(self.world.truth().vehicles, self.now_ns)
            self.tracked.send(seen, self.now_s)
            for name, pose in seen.items():
                self.robots[name].poses.send(pose, self.now_s)
        for seen in self.tracked.due(self.now_s):
            if self.store.up:
                self.store.poses.update(seen)
        if self._looks.due(self.now_s):
            self.rasters.send(self.sight.raster(self._outlines(), self.now_ns), self.now_s)
        for raster in self.rasters.due(self.now_s):
            self._raster = raster
        if self._merges.due(self.now_s) and self._raster is not None and self.store.up:
            self.store.obstacles = self._raster

    def _outlines(self) -> Sequence[BaseGeometry]:
        return self.world.object_outlines() if self.obstacles_seen else []

    def _guide(self) -> None:
        if not self._cycles.due(self.now_s) or not self.guidance_up or not self.store.up:
            return
        if self._guidance is None:
            self._guidance = Guidance(self.lab, self._parameters)
            self.store.epoch += 1
        self.outcome = self._guidance.cycle(self.store.snapshot(self.now_ns, self.now_s), self.store.epoch)
        self.store.change(self.outcome.changes)
        for command in self.outcome.commands.values():
            self.orders.send(command, self.now_s)

    def _forward(self) -> None:
        """The server hands commands, which it has from guidance by way of Redis, to the robots' streams."""
        for command in self.orders.due(self.now_s):
            robot = self.robots.get(command.robot)
            if robot is not None and robot.stream_open and self.store.up:
                robot.stream.send(command, self.now_s)

    def _serve(self, robot: Robot) -> None:
        """The server's stream to one robot: it begins with the state of the emergency stop."""
        if not self.server_up or robot.agent is None or robot.stream.cut:
            robot.stream_open = False
            if not self.server_up:
                robot.stream.clear()
        elif not robot.stream_open and self.store.up:
            robot.stream_open = True
            robot.stream.send(self.store.emergency_stop, self.now_s)

    def _act(self, name: str, robot: Robot, agent: SimulatedAgent) -> None:
        now_ns, now_s = self.now_ns, self.now_s
        agent.see(robot.poses.due(now_s), now_ns, now_s)
        agent.hear(robot.stream.due(now_s), now_ns, now_s)
        if robot.scanner is not None and robot.scanner.due(now_s):
            agent.scan(self.world.scan(name), now_s)
        if robot.control.due(now_s):
            said = self.world.odometry(name)
            agent.control(said if self._range_sensors else replace(said, range_front_m=None), now_ns, now_s)
        if robot.report.due(now_s):
            robot.statuses.send(agent.status(now_ns, now_s), now_s)
