"""The fault table (docs/safety.md): ten robots drive their routes while one part after the other fails. No robot moves
farther than its dead-man's distance without authority, robots say why they stand, and every route is finished in the end.

The agents' and guidance's code is the real one; processes and networks are simulated (`launcher.closed_loop`), in simulated
time. `tests/e2e/test_kill.py` kills the real processes.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from launcher.closed_loop import ClosedLoop, Latencies, Link
from launcher.experiments.fleets import with_fleet
from protocol.channels import STATUSES
from protocol.lab import Lab, load_lab
from protocol.messages import AssignmentState, Command, EmergencyStop, Movement, ReasonCode

ROBOTS = 10
SPEED_MPS = 0.3
COLUMNS = 5
STANDING_S, AGAIN_S = 0.6, 4.0
"""How long a fault lasts beyond its limit, and within what time after its end robots must drive again."""
TIMES = Latencies(pose_period_s=2 / 15, guidance_period_s=0.2)
"""Rarer than deployed, and the cheaper estimator, for speed."""
DEAD_MAN_S = 0.5
"""Limit of a command's and a pose's age."""
LATE_S = 0.05 + 0.09 + 0.04
"""A round of the control loop, what is on its way already, the motors' delay and a step of the world."""
WATCHDOG_S = 0.3
"""Of the base itself."""
TOLD_S = DEAD_MAN_S + TIMES.guidance_period_s
UNHEARD_S = STATUSES.stale_after_s + TIMES.guidance_period_s
"""Where guidance has to notice that a pose, or a status, is too old: until the cycle after that."""
MOVES = (Movement.MOVE_TO, Movement.ROTATE, Movement.DRIVE)


def lab() -> Lab:
    """The shipped room with ten robots, each alone in a tenth of it; coarser steps than usual, for speed."""
    found = with_fleet(load_lab("labs/gulliver.yaml"), ROBOTS)
    starts = {vehicle.id: (*corners(number)[0], 0.0) for number, vehicle in enumerate(found.vehicles)}
    vehicles = tuple(v.model_copy(update={"scanner": None}) for v in found.vehicles)
    simulation = found.simulation.model_copy(update={"starts": starts, "step_s": 0.025})
    return found.model_copy(update={"vehicles": vehicles, "simulation": simulation})


