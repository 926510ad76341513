"""The best that two vehicles could do, computed offline with all knowledge: what a method's delay is to be measured against.

Two optima: the `zones` one keeps to the zones as they are drawn, a sub-area is used by one vehicle at a time; the `bodies` one
knows no zones and only keeps the outlines apart.

Both drive their given ways. One goes first, unhindered; the other may choose any speed profile within its limits, knows the
first's drive from the beginning, hears at no delay, and only has to keep `GAP_M` between the outlines at all times. That is a
linear program: at every instant the second may have come at most as far as the first place at which, with the first where it is
then, the outlines would be too near. The better order counts.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.optimize import linprog

from agents.manoeuvres.passages import Way, uses_of
from launcher.manoeuvres.scenario import Entrant, Scenario

GAP_M = 0.10
_STEP_M = 0.02
_Limits: TypeAlias = Callable[["Scenario", Entrant, Entrant, NDArray[np.float64]], NDArray[np.float64]]
_STEP_S = 0.1


@dataclass(frozen=True, slots=True)
class Best:
    """The drive of the one that goes second (s), its free flow (s), and who goes first."""

    took_s: float
    free_s: float
    first: str

    @property
    def fk(self) -> float:
        return self.took_s / self.free_s


Rule: TypeAlias = Literal["zones", "bodies"]


def best(scenario: Scenario, rule: Rule) -> Best:
    """The least quotient of delayed time and free flow over both orders. ValueError unless there are two vehicles that start at
    the same time, each in reach of going second."""
    if len(scenario.entrants) != 2 or scenario.entrants[0].at_s != scenario.entrants[1].at_s:
        raise ValueError("the optimum is of two vehicles that start together")
    one, other = scenario.entrants
    limits = _by_zones if rule == "zones" else _by_bodies
    found = [
        best
        for best in (_behind(scenario, one, other, limits), _behind(scenario, other, one, limits))
        if best is not None
    ]
    if not found:
        raise ValueError(f"in {scenario.name} neither can go second")
    return min(found, key=lambda one: one.fk)


def _behind(scenario: Scenario, first: Entrant, second: Entrant, limits: _Limits) -> Best | None:
    speed = scenario.speed_mps
    free_s = (second.goal_m - second.start_m) / speed
    count = math.ceil((free_s * 3 + (first.goal_m - first.start_m) / speed) / _STEP_S)
    times: NDArray[np.float64] = np.arange(1, count + 1, dtype=np.float64) * _STEP_S
    limit = limits(scenario, first, second, times)
    # Speeds at the end of each step are the variables; the way is their sum (trapezia, from full speed).
    ways = np.tril(np.full((count, count), _STEP_S)) - np.eye(count) * (_STEP_S / 2)
    start_m = second.start_m + speed * _STEP_S / 2
    bounded = np.isfinite(limit)
    change = np.eye(count) - np.eye(count, k=-1)
    initial = np.zeros(count)
    initial[0] = speed
    up, down = scenario.acceleration_mps2 * _STEP_S, scenario.deceleration_mps2 * _STEP_S
    solved = linprog(
        -ways[-1],
        A_ub=np.vstack([ways[bounded], change, -change]),
        b_ub=np.concatenate([limit[bounded] - start_m, up + initial, down - initial]),
        bounds=(0.0, speed),
        method="highs",
    )
    if not solved.success or solved.x is None:
        return None
    along = start_m + ways @ solved.x
    if along[-1] < second.goal_m:
        return None
    took_s = float(np.interp(second.goal_m, along, times))
    return Best(took_s, free_s, first.robot)


def _by_zones(scenario: Scenario, first: Entrant, second: Entrant, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far the second may have come at each time: before each area that the first has yet to leave. Both are grown by half
    the gap."""
    uses = {
        entrant.robot: uses_of(Way(entrant.way), scenario.outline, scenario.zones, GAP_M / 2)
        for entrant in (first, second)
    }
    limits = np.full(len(times), np.inf)
    at_m = first.start_m + scenario.speed_mps * times
    for ahead in uses[first.robot]:
        for behind in uses[second.robot]:
            if behind.area == ahead.area:
                limits[at_m < ahead.exit_m] = np.minimum(limits[at_m < ahead.exit_m], behind.enter_m)
    return limits


def _by_bodies(scenario: Scenario, first: Entrant, second: Entrant, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far the second may have come at each time (m along its way; infinite: no matter)."""
    leader, follower = Way(first.way), Way(second.way)
    stations = np.arange(second.start_m, follower.length_m, _STEP_M)
    bodies = _bodies(scenario, follower, stations)
    limits = np.full(len(times), np.inf)
    for index, time in enumerate(times):
        at_m = first.start_m + scenario.speed_mps * float(time)
        if at_m > first.goal_m:
            break
        body = shapely.Polygon(leader.at(at_m).apply(scenario.outline))
        near = np.flatnonzero(shapely.distance(bodies, body) < GAP_M)
        if len(near):
            limits[index] = stations[near[0]] - _STEP_M
    return limits


def _bodies(scenario: Scenario, way: Way, stations: NDArray[np.float64]) -> NDArray[np.object_]:
    return np.array([shapely.Polygon(way.at(float(s)).apply(scenario.outline)) for s in stations], dtype=object)
