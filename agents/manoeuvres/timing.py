"""When a robot expects to enter and leave the areas ahead."""

import math
from collections.abc import Mapping, Sequence

from agents.manoeuvres.approach import Mobility, stopping_m
from agents.manoeuvres.passages import Use
from protocol.messages.zones import AreaUse


def travel_s(distance_m: float, speed_mps: float, mobility: Mobility) -> float:
    """Seconds for the distance when the robot accelerates to its full speed and keeps it; 0 for what is behind."""
    if distance_m <= 0:
        return 0.0
    a, full = mobility.acceleration_mps2, mobility.speed_mps
    speed = min(max(speed_mps, 0.0), full)
    run_up_m = (full**2 - speed**2) / (2 * a)
    if distance_m <= run_up_m:
        return (math.sqrt(speed**2 + 2 * a * distance_m) - speed) / a
    return (full - speed) / a + (distance_m - run_up_m) / full


def estimated_uses(
    uses: Sequence[Use], progress_m: float, speed_mps: float, mobility: Mobility, free_s: Mapping[str, float]
) -> dict[str, AreaUse]:
    """By area, when it will be entered and left (s from now). Areas in `free_s` are free only then: the robot is one way of
    stopping before them at that moment, at full speed, as `speed_to_be_there` has it, and all that follows is later by as
    much."""
    full_stop_m = stopping_m(mobility.speed_mps, mobility)
    late_s = 0.0
    for use in uses:
        if use.area in free_s:
            before_s = travel_s(use.enter_m - progress_m - full_stop_m, speed_mps, mobility)
            late_s = max(late_s, free_s[use.area] - before_s)
    estimated: dict[str, AreaUse] = {}
    for use in uses:
        enter_s = travel_s(use.enter_m - progress_m, speed_mps, mobility) + late_s
        exit_s = travel_s(use.exit_m - progress_m, speed_mps, mobility) + late_s
        known = estimated.get(use.area)
        estimated[use.area] = AreaUse(use.area, enter_s if known is None else min(known.enter_s, enter_s), exit_s)
    return estimated
