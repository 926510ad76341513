"""What manoeuvring goes by."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ManoeuvreParameters:
    """Metres, seconds. `margin_m`: how much larger than its footprint the robot is taken to be when it uses areas (two robots
    that use areas one after the other keep twice that apart); `standing_m`: what is left free before a stop line and behind a
    robot that stands. A robot claims `claim_ahead_s` before it would be at the first area. `silent_s`: a robot not
    heard for longer counts as silent; sightings older than `seen_s` count as none. `reaction_s` from a permission's end until
    the wheels brake; `notice_s` from an area's being left until those who wait know it;
    `sight_s` from another vehicle's braking until it is seen. `away_m`: how far outside the detection distance one is
    surely not near."""

    margin_m: float = 0.05
    standing_m: float = 0.05
    claim_ahead_s: float = 6.0
    silent_s: float = 0.5
    seen_s: float = 0.5
    reaction_s: float = 0.1
    notice_s: float = 0.08
    sight_s: float = 0.15
    away_m: float = 0.3


DEFAULT = ManoeuvreParameters()
