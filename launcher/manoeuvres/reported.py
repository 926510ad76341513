"""The report's own algorithm as a mind, to compare with (Gulliver 2025, 3.2 and figure 3.3).

Every cycle, within the detection distance: tell the relevant robots one's bookings and times; book what nobody with a higher
priority wants (earlier arrival; within one second the lower id); without a booking drive at `distance / time until it is free`
(eq. 3.7); stop before the zone while a relevant robot is silent; keep distance behind others with the cruise control.
"""

from collections.abc import Mapping

import numpy as np

from agents.manoeuvres.following import cruise_limit
from agents.manoeuvres.parameters import DEFAULT
from agents.manoeuvres.passages import Use, Way, passages_of, uses_of
from agents.manoeuvres.precedence import by_arrival
from agents.manoeuvres.traffic import ZoneMap, ahead_on
from launcher.manoeuvres.minds import Choice, Look
from launcher.manoeuvres.scenario import Entrant, Scenario
from protocol.messages.zones import AreaUse, ZoneClaim, ZoneMessage, ZoneMessageType

ENTRY_M = 2.0
"""From here to the zone a vehicle books; before that it only says that it is there."""
SILENT_S = 0.5
REFERENCE_M = 0.5
"""Distance that the cruise control keeps."""
_SLOW_MPS = 0.02


class Reported:
    """One vehicle's. It starts at full speed, so arrivals are those of its current speed, as in the report."""

    def __init__(self, scenario: Scenario, entrant: Entrant, zones: ZoneMap, now_s: float) -> None:
        self._robot = entrant.robot
        self._boot = round(now_s * 1e9)
        self._scenario = scenario
        self._zones = zones
        self._way = Way(entrant.way)
        self._outline = np.asarray(scenario.outline, dtype=np.float64)
        self._passages = passages_of(uses_of(self._way, scenario.outline, scenario.zones, DEFAULT.margin_m), 0.0)
        self._heard: dict[str, tuple[ZoneMessage, float]] = {}
        self._booked = False
        self._sequence = 0
        self._cruise_mps = scenario.speed_mps

    def hear(self, message: ZoneMessage, now_s: float) -> None:
        self._heard[message.robot] = message, now_s

    def choose(self, look: Look) -> Choice:
        full = self._scenario.speed_mps
        if self._passages and self._passages[0].exit_m <= look.progress_m:
            self._passages.pop(0)
            self._booked = False
        here = self._way.at(look.progress_m)
        near = self._zones.near(here.x, here.y)
        passage = self._passages[0] if self._passages and self._passages[0].zones & near else None
        relevant = {robot for robot, other in look.seen.items() if self._zones.near(other.pose.x, other.pose.y) & near}
        limit, uses, why = full, dict[str, AreaUse](), ""
        if passage is not None:
            remaining = [use for use in passage.uses if use.exit_m > look.progress_m]
            uses = self._times(remaining, look)
            if passage.enter_m - look.progress_m <= ENTRY_M:
                limit, why = self._approach(remaining, uses, relevant, look)
        limit = min(limit, self._following(look))
        claims = (ZoneClaim(1, 0, self._booked, tuple(uses.values())),) if uses else ()
        self._sequence += 1
        message = ZoneMessage(
            ZoneMessageType.ENTER if uses else ZoneMessageType.HB, self._robot, self._boot, self._sequence, claims
        )
        holds = frozenset(
            use.area
            for use in (passage.uses if passage is not None and self._booked else ())
            if use.enter_m <= look.progress_m < use.exit_m
        )
        return Choice(limit, holds, why, message, relevant)

    def _approach(
        self, remaining: list[Use], uses: Mapping[str, AreaUse], relevant: set[str], look: Look
    ) -> tuple[float, str]:
        distance_m = max(0.0, remaining[0].enter_m - look.progress_m)
        if self._booked:
            return self._scenario.speed_mps, ""
        silent = [robot for robot in relevant if look.now_s - self._heard.get(robot, (None, -9.0))[1] > SILENT_S]
        if silent:
            braking_m = look.speed_mps**2 / (2 * self._scenario.deceleration_mps2) + 0.1
            return (0.0 if distance_m <= braking_m else self._scenario.speed_mps), f"silent: {silent}"
        free_s, first = 0.0, []
        for robot, (message, heard_s) in self._heard.items():
            ago = look.now_s - heard_s
            if ago > SILENT_S:
                continue
            for claim in message.claims:
                theirs = {use.area: AreaUse(use.area, use.enter_s - ago, use.exit_s - ago) for use in claim.areas}
                shared = uses.keys() & theirs.keys()
                if not shared:
                    continue
                if claim.established or not by_arrival((self._robot, uses), (robot, theirs)):
                    first.append(robot)
                    free_s = max(free_s, *(theirs[area].exit_s for area in shared))
        if not first:
            self._booked = True
            return self._scenario.speed_mps, ""
        return min(self._scenario.speed_mps, distance_m / max(free_s, 0.1)), f"first: {first}"

    def _times(self, remaining: list[Use], look: Look) -> dict[str, AreaUse]:
        speed = max(look.speed_mps, _SLOW_MPS)
        return {
            use.area: AreaUse(
                use.area,
                max(0.0, use.enter_m - look.progress_m) / speed,
                max(0.0, use.exit_m - look.progress_m) / speed,
            )
            for use in remaining
        }

    def _following(self, look: Look) -> float:
        leaders = ahead_on(self._way, look.progress_m, self._outline, look.seen)
        if not leaders:
            self._cruise_mps = self._scenario.speed_mps
            return self._cruise_mps
        self._cruise_mps = cruise_limit(self._cruise_mps, leaders[0].gap_m, REFERENCE_M, self._scenario.speed_mps)
        return 0.0 if leaders[0].gap_m < 0.2 else self._cruise_mps
