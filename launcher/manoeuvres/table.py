"""The table of a traffic situation: published delays, the report's algorithm and ours on the same scenarios, and the optima."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from launcher.manoeuvres.evaluation import Delay, delay
from launcher.manoeuvres.minds import Cooperative
from launcher.manoeuvres.optimum import Best, best
from launcher.manoeuvres.reported import Reported
from launcher.manoeuvres.scenario import Scenario
from launcher.output import progress

PUBLISHED_MEAN = {"crossing": 1.2432, "merge": 1.1938, "roundabout": 1.1412}
"""Gulliver 2025, table 5.3."""


@dataclass(frozen=True, slots=True)
class Row:
    """One scenario: both methods, the optimum that keeps to the zones, and the one that only keeps the bodies apart."""

    scenario: Scenario
    ours: Delay
    reported: Delay
    zones: Best
    bodies: Best


def compare(scenarios: Iterable[Scenario], runs: int) -> list[Row]:
    """Every scenario by every method, `runs` times each."""
    scenarios = list(scenarios)
    rows: list[Row] = []
    for index, scenario in enumerate(scenarios):
        progress(f"{scenario.name} ({index + 1} of {len(scenarios)})")
        rows.append(
            Row(
                scenario,
                delay(scenario, Cooperative, runs),
                delay(scenario, Reported, runs),
                best(scenario, "zones"),
                best(scenario, "bodies"),
            )
        )
    return rows


def figures(situation: str, rows: list[Row]) -> Mapping[str, float | None]:
    """By scenario and as means; `fk_gap_to_optimum_max` is the largest excess over the zones' optimum. None where a vehicle was
    never through."""
    found: dict[str, float] = {}
    for row in rows:
        name = row.scenario.name.replace("-", "_")
        found |= {
            f"fk_{name}": row.ours.fk,
            f"fk_{name}_reported": row.reported.fk,
            f"fk_{name}_optimum": row.zones.fk,
            f"fk_{name}_optimum_bodies": row.bodies.fk,
        }
    count = len(rows)
    if count > 1:
        found |= {
            f"fk_{situation}_mean": sum(row.ours.fk for row in rows) / count,
            f"fk_{situation}_reported_mean": sum(row.reported.fk for row in rows) / count,
            f"fk_{situation}_optimum_mean": sum(row.zones.fk for row in rows) / count,
            f"fk_{situation}_optimum_bodies_mean": sum(row.bodies.fk for row in rows) / count,
        }
    found |= {
        "fk_gap_to_optimum_max": max(row.ours.fk - row.zones.fk for row in rows),
        "footprint_gap_min_m": min(row.ours.gap_min_m for row in rows),
        "footprint_gap_reported_min_m": min(row.reported.gap_min_m for row in rows),
        "contacts": sum(row.ours.contacts for row in rows),
        "double_holds": sum(row.ours.double_holds for row in rows),
    }
    return {name: value if math.isfinite(value) else None for name, value in found.items()}
