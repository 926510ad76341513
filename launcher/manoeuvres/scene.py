"""Runs a traffic scene in simulated time and keeps what happened."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import shapely

from agents.manoeuvres.passages import Way
from agents.manoeuvres.traffic import Sighting, ZoneMap
from geometry import SE2
from launcher.manoeuvres.minds import Choice, Look, Mind
from launcher.manoeuvres.network import Impairment, SceneNetwork
from launcher.manoeuvres.scenario import Entrant, Scenario

STEP_S = 0.05
"""A cycle of the vehicles' minds: they think and speak twenty times a second."""
SUBSTEPS = 5
_LOOK_S = 0.08
"""Capture of a picture until the pose is with the robots."""
_SIGMA_M = 0.003

Minds: TypeAlias = Callable[[Scenario, Entrant, ZoneMap, float], Mind]


@dataclass(frozen=True, slots=True)
class Crash:
    """A vehicle's mind dies at `at_s`, the vehicle brakes, and a new mind that remembers nothing begins at `again_s`."""

    robot: str
    at_s: float
    again_s: float


@dataclass(frozen=True, slots=True)
class Passing:
    """A vehicle's drive: when it began and when it was through (s; None: it was not)."""

    began_s: float
    through_s: float | None

    @property
    def took_s(self) -> float:
        return float("inf") if self.through_s is None else self.through_s - self.began_s


@dataclass(slots=True)
class SceneRun:
    """What came of it: drives by robot; steps with a double hold and with touching outlines; the least distance of two outlines
    (m); the speeds by robot (s, m along the way, m/s); and why vehicles waited when it ended."""

    passings: dict[str, Passing] = field(default_factory=dict[str, Passing])
    double_holds: int = 0
    contacts: int = 0
    gap_min_m: float = np.inf
    ended_s: float = 0.0
    traces: dict[str, list[tuple[float, float, float]]] = field(
        default_factory=dict[str, list[tuple[float, float, float]]]
    )
    waiting: dict[str, str] = field(default_factory=dict[str, str])

    @property
    def all_through(self) -> bool:
        return all(passing.through_s is not None for passing in self.passings.values())


@dataclass(slots=True)
class _Vehicle:
    entrant: Entrant
    way: Way
    mind: Mind | None
    at_m: float
    speed_mps: float
    choice: Choice = field(default_factory=lambda: Choice(0.0))

    @property
    def pose(self) -> SE2:
        return self.way.at(self.at_m)


