"""How fast to approach an area that will be free later: as fast through it as can be, and able to stop before it until then."""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Mobility:
    """What the robot can do: m/s, m/s^2, both ways; `reaction_s` pass before a set-point acts."""

    speed_mps: float
    acceleration_mps2: float
    deceleration_mps2: float
    reaction_s: float


def stopping_m(speed_mps: float, mobility: Mobility) -> float:
    """The way from that speed to a stand, the reaction included."""
    return speed_mps * mobility.reaction_s + speed_mps**2 / (2 * mobility.deceleration_mps2)


def speed_to_stop(distance_m: float, mobility: Mobility) -> float:
    """The highest speed from which the robot stops within that distance: the inverse of `stopping_m`."""
    if distance_m <= 0:
        return 0.0
    a, t = mobility.deceleration_mps2, mobility.reaction_s
    return min(mobility.speed_mps, a * (math.sqrt(t * t + 2 * distance_m / a) - t))


def speed_to_be_there(distance_m: float, after_s: float, speed_mps: float, mobility: Mobility) -> float:
    """The speed to have now, in order to come to the area `distance_m` ahead just when it becomes free, in `after_s`, and then at
    full speed. Until then it must be possible to stop before it, so the robot is to be one way of stopping away from it
    at that moment, at full speed: it drives slowly early and accelerates late, where the reports' `distance / time`
    (Gulliver 2025, eq. 3.7) arrives as slowly as it approached. Never more than what lets it stop before the area."""
    room_m = distance_m - stopping_m(mobility.speed_mps, mobility)
    may = speed_to_stop(distance_m, mobility)
    if after_s <= 0 or room_m >= mobility.speed_mps * after_s:
        return may
    low, high = 0.0, mobility.speed_mps
    for _ in range(20):
        middle = (low + high) / 2
        if _way_by(middle, after_s, speed_mps, mobility) > room_m:
            high = middle
        else:
            low = middle
    return min(may, low)


def _way_by(cruise_mps: float, after_s: float, speed_mps: float, mobility: Mobility) -> float:
    """How far the robot gets in `after_s` when it goes over to the cruising speed, holds it, and accelerates to full speed so
    late that it has it in the end (or as nearly as it can)."""
    change = mobility.acceleration_mps2 if cruise_mps > speed_mps else mobility.deceleration_mps2
    to_cruise_s = abs(cruise_mps - speed_mps) / change
    to_full_s = (mobility.speed_mps - cruise_mps) / mobility.acceleration_mps2
    if to_cruise_s + to_full_s > after_s:
        late_s = min(after_s, to_cruise_s)
        direction = math.copysign(change, cruise_mps - speed_mps)
        reached = speed_mps + direction * late_s
        rest_s = after_s - late_s
        return (speed_mps + reached) / 2 * late_s + reached * rest_s + mobility.acceleration_mps2 * rest_s**2 / 2
    hold_s = after_s - to_cruise_s - to_full_s
    return (
        (speed_mps + cruise_mps) / 2 * to_cruise_s
        + cruise_mps * hold_s
        + (cruise_mps + mobility.speed_mps) / 2 * to_full_s
    )
