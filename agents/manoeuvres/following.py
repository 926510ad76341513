"""Keeping distance to the vehicle ahead."""

from agents.manoeuvres.approach import Mobility, speed_to_stop

CRUISE_GAIN = 0.01
"""Change of the speed limit per metre of distance too much, each cycle (Gulliver 2025, appendix B)."""


def cruise_limit(limit_mps: float, distance_m: float, reference_m: float, highest_mps: float) -> float:
    """The report's cruise control: next cycle's speed limit (Gulliver 2025, appendix B)."""
    return min(highest_mps, max(0.0, limit_mps + (distance_m - reference_m) * CRUISE_GAIN))


def speed_behind(gap_m: float, leader_mps: float, standing_m: float, mobility: Mobility) -> float:
    """The highest speed from which the robot still stops `standing_m` behind the leader when that brakes as hard as the robot
    itself can from now on (Gipps 1981, with both decelerations the same)."""
    leader_stops_m = leader_mps**2 / (2 * mobility.deceleration_mps2)
    return speed_to_stop(gap_m - standing_m + leader_stops_m, mobility)