class Scene:
    """One run of a scenario. `minds` makes a vehicle's mind when it comes into the scene or its mind begins anew."""

    def __init__(
        self,
        scenario: Scenario,
        minds: Minds,
        *,
        impairment: Impairment | None = None,
        crashes: tuple[Crash, ...] = (),
        seed: int = 0,
    ) -> None:
        self.run_so_far = SceneRun()
        self._scenario = scenario
        self._minds = minds
        self._zones = ZoneMap(scenario.zones)
        self._network = SceneNetwork(impairment or Impairment(), seed)
        self._crashes = crashes
        self._rng = np.random.default_rng(seed)
        self._coming = sorted(scenario.entrants, key=lambda entrant: entrant.at_s)
        self._inside: dict[str, _Vehicle] = {}
        self._history: list[dict[str, tuple[SE2, float]]] = []

    def run(self, until_s: float) -> SceneRun:
        """Until all are through, or that time."""
        run, step = self.run_so_far, 0
        while (self._coming or self._inside) and step * STEP_S < until_s:
            now_s = step * STEP_S
            self._enter(now_s)
            self._crash(now_s)
            self._think(now_s)
            self._drive(now_s)
            self._judge()
            step += 1
        run.ended_s = step * STEP_S
        run.waiting = {robot: vehicle.choice.why for robot, vehicle in self._inside.items()}
        for entrant in self._coming:
            run.passings[entrant.robot] = Passing(entrant.at_s, None)
        return run

    def _enter(self, now_s: float) -> None:
        """A vehicle whose start is taken waits outside; its time runs."""
        for entrant in [entrant for entrant in self._coming if entrant.at_s <= now_s]:
            way = Way(entrant.way)
            body = self._body(way.at(entrant.start_m)).buffer(0.5)
            if any(body.intersects(self._body(vehicle.pose)) for vehicle in self._inside.values()):
                continue
            mind = self._minds(self._scenario, entrant, self._zones, now_s)
            self._inside[entrant.robot] = _Vehicle(entrant, way, mind, entrant.start_m, self._scenario.speed_mps)
            self.run_so_far.passings[entrant.robot] = Passing(entrant.at_s, None)
            self._coming.remove(entrant)

    def _crash(self, now_s: float) -> None:
        for crash in self._crashes:
            vehicle = self._inside.get(crash.robot)
            if vehicle is None:
                continue
            if crash.at_s <= now_s < crash.again_s:
                vehicle.mind, vehicle.choice = None, Choice(0.0, why="its mind is dead")
            elif vehicle.mind is None:
                vehicle.mind = self._minds(self._scenario, vehicle.entrant, self._zones, now_s)

    def _think(self, now_s: float) -> None:
        self._history.append({robot: (vehicle.pose, vehicle.speed_mps) for robot, vehicle in self._inside.items()})
        late = self._history[max(0, len(self._history) - 1 - round(_LOOK_S / STEP_S))]
        del self._history[:-4]
        for robot, vehicle in self._inside.items():
            heard = self._network.due(robot, now_s)
            if vehicle.mind is None:
                continue
            for message in heard:
                vehicle.mind.hear(message, now_s)
            noise = self._rng.normal(0.0, _SIGMA_M, 2 * len(late) + 1)
            seen = {
                other: Sighting(
                    SE2(pose.x + noise[2 * i], pose.y + noise[2 * i + 1], pose.yaw), speed, self._scenario.outline
                )
                for i, (other, (pose, speed)) in enumerate(late.items())
                if other != robot
            }
            look = Look(now_s, vehicle.at_m + float(noise[-1]), vehicle.speed_mps, seen, _LOOK_S)
            vehicle.choice = vehicle.mind.choose(look)
            if vehicle.choice.message is not None:
                self._network.send(vehicle.choice.message, vehicle.choice.recipients, now_s)

    def _drive(self, now_s: float) -> None:
        dt = STEP_S / SUBSTEPS
        up, down = self._scenario.acceleration_mps2 * dt, self._scenario.deceleration_mps2 * dt
        for robot, vehicle in list(self._inside.items()):
            wanted = min(max(vehicle.choice.speed_mps, 0.0), self._scenario.speed_mps)
            self.run_so_far.traces.setdefault(robot, []).append((now_s, vehicle.at_m, vehicle.speed_mps))
            for substep in range(SUBSTEPS):
                before = vehicle.speed_mps
                vehicle.speed_mps += min(up, max(-down, wanted - vehicle.speed_mps))
                vehicle.at_m += (before + vehicle.speed_mps) / 2 * dt
                if vehicle.at_m >= vehicle.entrant.goal_m:
                    began = self.run_so_far.passings[robot].began_s
                    self.run_so_far.passings[robot] = Passing(began, now_s + (substep + 1) * dt)
                    del self._inside[robot]
                    break

    def _judge(self) -> None:
        run = self.run_so_far
        bodies = [self._body(vehicle.pose) for vehicle in self._inside.values()]
        for one, other in itertools.combinations(bodies, 2):
            gap_m = float(shapely.distance(one, other))
            run.gap_min_m = min(run.gap_min_m, gap_m)
            run.contacts += gap_m == 0.0
        held = [area for vehicle in self._inside.values() for area in vehicle.choice.holds]
        run.double_holds += len(held) - len(set(held))

    def _body(self, pose: SE2) -> shapely.Polygon:
        return shapely.Polygon(pose.apply(self._scenario.outline))
