"""One scene after the other in the closed loop: when the thing came into a field, when the wheels stood, whether it was hit."""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from agents.motion import STOP, Twist
from agents.protection import Outline, braking_sweep, in_the_way
from geometry import SE2
from launcher.closed_loop import ClosedLoop
from launcher.experiments.obstacle_scenes import THING, Scene
from protocol.lab import Lab
from protocol.messages import Movement, ReasonCode, SimulatedObject, TruePose

_MOST_S = 6.0
"""After the thing came: the slowest robot has reached it by then."""
_STOOD_S = 1.0
"""How long a robot is watched once it stands."""
_RESUME_S = 3.0
_STILL_MPS, _STILL_RADPS = 0.005, 0.01
_MOVES_MPS = 0.05
_HALTS_M = 0.06
"""A person who has come this near to the robot goes no farther."""
_WARM_S = 2.0
_ROUND_MPS = 0.45
"""On the empty floor, or as fast as the vehicle can."""


class Watcher(StrEnum):
    """Who may stop the robot: everything, as deployed; the cameras alone (it has neither scanner nor range sensor); or the
    scanner alone (no camera sees the thing, and there is no range sensor)."""

    BOTH = "both"
    CAMERA = "camera"
    SCANNER = "scanner"


@dataclass(frozen=True, slots=True)
class Trial:
    """What became of a scene. `reaction_s` is from the instant at which the thing was in the field of those who watch (the
    obstacle box of guidance, the protective field of the agent; the first of them for both) until the wheels stood; None when
    the robot never had to stop. `gap_m` is the least distance from the thing, `resumed` whether the robot drove on when it
    was taken away (None: not tried)."""

    seed: int
    kind: str
    watcher: Watcher
    speed_mps: float
    contacts: int
    reaction_s: float | None
    gap_m: float
    resumed: bool | None = None


@dataclass(slots=True)
class _Seen:
    """What has happened so far in a trial."""

    entered_s: float | None = None
    stood_s: float | None = None
    still_since_s: float | None = None
    gap_m: float = math.inf


def conduct(lab: Lab, scene: Scene, watcher: Watcher) -> Trial:
    """The scene with one robot on the floor."""
    lab = lab.model_copy(update={"vehicles": (scene.vehicle,)})
    scanners, range_sensors = watcher is not Watcher.CAMERA, watcher is Watcher.BOTH
    loop = ClosedLoop(lab, scene.seed, scanners=scanners, range_sensors=range_sensors)
    loop.obstacles_seen = watcher is not Watcher.SCANNER
    name = scene.vehicle.id
    loop.world.place(name, scene.start)
    loop.run(0.3)
    loop.store.assign(name, scene.points, scene.speed_mps, loop.now_ns)
    loop.run(scene.after_s)
    truth = loop.world.truth().vehicles[name]
    first, then, walk_s = scene.place(_pose(truth), truth.linear_mps)
    loop.world.put(first)
    seen = _Seen()
    fields = _Fields(loop, scene, watcher)
    came_s = loop.now_s
    while loop.now_s - came_s < _MOST_S:
        loop.step()
        if then is not None and (loop.now_s - came_s >= walk_s or seen.gap_m < _HALTS_M):
            loop.world.put(_halted(loop, then) if loop.now_s - came_s < walk_s else then)
            then = None
        _note(seen, loop, name, fields)
        if then is None and seen.still_since_s is not None and loop.now_s - seen.still_since_s >= _STOOD_S:
            break
    contacts = loop.world.truth().contacts
    resumed = _resumes(loop, name) if watcher is Watcher.BOTH and seen.still_since_s is not None else None
    reaction = None
    if seen.entered_s is not None and seen.stood_s is not None:
        reaction = seen.stood_s - seen.entered_s
    return Trial(scene.seed, scene.kind, watcher, scene.speed_mps, contacts, reaction, seen.gap_m, resumed)


def false_stops(lab: Lab, vehicle: str, seed: int, seconds: float) -> dict[str, int]:
    """Stops by reason of one robot on an empty floor, which drives around for so long; with how far it came, in whole metres."""
    spec = lab.vehicle(vehicle)
    lab = lab.model_copy(update={"vehicles": (spec,)})
    loop = ClosedLoop(lab, seed)
    tour = lab.simulation.tours.get(vehicle) or _around(lab)
    loop.world.place(vehicle, SE2(*tour[0], math.atan2(tour[1][1] - tour[0][1], tour[1][0] - tour[0][0])))
    loop.run(0.3)
    loop.store.assign(vehicle, (*tour[1:], tour[0]), min(_ROUND_MPS, spec.limits.speed_mps), loop.now_ns, loop=True)
    loop.run(_WARM_S)
    stops: dict[str, int] = {"metres": 0}
    before: ReasonCode | None = None
    way_m = 0.0
    for _ in range(round(seconds / loop.world.step_s)):
        loop.step()
        way_m += abs(loop.world.truth().vehicles[vehicle].linear_mps) * loop.world.step_s
        code = _stopped(loop, vehicle)
        if code is not None and code != before:
            stops[str(code)] = stops.get(str(code), 0) + 1
        before = code
    stops["metres"] = int(way_m)
    return stops


