"""Whether a booked area may be entered now."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from agents.manoeuvres.booking import Record, Standing
from agents.manoeuvres.passages import Use
from agents.manoeuvres.situation import Robot, Situation


@dataclass(frozen=True, slots=True)
class Hold:
    """Why the robot may not enter an area yet: `why` in words, and the robots that it waits for."""

    area: str
    why: str
    robots: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.area}: {self.why}" + (f" ({', '.join(self.robots)})" if self.robots else "")


def refusal(
    use: Use,
    passage: Sequence[Use],
    standing: Standing,
    situation: Situation,
    robot: Robot,
    records: Mapping[str, Record],
    *,
    begun: bool,
) -> Hold | None:
    """None when the area may be entered. One whose passage has `begun` goes on also when somebody falls silent behind it: all
    have agreed, and it is better out than in."""
    if standing.missing:
        return Hold(use.area, "not all have agreed yet", tuple(sorted(standing.missing)))
    before = standing.before.get(use.area, ())
    if before:
        return Hold(use.area, "others go first", before)
    inside = [other for other, sighting in situation.seen.items() if robot.zones.touches(use.area, sighting)]
    if inside:
        return Hold(use.area, "somebody is in it", tuple(sorted(inside)))
    if begun:
        return None
    if situation.sight_age_s > robot.parameters.seen_s:
        return Hold(use.area, "the cameras have not been heard")
    if standing.silent:
        return Hold(use.area, "silent robots are near", tuple(sorted(standing.silent)))
    taken = no_room(passage, situation, robot, records)
    return Hold(use.area, "no room behind it", taken) if taken else None


def relevant(uses: Sequence[Use], situation: Situation, robot: Robot) -> set[str]:
    """The vehicles that the cameras see within the detection distance of one of the zones."""
    zones = {use.zone for use in uses}
    return {
        other
        for other, sighting in situation.seen.items()
        if robot.zones.near(sighting.pose.x, sighting.pose.y) & zones
    }


def no_room(uses: Sequence[Use], situation: Situation, robot: Robot, records: Mapping[str, Record]) -> tuple[str, ...]:
    """Who comes to rest, or rests, where the robot would have to once it is out of the areas."""
    out = situation.way.at(max(use.exit_m for use in uses))
    taken: list[str] = []
    for other, sighting in situation.seen.items():
        record = records.get(other)
        rest = (sighting.pose.x, sighting.pose.y) if record is None else record.message.authority
        if rest is None:
            continue
        reach_m = float(np.hypot(*np.asarray(sighting.outline).T).max())
        if math.hypot(rest[0] - out.x, rest[1] - out.y) < robot.reach_m + reach_m:
            taken.append(other)
    return tuple(sorted(taken))