def corners(number: int) -> list[tuple[float, float]]:
    """Of the robot's round."""
    x, y = 0.3 + 1.7 * (number % COLUMNS), 0.4 + 2.2 * (number // COLUMNS)
    return [(x, y), (x + 0.9, y), (x + 0.9, y + 1.4), (x, y + 1.4)]


def dead_man_m(seconds: float, braking_mps2: float) -> float:
    """The way at full speed for so long, and the way to stand."""
    return SPEED_MPS * (seconds + LATE_S) + SPEED_MPS**2 / (2 * braking_mps2)


class Watch:
    """Adds up how far each robot goes without a moving command of its own guidance and a picture of it that are fresh; and, from
    `since` on, how far those go that cannot be reached at all."""

    def __init__(self, loop: ClosedLoop) -> None:
        self.violations: list[str] = []
        self._loop = loop
        self._ordered = dict.fromkeys(loop.robots, -9.0)
        self._seen = dict.fromkeys(loop.robots, -9.0)
        self._without_m = dict.fromkeys(loop.robots, 0.0)
        self._outcome: object = None

    def look(self) -> None:
        loop = self._loop
        if loop.outcome is not None and loop.outcome is not self._outcome:
            self._outcome = loop.outcome
            for name, command in loop.outcome.commands.items():
                if command.movement in MOVES:
                    self._ordered[name] = loop.now_s
        for name, pose in loop.world.truth().vehicles.items():
            if loop.tracker_up and loop.sight.camera_at(pose.x) not in loop.sight.dark:
                self._seen[name] = loop.now_s
            authority_s = min(self._ordered[name], self._seen[name])
            if loop.now_s - authority_s <= DEAD_MAN_S:
                self._without_m[name] = 0.0
                continue
            self._without_m[name] += abs(pose.linear_mps) * loop.world.step_s
            limit_m = dead_man_m(0.0, loop.lab.vehicle(name).limits.braking_mps2)
            if self._without_m[name] > limit_m:
                self.violations.append(f"{loop.now_s:.2f} s: {name} went {self._without_m[name]:.3f} m on its own")


@dataclass(frozen=True, slots=True)
class Fault:
    """A row of the table. `cut_off`: the robots that nobody can reach meanwhile; they stand after the way of `limit_s`, and
    those that can still speak say one of `reasons`."""

    name: str
    begin: Callable[[ClosedLoop], None]
    end: Callable[[ClosedLoop], None]
    cut_off: Callable[[ClosedLoop], Sequence[str]]
    reasons: tuple[ReasonCode, ...] = ()
    limit_s: float = DEAD_MAN_S

    @property
    def lasts_s(self) -> float:
        return self.limit_s + STANDING_S


def everybody(loop: ClosedLoop) -> list[str]:
    return list(loop.robots)


def nobody(loop: ClosedLoop) -> list[str]:
    return []


def numbered(*numbers: int) -> Callable[[ClosedLoop], list[str]]:
    return lambda loop: [list(loop.robots)[number] for number in numbers]


def in_view(camera: str) -> Callable[[ClosedLoop], list[str]]:
    """Robots that only this camera sees, and that cannot leave its view meanwhile."""

    def found(loop: ClosedLoop) -> list[str]:
        poses = loop.world.truth().vehicles
        return [n for n, p in poses.items() if all(loop.sight.camera_at(p.x + d) == camera for d in (-0.3, 0.0, 0.3))]

    return found


def set_to(name: str, value: bool) -> Callable[[ClosedLoop], None]:
    return lambda loop: setattr(loop, name, value)


def redis_is(up: bool) -> Callable[[ClosedLoop], None]:
    return lambda loop: setattr(loop.store, "up", up)


def guidance_dies(loop: ClosedLoop) -> None:
    loop.kill_guidance()


def agents_die(loop: ClosedLoop) -> None:
    for name in numbered(0, 3, 6)(loop):
        loop.kill_agent(name)


def agents_start(loop: ClosedLoop) -> None:
    for name in numbered(0, 3, 6)(loop):
        loop.start_agent(name)


def darkness(*cameras: str) -> Callable[[ClosedLoop], None]:
    return lambda loop: setattr(loop.sight, "dark", set(cameras))


def one_way_cuts(cut: bool) -> Callable[[ClosedLoop], None]:
    """Poses to robots 0 to 2, commands to 3 to 5, statuses from 6 and 7, set-points to the bases of 8 and 9."""

    def act(loop: ClosedLoop) -> None:
        for link in _links(loop):
            link.cut = cut

    return act


def losses(share: float) -> Callable[[ClosedLoop], None]:
    def act(loop: ClosedLoop) -> None:
        for link in (*_links(loop, all_robots=True), loop.tracked, loop.orders, loop.rasters):
            link.loss = share

    return act


def delays(seconds: float) -> Callable[[ClosedLoop], None]:
    def act(loop: ClosedLoop) -> None:
        for link in _links(loop):
            link.more_delay_s = seconds

    return act


def between_servers(name: str, *, cut: bool = False) -> Callable[[ClosedLoop], None]:
    return lambda loop: setattr(getattr(loop, name), "cut", cut)


def servers_are_late(seconds: float) -> Callable[[ClosedLoop], None]:
    """From the tracker to Redis, and from guidance to the server."""

    def act(loop: ClosedLoop) -> None:
        loop.tracked.more_delay_s = loop.orders.more_delay_s = seconds

    return act


def _links(loop: ClosedLoop, *, all_robots: bool = False) -> list[Link[object]]:
    found: list[Link[object]] = []
    for number, robot in enumerate(loop.robots.values()):
        own: list[Link[object]] = [robot.poses, robot.stream, robot.statuses, robot.drives]  # pyright: ignore[reportAssignmentType]  # whatever they carry
        found += own if all_robots else [own[0 if number < 3 else 1 if number < 6 else 2 if number < 8 else 3]]
    return found


STALE = (ReasonCode.COMMAND_STALE, ReasonCode.POSE_STALE)
TABLE = (
    Fault("server dies", set_to("server_up", False), set_to("server_up", True), everybody, STALE),
    Fault("intake dies", set_to("intake_up", False), set_to("intake_up", True), everybody, limit_s=UNHEARD_S),
    Fault("guidance dies", guidance_dies, set_to("guidance_up", True), everybody, STALE),
    Fault("Redis dies", redis_is(False), redis_is(True), everybody, STALE),
    Fault("tracker dies", set_to("tracker_up", False), set_to("tracker_up", True), everybody, (ReasonCode.POSE_STALE,)),
    Fault("camera 1 is dark", darkness("cam1"), darkness(), in_view("cam1"), (ReasonCode.POSE_STALE,)),
    Fault("three agents die", agents_die, agents_start, numbered(0, 3, 6), limit_s=WATCHDOG_S),
    Fault("one-way cuts", one_way_cuts(True), one_way_cuts(False), numbered(0, 1, 2, 3, 4, 5, 8, 9), STALE),
    Fault("30 % loss everywhere", losses(0.3), losses(0.0), nobody),
    Fault("300 ms delay", delays(0.3), delays(0.0), nobody),
    Fault(
        "tracker to Redis cut",
        between_servers("tracked", cut=True),
        between_servers("tracked"),
        everybody,
        limit_s=TOLD_S,
    ),
    Fault("guidance to server cut", between_servers("orders", cut=True), between_servers("orders"), everybody, STALE),
    Fault("300 ms delay between servers", servers_are_late(0.3), servers_are_late(0.0), nobody),
    Fault("cameras to mapper cut", between_servers("rasters", cut=True), between_servers("rasters"), nobody),
)


def test_whatever_fails_no_robot_moves_without_authority_and_every_route_is_finished() -> None:
    loop = ClosedLoop(lab(), 1, latencies=TIMES, estimator="exponential")
    watch = Watch(loop)
    for number, name in enumerate(loop.robots):
        first, *others = corners(number)
        loop.store.assign(name, [*others, first, others[0]], SPEED_MPS, loop.now_ns)
    loop.run(2.0, watch.look)
    for fault in TABLE:
        _suffer(loop, watch, fault)
    durable = dict(loop.store.waypoints), dict(loop.store.routes)
    while loop.now_s < 150.0 and any(a.state is AssignmentState.RUNNING for a in loop.store.assignments.values()):
        loop.run(0.5, watch.look)
    assert {a.robot: a.state for a in loop.store.assignments.values()} == dict.fromkeys(
        loop.robots, AssignmentState.DONE
    )
    assert watch.violations == []
    assert loop.world.truth().contacts == 0
    assert (loop.store.waypoints, loop.store.routes) == durable


def _suffer(loop: ClosedLoop, watch: Watch, fault: Fault) -> None:
    """The fault, from when robots drive until its end."""
    _wait_until_they_drive(loop, watch, fault.name)
    way_m = dict.fromkeys(fault.cut_off(loop), 0.0)

    def add() -> None:
        watch.look()
        for name in way_m:
            way_m[name] += abs(loop.world.truth().vehicles[name].linear_mps) * loop.world.step_s

    fault.begin(loop)
    loop.run(fault.lasts_s, add)
    for name, way in way_m.items():
        assert way <= dead_man_m(fault.limit_s, loop.lab.vehicle(name).limits.braking_mps2), f"{fault.name}: {name}"
        assert loop.world.truth().vehicles[name].linear_mps == 0.0, f"{fault.name}: {name}"
    for robot in (loop.robots[name] for name in way_m):
        decision = None if robot.agent is None else robot.agent.decision
        if fault.reasons and decision is not None and not robot.drives.cut:
            assert decision.stopped_by is not None and decision.stopped_by.code in fault.reasons, fault.name
            assert decision.stopped_by.since_ns is not None
            assert 0 < loop.now_ns - decision.stopped_by.since_ns < fault.lasts_s * 1e9
    fault.end(loop)


def _wait_until_they_drive(loop: ClosedLoop, watch: Watch, before: str) -> None:
    """All but two, which may stand at a corner."""
    until_s = loop.now_s + AGAIN_S
    while (
        sum(abs(p.linear_mps) + abs(p.angular_radps) > 0.05 for p in loop.world.truth().vehicles.values()) < ROBOTS - 2
    ):
        assert loop.now_s < until_s, f"they do not drive again before: {before}"
        loop.run(0.1, watch.look)


def test_robots_that_hold_a_broadcast_stop_keep_it_through_the_restart_of_everything() -> None:
    loop = ClosedLoop(lab(), 2, latencies=TIMES, estimator="exponential")
    for number, name in enumerate(loop.robots):
        first, *others = corners(number)
        loop.store.assign(name, [*others, first], SPEED_MPS, loop.now_ns)
    loop.run(2.0)
    loop.server_up = False
    stop = EmergencyStop(engaged=True, epoch=loop.now_ns // 1_000_000, by="anna")
    heard: Sequence[Command | EmergencyStop] = [stop]
    for robot in loop.robots.values():
        assert robot.agent is not None
        robot.agent.hear(heard, loop.now_ns, loop.now_s)
    before = loop.world.truth().vehicles
    loop.run(0.5)
    after = loop.world.truth().vehicles
    for name in loop.robots:
        way_m = math.dist((before[name].x, before[name].y), (after[name].x, after[name].y))
        assert way_m < 0.06, f"{name} brakes at once, not after its dead-man's time"
    loop.server_up = True
    loop.run(2.0)
    assert all(pose.linear_mps == 0.0 for pose in loop.world.truth().vehicles.values())
    assert all(status.stop_epoch == stop.epoch for status in loop.store.statuses.values()), "which tells the server"
