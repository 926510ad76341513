"""One robot's cooperation with the others: its way, what it sees and hears in; a speed limit and its message out.

Pure like the booking it drives. One cycle: `hear` what came, then `step`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from agents.manoeuvres.approach import Mobility, speed_to_be_there, speed_to_stop, stopping_m
from agents.manoeuvres.booking import Booking, Claim, Order, Standing
from agents.manoeuvres.following import speed_behind
from agents.manoeuvres.parameters import DEFAULT, ManoeuvreParameters
from agents.manoeuvres.passages import Passage, Use, Way, passages_of, uses_of
from agents.manoeuvres.precedence import Precedence, by_delay
from agents.manoeuvres.timing import estimated_uses
from agents.manoeuvres.traffic import Ahead, Sighting, ZoneMap, ahead_on
from protocol.messages.zones import AreaUse, ZoneClaim, ZoneMessage

_STANDS_MPS = 0.02
_LINE_M = 0.02
"""How far before an area a robot stops: more than its estimate trembles, or one that begins anew there would think it is inside."""
_ACROSS_RAD = math.pi / 4
"""Another vehicle whose heading differs by more does not go the same way."""


@dataclass(frozen=True, slots=True)
class Hold:
    """Why the robot may not enter an area yet: `why` in words, and the robots that it waits for."""

    area: str
    why: str
    robots: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Advice:
    """What comes of a cycle: the speed limit (m/s), the first area that may not be entered (None: none), and what to send to whom."""

    speed_mps: float
    hold: Hold | None
    message: ZoneMessage
    recipients: frozenset[str]


@dataclass(slots=True)
class _Booked:
    claim: Claim
    uses: tuple[Use, ...]
    compared: set[tuple[str, int]] = field(default_factory=set[tuple[str, int]])

    @property
    def remaining(self) -> list[Use]:
        return [use for use in self.uses if use.area in self.claim.areas]

    @property
    def in_use(self) -> bool:
        return self.claim.begun


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
        self.robot = robot
        self.booking = Booking(robot, boot, parameters.silent_s)
        self._outline = np.asarray(outline, dtype=np.float64)
        self._zones = zones
        self._mobility = mobility
        self._parameters = parameters
        self._precedes = precedence
        self._way: Way | None = None
        self._ahead: list[Passage] = []
        self._booked: list[_Booked] = []
        self._behind_others = replace(mobility, reaction_s=mobility.reaction_s + parameters.sight_s)
        self._standing_m = float(np.ptp(self._outline[:, 0])) + 2 * parameters.margin_m + parameters.standing_m

    def drive(self, way: Way) -> None:
        """The way from now on. Bookings that are in use stay until their areas are left; the others are given back."""
        for booked in [booked for booked in self._booked if not booked.in_use]:
            self._withdraw(booked)
        uses = uses_of(
            way, [(float(x), float(y)) for x, y in self._outline], self._zones.zones, self._parameters.margin_m
        )
        self._way, self._ahead = way, passages_of(uses, self._standing_m)

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
        near = self._zones.near(here.x, here.y)
        self._forget_those_away(seen, now_s)
        self._leave(progress_m, near)
        leaders = ahead_on(self._way, progress_m, self._outline, seen)
        self._yield(progress_m, speed_mps, leaders, seen)
        self._book(now_ns, now_s, progress_m, speed_mps, near, leaders, seen)
        self._reconsider(now_s, progress_m, speed_mps)
        self.booking.acknowledge()
        limit = self._following(leaders, seen)
        hold: Hold | None = None
        authority = math.inf
        for booked in self._booked:
            standing = self.booking.standing(booked.claim, self._relevant(booked, seen), now_s)
            for use in booked.remaining:
                why = self._refused(booked, use, standing, seen, sight_age_s)
                stop_m = use.enter_m - progress_m - _LINE_M
                if why is None:
                    if stop_m <= stopping_m(speed_mps, self._mobility) + self._parameters.standing_m:
                        booked.claim.enter(use.area)
                    continue
                authority = min(authority, use.enter_m)
                limit = min(limit, self._approach(booked, use, stop_m, speed_mps, now_s))
                hold = hold or why
        unbooked = next((p for p in self._ahead if p.exit_m > progress_m), None)
        if unbooked is not None:
            authority = min(authority, unbooked.enter_m)
            limit = min(limit, speed_to_stop(unbooked.enter_m - progress_m - _LINE_M, self._mobility))
        stop = None if math.isinf(authority) else self._way.at(authority)
        message = self.booking.message(
            self._uses(now_s, progress_m, speed_mps), None if stop is None else (stop.x, stop.y)
        )
        return Advice(limit, hold, message, self._recipients(near, seen))

    # Booking

    def _book(
        self,
        now_ns: int,
        now_s: float,
        progress_m: float,
        speed_mps: float,
        near: frozenset[str],
        leaders: Sequence[Ahead],
        seen: Mapping[str, Sighting],
    ) -> None:
        self._ahead = [passage for passage in self._ahead if passage.exit_m > progress_m]
        while self._ahead and all(booked.claim.established for booked in self._booked):
            passage = self._ahead[0]
            inside = [use for use in passage.uses if use.enter_m + _LINE_M / 2 <= progress_m < use.exit_m]
            stop_m = passage.enter_m - progress_m
            waits = stop_m <= stopping_m(speed_mps, self._mobility) + self._parameters.standing_m
            if not inside and (
                not passage.zones <= near
                or not self._may_claim(passage.enter_m, progress_m, speed_mps, leaders)
                or (waits and self._no_room(passage.uses, seen))
            ):
                return
            areas = tuple(dict.fromkeys(use.area for use in passage.uses))
            mine = estimated_uses(passage.uses, progress_m, speed_mps, self._mobility, {})
            arrival_s = min(use.enter_s for use in mine.values())
            before: list[Order] = []
            behind = self._claims_ahead(passage.enter_m, areas, progress_m, leaders)
            for robot, theirs in self.booking.unanswered(areas):
                (before if self._before(mine, robot, theirs, now_s) else behind).append((theirs.rank, robot))
            if arrival_s > self._parameters.claim_ahead_s and not before and not inside:
                return
            claim = self.booking.claim(areas, now_ns + round(arrival_s * 1e9), before=before, behind=behind)
            for use in inside:  # where a robot finds itself when its manoeuvring begins: it is there, permitted or not
                claim.enter(use.area)
            self._booked.append(_Booked(claim, passage.uses))
            self._ahead.pop(0)
            return

    def _reconsider(self, now_s: float, progress_m: float, speed_mps: float) -> None:
        """Claims made at the same time knew nothing of each other: one that should go behind another that is not established
        either is made anew behind it, once for each such pair."""
        for booked in [booked for booked in self._booked if not booked.claim.established and not booked.in_use]:
            mine = estimated_uses(booked.uses, progress_m, speed_mps, self._mobility, {})
            behind = [
                (theirs.rank, robot)
                for robot, theirs in self.booking.standing_claims(booked.claim.areas)
                if not theirs.established
                and (theirs.rank, robot) > (booked.claim.rank, self.robot)
                and (robot, theirs.number) not in booked.compared
                and not self._before(mine, robot, theirs, now_s)
            ]
            booked.compared |= {
                (robot, theirs.number) for robot, theirs in self.booking.standing_claims(booked.claim.areas)
            }
            if behind:
                booked.claim = self.booking.claim_behind(booked.claim, behind)

    def _before(self, mine: Mapping[str, AreaUse], robot: str, theirs: ZoneClaim, now_s: float) -> bool:
        ago = now_s - self.booking.records[robot].heard_s
        other = {use.area: AreaUse(use.area, use.enter_s - ago, use.exit_s - ago) for use in theirs.areas}
        shared = mine.keys() & other.keys()
        return self._precedes(
            (self.robot, {area: mine[area] for area in shared}), (robot, {area: other[area] for area in shared})
        )

    def _before_passage(self, enter_m: float, progress_m: float, leaders: Sequence[Ahead]) -> list[Ahead]:
        """Vehicles that are ahead on the way and will be at the passage before the robot."""
        front_m = float(self._outline[:, 0].max())
        return [leader for leader in leaders if progress_m + front_m + leader.gap_m <= enter_m]

    def _may_claim(self, enter_m: float, progress_m: float, speed_mps: float, leaders: Sequence[Ahead]) -> bool:
        """Not past one that is ahead and has not booked: it would wait for the robot behind it; nor while standing behind one that
        stands: what it waits for may be waiting for this claim."""
        for leader in self._before_passage(enter_m, progress_m, leaders):
            record = self.booking.records.get(leader.robot)
            if record is None or not record.message.claims:
                return False
            if speed_mps < _STANDS_MPS and leader.speed_mps < _STANDS_MPS and leader.gap_m < self._standing_m:
                return False
        return True

    def _claims_ahead(
        self, enter_m: float, areas: Sequence[str], progress_m: float, leaders: Sequence[Ahead]
    ) -> list[Order]:
        """The claims of those ahead on the way on the same areas: they come first whatever their ranks."""
        return [
            (theirs.rank, leader.robot)
            for leader in self._before_passage(enter_m, progress_m, leaders)
            for robot, theirs in self.booking.standing_claims(areas)
            if robot == leader.robot
        ]

    def _leave(self, progress_m: float, near: frozenset[str]) -> None:
        for booked in list(self._booked):
            for area in booked.claim.areas:
                if all(use.exit_m <= progress_m for use in booked.uses if use.area == area):
                    self.booking.leave(booked.claim, area)
            if not booked.claim.areas:
                self._booked.remove(booked)
            elif not booked.in_use and not {use.zone for use in booked.remaining} <= near:
                self._withdraw(booked, again=True)

    def _yield(
        self, progress_m: float, speed_mps: float, leaders: Sequence[Ahead], seen: Mapping[str, Sighting]
    ) -> None:
        """Gives back bookings that are not in use where they would keep others waiting for nothing, or for ever."""
        for index, booked in enumerate(list(self._booked)):
            if booked.in_use:
                continue
            enter_m = min(use.enter_m for use in booked.remaining)
            at_line = enter_m - progress_m <= stopping_m(speed_mps, self._mobility) + self._parameters.standing_m
            if (at_line and self._no_room(booked.uses, seen)) or not self._may_claim(
                enter_m, progress_m, speed_mps, leaders
            ):
                for later in reversed(self._booked[index:]):
                    self._withdraw(later, again=True)
                return
            areas = booked.claim.areas
            overtaken = [
                order
                for order in self._claims_ahead(enter_m, areas, progress_m, leaders)
                if order > (booked.claim.rank, self.robot)
            ]
            if overtaken:
                booked.claim = self.booking.claim_behind(booked.claim, overtaken)
            elif any(self._keeps_in(booked.claim, robot) for area in areas for robot in self.booking.inside(area)):
                self._withdraw(booked, again=True)
                return

    def _keeps_in(self, claim: Claim, robot: str) -> bool:
        """Whether a robot that is in an area of the claim would wait for it: one that has begun anew there."""
        return any(
            (theirs.rank, robot) > (claim.rank, self.robot)
            for other, theirs in self.booking.standing_claims(claim.areas)
            if other == robot
        )

    def _withdraw(self, booked: _Booked, *, again: bool = False) -> None:
        self.booking.withdraw(booked.claim)
        self._booked.remove(booked)
        if again:
            self._ahead.insert(0, Passage(booked.uses))

    # Permission

    def _refused(
        self,
        booked: _Booked,
        use: Use,
        standing: Standing,
        seen: Mapping[str, Sighting],
        sight_age_s: float,
    ) -> Hold | None:
        if use.area in booked.claim.entered:
            return None
        if standing.missing:
            return Hold(use.area, "not all have agreed yet", tuple(sorted(standing.missing)))
        before = standing.before.get(use.area, ())
        if before:
            return Hold(use.area, "others go first", before)
        inside = tuple(sorted(robot for robot, other in seen.items() if self._zones.touches(use.area, other)))
        if inside:
            return Hold(use.area, "somebody is in it", inside)
        if booked.in_use:
            return None
        if sight_age_s > self._parameters.seen_s:
            return Hold(use.area, "the cameras have not been heard")
        if standing.silent:
            return Hold(use.area, "silent robots are near", tuple(sorted(standing.silent)))
        taken = self._no_room(booked.uses, seen)
        return Hold(use.area, "no room behind it", taken) if taken else None

    def _relevant(self, booked: _Booked, seen: Mapping[str, Sighting]) -> set[str]:
        zones = {use.zone for use in booked.uses}
        return {robot for robot, other in seen.items() if self._zones.near(other.pose.x, other.pose.y) & zones}

    def _no_room(self, uses: Sequence[Use], seen: Mapping[str, Sighting]) -> tuple[str, ...]:
        """Who comes to rest where the robot would have to, once it is out of the areas."""
        if self._way is None:
            return ()
        out = self._way.at(max(use.exit_m for use in uses))
        reach_m = float(np.hypot(*self._outline.T).max())
        taken: list[str] = []
        for robot, other in seen.items():
            record = self.booking.records.get(robot)
            rest = (other.pose.x, other.pose.y)
            if record is not None and record.message.authority is not None:
                rest = record.message.authority
            elif record is not None:
                continue
            if math.hypot(rest[0] - out.x, rest[1] - out.y) < reach_m + float(
                np.hypot(*np.asarray(other.outline).T).max()
            ):
                taken.append(robot)
        return tuple(sorted(taken))

    # Speed and times

    def _approach(self, booked: _Booked, use: Use, stop_m: float, speed_mps: float, now_s: float) -> float:
        before = self.booking.before(booked.claim).get(use.area, ())
        if not booked.claim.established or not before:
            return speed_to_stop(stop_m, self._mobility)
        free_s = self._free_s(use.area, before, now_s) + self._parameters.notice_s
        return speed_to_be_there(stop_m, free_s, speed_mps, self._mobility)

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

    def _following(self, leaders: Sequence[Ahead], seen: Mapping[str, Sighting]) -> float:
        limit = self._mobility.speed_mps
        for leader in leaders:
            if leader.turn_rad > _ACROSS_RAD and self._in_zone(seen[leader.robot]):
                continue  # crosses: the booking says who goes first, and its area is not entered
            limit = min(limit, speed_behind(leader.gap_m, leader.speed_mps, self._standing_gap_m, self._behind_others))
        return limit

    def _in_zone(self, other: Sighting) -> bool:
        return any(self._zones.touches(area, other) for area in self._zones.areas)

    @property
    def _standing_gap_m(self) -> float:
        return 2 * self._parameters.margin_m + self._parameters.standing_m

    def _uses(self, now_s: float, progress_m: float, speed_mps: float) -> dict[str, AreaUse]:
        uses: dict[str, AreaUse] = {}
        for booked in self._booked:
            before = self.booking.before(booked.claim)
            free = {area: self._free_s(area, robots, now_s) for area, robots in before.items() if robots}
            uses |= estimated_uses(booked.remaining, progress_m, speed_mps, self._mobility, free)
        return uses

    # Others

    def _recipients(self, near: frozenset[str], seen: Mapping[str, Sighting]) -> frozenset[str]:
        at = {
            robot
            for robot, other in seen.items()
            if self._zones.near(other.pose.x, other.pose.y, self._parameters.away_m) & near
        }
        return frozenset(at | self.booking.records.keys())

    def _forget_those_away(self, seen: Mapping[str, Sighting], now_s: float) -> None:
        """Silent ones that the cameras see far from every zone: their claims are void, for they give them back themselves there."""
        for robot, record in list(self.booking.records.items()):
            other = seen.get(robot)
            if (
                other is not None
                and now_s - record.heard_s > self._parameters.silent_s
                and not self._zones.near(other.pose.x, other.pose.y, self._parameters.away_m)
            ):
                self.booking.forget(robot)
