"""One robot's cooperation with the others: its way, what it sees and hears in; a speed limit and its message out.

Pure like the booking it drives. One cycle: `hear` what came, then `step`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from agents.manoeuvres.approach import Mobility, speed_to_be_there, speed_to_stop
from agents.manoeuvres.booking import Booking
from agents.manoeuvres.claiming import Booked, Claiming
from agents.manoeuvres.following import speed_behind
from agents.manoeuvres.parameters import DEFAULT, ManoeuvreParameters
from agents.manoeuvres.passages import Use, Way, passages_of, uses_of
from agents.manoeuvres.permission import Hold, refusal, relevant
from agents.manoeuvres.precedence import Precedence, by_delay
from agents.manoeuvres.situation import LINE_M, Robot, Situation
from agents.manoeuvres.timing import estimated_uses
from agents.manoeuvres.traffic import Sighting, ZoneMap, ahead_on
from protocol.messages.zones import AreaUse, ZoneMessage

_ACROSS_RAD = math.pi / 4
"""Another vehicle whose heading differs by more does not go the same way."""


@dataclass(frozen=True, slots=True)
class Advice:
    """What comes of a cycle: the speed limit (m/s), the first area that may not be entered (None: none), what to send to whom."""

    speed_mps: float
    hold: Hold | None
    message: ZoneMessage
    recipients: frozenset[str]


class Coordinator:
    """One robot's. `boot` as for Booking. Give it a way before the first step."""

    def __init__(
        self,
        robot: str,
        boot: int,
        outline: Sequence[tuple[float, float]],
        zones: ZoneMap,
        mobility: Mobility,
        parameters: ManoeuvreParameters = DEFAULT,
        precedence: Precedence = by_delay,
    ) -> None:
        self.booking = Booking(robot, boot, parameters.silent_s)
        self._robot = Robot(robot, outline, mobility, zones, parameters)
        self._claiming = Claiming(self._robot, self.booking, precedence)
        self._behind_others = replace(mobility, reaction_s=mobility.reaction_s + parameters.sight_s)
        self._way: Way | None = None

    def drive(self, way: Way) -> None:
        """The way from now on. Bookings that are in use stay until their areas are left; the others are given back."""
        uses = uses_of(way, self._robot.corners, self._robot.zones.zones, self._robot.parameters.margin_m)
        self._claiming.follow(passages_of(uses, self._robot.standing_m))
        self._way = way

    def hear(self, message: ZoneMessage, now_s: float) -> None:
        """A message of another robot."""
        self.booking.hear(message, now_s)

    def step(
        self,
        now_ns: int,
        now_s: float,
        progress_m: float,
        speed_mps: float,
        seen: Mapping[str, Sighting],
        *,
        sight_age_s: float = 0.0,
    ) -> Advice:
        """One cycle. `progress_m` is how far along its way the robot's rotation centre is, `seen` the other vehicles as of
        `sight_age_s` ago. ValueError before the first `drive`."""
        if self._way is None:
            raise ValueError("no way was given")
        here = self._way.at(progress_m)
        near = self._robot.zones.near(here.x, here.y)
        leaders = ahead_on(self._way, progress_m, self._robot.outline, seen)
        situation = Situation(now_ns, now_s, self._way, progress_m, speed_mps, near, seen, sight_age_s, tuple(leaders))
        self._forget_those_away(situation)
        self._claiming.update(situation)
        limit, hold, authority_m = self._permitted(situation)
        stop = None if math.isinf(authority_m) else self._way.at(authority_m)
        message = self.booking.message(self._uses(situation), None if stop is None else (stop.x, stop.y))
        return Advice(min(limit, self._following(situation)), hold, message, self._recipients(situation))

    def _permitted(self, situation: Situation) -> tuple[float, Hold | None, float]:
        """The speed limit by the areas ahead (m/s), why the first closed one is closed, and where on the way it begins (m). An
        open area that the robot could hardly stop before any more counts as entered from now on."""
        limit, hold, authority_m = self._robot.mobility.speed_mps, None, math.inf
        for booked in self._claiming.booked:
            asked = relevant(booked.uses, situation, self._robot)
            standing = self.booking.standing(booked.claim, asked, situation.now_s)
            for use in booked.remaining:
                if use.area in booked.claim.entered:
                    continue
                why = refusal(
                    use,
                    booked.uses,
                    standing,
                    situation,
                    self._robot,
                    self.booking.records,
                    begun=booked.claim.begun,
                )
                if why is None:
                    if situation.at_line(use.enter_m, self._robot):
                        booked.claim.enter(use.area)
                    continue
                authority_m = min(authority_m, use.enter_m)
                limit = min(limit, self._approach(booked, use, situation))
                hold = hold or why
        unbooked = next((passage for passage in self._claiming.ahead if passage.exit_m > situation.progress_m), None)
        if unbooked is not None:
            authority_m = min(authority_m, unbooked.enter_m)
            room_m = unbooked.enter_m - LINE_M - situation.progress_m
            limit = min(limit, speed_to_stop(room_m, self._robot.mobility))
        return limit, hold, authority_m

    def _approach(self, booked: Booked, use: Use, situation: Situation) -> float:
        room_m = use.enter_m - LINE_M - situation.progress_m
        before = self.booking.before(booked.claim).get(use.area, ())
        if not booked.claim.established or not before:
            return speed_to_stop(room_m, self._robot.mobility)
        free_s = self._free_s(use.area, before, situation.now_s) + self._robot.parameters.notice_s
        return speed_to_be_there(room_m, free_s, situation.speed_mps, self._robot.mobility)

    def _free_s(self, area: str, before: Sequence[str], now_s: float) -> float:
        """In how many seconds the robots that go before expect to have left the area."""
        return max(
            (
                use.exit_s - (now_s - record.heard_s)
                for record in (self.booking.records[robot] for robot in before)
                for claim in record.message.claims
                for use in claim.areas
                if use.area == area
            ),
            default=0.0,
        )

    def _following(self, situation: Situation) -> float:
        limit = self._robot.mobility.speed_mps
        for leader in situation.leaders:
            if leader.turn_rad > _ACROSS_RAD and self._in_zone(situation.seen[leader.robot]):
                continue  # crosses: the booking says who goes first, and its area is not entered
            limit = min(limit, speed_behind(leader.gap_m, leader.speed_mps, self._robot.gap_m, self._behind_others))
        return limit

    def _in_zone(self, other: Sighting) -> bool:
        return any(self._robot.zones.touches(area, other) for area in self._robot.zones.areas)

    def _uses(self, situation: Situation) -> dict[str, AreaUse]:
        uses: dict[str, AreaUse] = {}
        for booked in self._claiming.booked:
            before = self.booking.before(booked.claim)
            free = {area: self._free_s(area, robots, situation.now_s) for area, robots in before.items() if robots}
            uses |= estimated_uses(
                booked.remaining, situation.progress_m, situation.speed_mps, self._robot.mobility, free
            )
        return uses

    def _recipients(self, situation: Situation) -> frozenset[str]:
        """Those near a zone that the robot is near, and all that it has heard."""
        further_m = self._robot.parameters.away_m
        at = {
            other
            for other, sighting in situation.seen.items()
            if self._robot.zones.near(sighting.pose.x, sighting.pose.y, further_m) & situation.near
        }
        return frozenset(at | self.booking.records.keys())

    def _forget_those_away(self, situation: Situation) -> None:
        """Silent ones that the cameras see far from every zone: their claims are void, they give them back themselves there."""
        parameters = self._robot.parameters
        for other, record in list(self.booking.records.items()):
            sighting = situation.seen.get(other)
            if (
                sighting is not None
                and situation.now_s - record.heard_s > parameters.silent_s
                and not self._robot.zones.near(sighting.pose.x, sighting.pose.y, parameters.away_m)
            ):
                self.booking.forget(other)
