"""Pallets left behind on a robot's route, in the closed loop: whether it gets to its goal around them, and how near it comes.

Guidance is the real one and knows of the pallets what the obstacle map shows; the agent drives with its scanner and range
sensor, as deployed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from shapely.geometry import Polygon

from geometry import SE2
from launcher.closed_loop import ClosedLoop
from launcher.experiments.detour_scenes import left_behind, outline_of, way_exists
from launcher.experiments.obstacle_scenes import Point, Scene
from protocol.lab import Lab
from protocol.messages import AssignmentState, Movement, ReasonCode, SimulatedObject, TruePose

_MOST_S = 120.0
_IN_VAIN_S = 12.0
"""A robot that has no way around says so, and has searched again, by then."""
_LOOKS = 5
"""Steps of the world from one look at the distances to the next."""
_NEAR_M = 0.7
"""Where the robot was held up it may be nearer to the pallet than its clearance; this far from there it is not to be any more."""
_STANDS_MPS = 0.005
_ARRIVED_M = 0.15


@dataclass(frozen=True, slots=True)
class DetourTrial:
    """What became of a robot before pallets left behind. `way` says whether there is a way to its goal with the clearance,
    `arrived` whether it stood at its goal in the end, `diverted` whether it made a detour, `told` whether it waited and said that
    there is no way. `gap_m` is the least distance from any pallet, `clearance_m` the least on the detour, away from where it was
    held up (None without one); `track` where it was (m), ten times a second."""

    seed: int
    things: tuple[SimulatedObject, ...]
    points: tuple[Point, ...]
    way: bool
    arrived: bool
    diverted: bool
    told: bool
    contacts: int
    gap_m: float
    clearance_m: float | None
    seconds: float
    track: tuple[Point, ...]


def conduct_detour(lab: Lab, scene: Scene) -> DetourTrial:
    """The scene with one robot on the floor and its pallets left where they are."""
    lab = lab.model_copy(update={"vehicles": (scene.vehicle,)})
    loop, name = ClosedLoop(lab, scene.seed), scene.vehicle.id
    loop.world.place(name, scene.start)
    loop.run(0.3)
    loop.store.assign(name, scene.points, scene.speed_mps, loop.now_ns)
    loop.run(scene.after_s)
    here = loop.world.truth().vehicles[name]
    things = left_behind(scene, lab, _pose(here), here.linear_mps)
    outlines = [outline_of(thing) for thing in things]
    for thing in things:
        loop.world.put(thing)
    left = scene.points[loop.store.assignments[name].leg :]
    radii = [loop.store.waypoints[leg.waypoint].radius_m for leg in loop.store.routes[name].legs]
    stops = list(zip(left, radii[-len(left) :], strict=True))
    way = way_exists(lab, scene.vehicle, _pose(here), stops, outlines)
    watch = _Watch(scene, outlines)
    came_s = loop.now_s
    while loop.now_s - came_s < _MOST_S and loop.store.assignments[name].state is AssignmentState.RUNNING:
        loop.run(_LOOKS * loop.world.step_s)
        watch.look(loop, name)
        if not way and watch.told and loop.now_s - came_s > _IN_VAIN_S:
            break
    truth = loop.world.truth()
    place = truth.vehicles[name]
    done = loop.store.assignments[name].state is AssignmentState.DONE
    return DetourTrial(
        seed=scene.seed,
        things=tuple(things),
        points=((scene.start.x, scene.start.y), *scene.points),
        way=way,
        arrived=done and math.dist((place.x, place.y), scene.points[-1]) <= _ARRIVED_M,
        diverted=watch.diverted,
        told=watch.told,
        contacts=truth.contacts,
        gap_m=watch.gap_m,
        clearance_m=watch.clearance_m if math.isfinite(watch.clearance_m) else None,
        seconds=loop.now_s - came_s,
        track=tuple(watch.track),
    )


class _Watch:
    """Follows one robot among the pallets."""

    def __init__(self, scene: Scene, outlines: Sequence[Polygon]) -> None:
        self.gap_m = self.clearance_m = math.inf
        self.diverted = self.told = False
        self.track: list[Point] = []
        self._vehicle, self._outlines = scene.vehicle, outlines
        self._held_up: Point | None = None
        self._looks = 0

    def look(self, loop: ClosedLoop, name: str) -> None:
        """Notes how things are now."""
        truth = loop.world.truth().vehicles[name]
        body = Polygon(_pose(truth).apply(self._vehicle.footprint))
        gap_m = min(float(body.distance(outline)) for outline in self._outlines)
        self.gap_m = min(self.gap_m, gap_m)
        self._looks += 1
        if self._looks % 2:
            self.track.append((truth.x, truth.y))
        assert loop.outcome is not None
        command = loop.outcome.commands[name]
        waits = command.movement is Movement.WAITING
        self.told = waits and "no way around" in command.reason.text
        if waits and abs(truth.linear_mps) < _STANDS_MPS:
            self._held_up = (truth.x, truth.y)
        if command.reason.code is ReasonCode.DETOUR:
            self.diverted = True
            if self._held_up is not None and math.dist(self._held_up, (truth.x, truth.y)) > _NEAR_M:
                self.clearance_m = min(self.clearance_m, gap_m)


def _pose(truth: TruePose) -> SE2:
    return SE2(truth.x, truth.y, truth.yaw)