def _around(lab: Lab) -> tuple[tuple[float, float], ...]:
    """A round along the border of the first area, a metre inside."""
    inner = Polygon(lab.areas[0].outline).buffer(-1.0, join_style="mitre")
    return tuple((float(x), float(y)) for x, y in shapely.get_coordinates(inner)[:-1])


def _stopped(loop: ClosedLoop, name: str) -> ReasonCode | None:
    """Why the robot is not to drive now."""
    agent = loop.robots[name].agent
    if agent is not None and agent.decision is not None and agent.decision.stopped_by is not None:
        return agent.decision.stopped_by.code
    if loop.outcome is not None and loop.outcome.commands[name].movement is Movement.WAITING:
        return loop.outcome.commands[name].reason.code
    return None


def _halted(loop: ClosedLoop, person: SimulatedObject) -> SimulatedObject:
    """The person standing where they are now."""
    here = next(item for item in loop.world.snapshot().objects if item.id == person.id)
    return person.model_copy(update={"x": here.x, "y": here.y})


def _resumes(loop: ClosedLoop, name: str) -> bool:
    """Takes the thing away; whether the robot then drives."""
    loop.world.remove(THING)
    for _ in range(round(_RESUME_S / loop.world.step_s)):
        loop.step()
        if loop.world.truth().vehicles[name].linear_mps > _MOVES_MPS:
            return True
    return False


def _note(seen: _Seen, loop: ClosedLoop, name: str, fields: "_Fields") -> None:
    truth = loop.world.truth().vehicles[name]
    outlines = loop.world.object_outlines()
    if not outlines:
        return
    still = abs(truth.linear_mps) < _STILL_MPS and abs(truth.angular_radps) < _STILL_RADPS
    if not still:
        seen.still_since_s = None
    elif seen.still_since_s is None:
        seen.still_since_s = loop.now_s
    seen.gap_m = min(seen.gap_m, fields.gap_m(truth, outlines[0]))
    if seen.entered_s is None:
        if not still and fields.has(truth, outlines[0]):
            seen.entered_s = loop.now_s
        return
    if seen.stood_s is None and still:
        seen.stood_s = loop.now_s


class _Fields:
    """The fields of a robot by the truth: what is in them is there, whether anybody has noticed or not."""

    def __init__(self, loop: ClosedLoop, scene: Scene, watcher: Watcher) -> None:
        self._loop, self._vehicle, self._watcher = loop, scene.vehicle, watcher
        self._outline = Outline(scene.vehicle.footprint)
        self._going = STOP

    def has(self, truth: TruePose, thing: Polygon) -> bool:
        watched = self._watcher
        return (watched is not Watcher.SCANNER and self._in_box(thing)) or (
            watched is not Watcher.CAMERA and self._in_protective_field(truth, thing)
        )

    def gap_m(self, truth: TruePose, thing: Polygon) -> float:
        """From the robot's outline to the thing."""
        return float(Polygon(_pose(truth).apply(self._vehicle.footprint)).distance(thing))

    def _in_box(self, thing: Polygon) -> bool:
        outcome = self._loop.outcome
        box = () if outcome is None else outcome.states[self._vehicle.id].box
        return len(box) >= 3 and bool(Polygon(box).intersects(thing))

    def _in_protective_field(self, truth: TruePose, thing: Polygon) -> bool:
        """Of what the robot does and of what it was last to do: a robot that brakes has not lost its field by that."""
        agent = self._loop.robots[self._vehicle.id].agent
        if agent is not None and agent.decision is not None and agent.decision.twist != STOP:
            self._going = agent.decision.twist
        spec, border = self._vehicle.protective_field, _pose(truth).inverse().apply(_dense(thing))
        for twist in (self._going, Twist(truth.linear_mps, truth.angular_radps)):
            sweep = braking_sweep(twist, self._vehicle.limits, self._outline.radius_m, spec.reaction_s)
            if len(in_the_way(border, self._outline, sweep, spec.margin_m)):
                return True
        return False


def _dense(thing: Polygon) -> NDArray[np.float64]:
    """Points (N, 2) along the border, 2 cm apart."""
    return shapely.get_coordinates(thing.segmentize(0.02))


def _pose(truth: TruePose) -> SE2:
    return SE2(truth.x, truth.y, truth.yaw)
