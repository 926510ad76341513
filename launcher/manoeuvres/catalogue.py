"""The scenarios of the 2025 evaluation (4.2.1), and scenes with many vehicles.

Where the report leaves things open (docs/manoeuvres.md): positions 1 to 4 are the south, east, north and west arm; ways 1 and 2
go straight on along the two roads, ways 3 and 4 turn left from the east and the west.
"""

import numpy as np

from launcher.manoeuvres.roads import (
    ARM_M,
    ARMS,
    LANE_M,
    MERGE_M,
    chain_way,
    chain_zones,
    crossing_way,
    crossing_zone,
    main_way,
    merge_zone,
    ramp_way,
    roundabout_way,
    roundabout_zones,
    wide_crossing_zone,
)
from launcher.manoeuvres.scenario import Entrant, Scenario

CROSSING_MPS, MERGE_MPS, ROUNDABOUT_MPS = 0.3, 0.5, 0.3
_BEFORE_M, _BEHIND_M = 2.5, 1.5
"""Of the crossing's zone: where the measurement begins and ends."""

# Robots of a scenario in the order in which they go through the report's, each with its arm and turn.
_CROSSINGS = {
    "crossing-1": (("east", "straight"), ("south", "straight")),
    "crossing-2": (("north", "straight"), ("east", "straight")),
    "crossing-3": (("west", "straight"), ("east", "left")),
    "crossing-4": (("north", "straight"), ("west", "left")),
    "crossing-5": (("west", "left"), ("south", "straight")),
}
_RAMP_STARTS_M = {"merge-1": 4.0, "merge-2": 4.5, "merge-3": 5.0}
_MAIN_START_M = 4.45
_MERGED_M = 2.1
"""How far behind the middle of the merge the measurement ends."""


def crossing_scenarios() -> list[Scenario]:
    """Two vehicles, both as far from the zone. The lower id goes first where they come at the same time."""
    found: list[Scenario] = []
    for name, ways in _CROSSINGS.items():
        entrants = tuple(
            Entrant(
                f"robot-{index}",
                crossing_way(*way),
                ARM_M - LANE_M - _BEFORE_M,
                _length(crossing_way(*way)) - (ARM_M - LANE_M) + _BEHIND_M,
            )
            for index, way in enumerate(ways, start=1)
        )
        found.append(Scenario(name, (crossing_zone(),), entrants, CROSSING_MPS, priority=("robot-1", "robot-2")))
    return found


def merge_scenarios() -> list[Scenario]:
    """One on the main road, one on the ramp that starts so far before the zone; the main road has the lower id."""
    found: list[Scenario] = []
    for name, start_m in _RAMP_STARTS_M.items():
        main, ramp = main_way(), ramp_way()
        edge_m = MERGE_M - 0.3
        entrants = (
            Entrant("robot-1", main, 7.0 - edge_m - _MAIN_START_M, 7.0 + _MERGED_M),
            Entrant("robot-2", ramp, _length(ramp) - 5.0 - edge_m - start_m, _length(ramp) - 5.0 + _MERGED_M),
        )
        found.append(Scenario(name, (merge_zone(),), entrants, MERGE_MPS, priority=("robot-1", "robot-2")))
    return found


def roundabout_scenarios() -> list[Scenario]:
    """One in the ring, which has priority, and one that comes to its next entry at the same time."""
    ring = roundabout_way("south", 3)
    coming = roundabout_way("east", 2)
    entrants = (
        Entrant("robot-1", ring, 3.3, _length(ring) - 1.5),
        Entrant("robot-2", coming, 1.0, _length(coming) - 1.5),
    )
    entry = tuple(zone for zone in roundabout_zones() if zone.id == "entry-east")
    return [Scenario("roundabout", entry, entrants, ROUNDABOUT_MPS, priority=("robot-1", "robot-2"))]


def report_scenarios() -> list[Scenario]:
    """All nine of the report."""
    return [*crossing_scenarios(), *merge_scenarios(), *roundabout_scenarios()]


SCENES = ("crossing", "merge", "roundabout", "wide-crossing", "chain")


def many(scene: str, vehicles: int, seed: int, *, headway_s: float = 2.0) -> Scenario:
    """A scene with that many vehicles, whose ways and arrivals are drawn: exponential with a mean of `headway_s` between
    arrivals."""
    rng = np.random.default_rng([seed, *scene.encode()])
    at_s = np.cumsum(rng.exponential(headway_s, vehicles)) - headway_s
    entrants: list[Entrant] = []
    for index in range(vehicles):
        way = _drawn_way(scene, rng)
        start_m = 0.3
        entrants.append(
            Entrant(f"robot-{index + 1:02d}", way, start_m, _length(way) - 0.3, float(max(0.0, at_s[index])))
        )
    zones = {
        "crossing": (crossing_zone(),),
        "merge": (merge_zone(),),
        "roundabout": roundabout_zones(),
        "wide-crossing": (wide_crossing_zone(),),
        "chain": chain_zones(),
    }[scene]
    speed = MERGE_MPS if scene == "merge" else CROSSING_MPS
    return Scenario(f"{scene}-{vehicles}-{seed}", zones, tuple(entrants), speed)


def _drawn_way(scene: str, rng: np.random.Generator) -> tuple[tuple[float, float], ...]:
    arm = ARMS[int(rng.integers(4))]
    if scene == "crossing":
        return crossing_way(arm, ("right", "straight", "straight", "left")[int(rng.integers(4))])
    if scene == "merge":
        return main_way() if rng.random() < 0.5 else ramp_way()
    if scene == "roundabout":
        return roundabout_way(arm, int(rng.integers(1, 4)))
    if scene == "wide-crossing":
        lane = int(rng.integers(2))
        turn = (
            ("straight", "left")[int(rng.random() < 0.3)]
            if lane == 0
            else ("straight", "right")[int(rng.random() < 0.3)]
        )
        return crossing_way(arm, turn, 2, lane)
    if scene == "chain":
        kinds = ("east", "west", "zigzag", *(f"{way}-{i}" for way in ("north", "south") for i in range(3)))
        return chain_way(kinds[int(rng.integers(len(kinds)))])
    raise ValueError(f"there is no scene {scene!r}; there are {', '.join(SCENES)}")


def _length(way: tuple[tuple[float, float], ...]) -> float:
    return float(np.hypot(*np.diff(np.asarray(way), axis=0).T).sum())
