"""When a robot books its passages, and when it gives a booking back."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from agents.manoeuvres.booking import Booking, Claim, Order
from agents.manoeuvres.passages import Passage, Use
from agents.manoeuvres.permission import no_room
from agents.manoeuvres.precedence import Precedence
from agents.manoeuvres.situation import STANDS_MPS, Robot, Situation
from agents.manoeuvres.timing import estimated_uses
from protocol.messages.zones import AreaUse, ZoneClaim


@dataclass(slots=True)
class Booked:
    """A passage that is claimed; `compared`: others' claims that it was weighed against."""

    claim: Claim
    uses: tuple[Use, ...]
    compared: set[tuple[str, int]] = field(default_factory=set[tuple[str, int]])

    @property
    def remaining(self) -> list[Use]:
        """What the robot has yet to leave."""
        return [use for use in self.uses if use.area in self.claim.areas]

    @property
    def enter_m(self) -> float:
        return min(use.enter_m for use in self.remaining)


class Claiming:
    """One robot's: the passages `ahead` that are not booked, and those `booked`, in the order of the way."""

    def __init__(self, robot: Robot, booking: Booking, precedence: Precedence) -> None:
        self.ahead: list[Passage] = []
        self.booked: list[Booked] = []
        self._robot = robot
        self._booking = booking
        self._precedes = precedence

    def follow(self, passages: Sequence[Passage]) -> None:
        """Another way. Bookings in use stay until their areas are left; the others are given back."""
        for booked in [booked for booked in self.booked if not booked.claim.begun]:
            self._give_back(booked)
        self.ahead = list(passages)

    def update(self, situation: Situation) -> None:
        """One cycle: leaves what is behind, gives back, books, and acknowledges what others claim."""
        self._leave(situation)
        self._yield(situation)
        self._book(situation)
        self._reconsider(situation)
        self._booking.acknowledge()

    def _book(self, situation: Situation) -> None:
        """The next passage, once all before it are agreed upon."""
        self.ahead = [passage for passage in self.ahead if passage.exit_m > situation.progress_m]
        if not self.ahead or not all(booked.claim.established for booked in self.booked):
            return
        passage = self.ahead[0]
        inside = [use for use in passage.uses if situation.is_in(use)]
        if not inside and not self._may_book(passage, situation):
            return
        areas = tuple(dict.fromkeys(use.area for use in passage.uses))
        mine = self._times(passage.uses, situation)
        arrival_s = min(use.enter_s for use in mine.values())
        before: list[Order] = []
        behind = self._of_those_ahead(passage.enter_m, areas, situation)
        for other, theirs in self._booking.unanswered(areas):
            (before if self._precede(mine, other, theirs, situation) else behind).append((theirs.rank, other))
        if arrival_s > self._robot.parameters.claim_ahead_s and not before and not inside:
            return
        claim = self._booking.claim(areas, situation.now_ns + round(arrival_s * 1e9), before=before, behind=behind)
        for use in inside:  # where a robot finds itself when its manoeuvring begins: it is there, permitted or not
            claim.enter(use.area)
        self.booked.append(Booked(claim, passage.uses))
        self.ahead.pop(0)

    def _may_book(self, passage: Passage, situation: Situation) -> bool:
        """Only where all its zones are near: the cameras' view of who matters to it is then that of the others too."""
        return (
            passage.zones <= situation.near
            and self._free_to_claim(passage.enter_m, situation)
            and not self._stuck_at_line(passage.enter_m, passage.uses, situation)
        )

    def _free_to_claim(self, enter_m: float, situation: Situation) -> bool:
        """Not past one that is ahead and has not booked: it would wait for the robot behind it; nor while standing behind one
        that stands: what that waits for may be waiting for this claim."""
        for leader in situation.before(enter_m, self._robot):
            record = self._booking.records.get(leader.robot)
            if record is None or not record.message.claims:
                return False
            both_stand = situation.speed_mps < STANDS_MPS and leader.speed_mps < STANDS_MPS
            if both_stand and leader.gap_m < self._robot.standing_m:
                return False
        return True

    def _stuck_at_line(self, enter_m: float, uses: Sequence[Use], situation: Situation) -> bool:
        """Whether the robot would wait before the areas for room behind them, and others for it."""
        return situation.at_line(enter_m, self._robot) and bool(
            no_room(uses, situation, self._robot, self._booking.records)
        )

    def _reconsider(self, situation: Situation) -> None:
        """Claims made at the same time knew nothing of each other: one that should go behind another that is not established
        either is made anew behind it, once for each such pair."""
        for booked in [booked for booked in self.booked if not booked.claim.established and not booked.claim.begun]:
            mine = self._times(booked.uses, situation)
            others = self._booking.standing_claims(booked.claim.areas)
            behind = [
                (theirs.rank, other)
                for other, theirs in others
                if not theirs.established
                and (theirs.rank, other) > (booked.claim.rank, self._robot.id)
                and (other, theirs.number) not in booked.compared
                and not self._precede(mine, other, theirs, situation)
            ]
            booked.compared |= {(other, theirs.number) for other, theirs in others}
            if behind:
                booked.claim = self._booking.claim_behind(booked.claim, behind)

    def _precede(self, mine: Mapping[str, AreaUse], other: str, theirs: ZoneClaim, situation: Situation) -> bool:
        ago_s = situation.now_s - self._booking.records[other].heard_s
        uses = {use.area: AreaUse(use.area, use.enter_s - ago_s, use.exit_s - ago_s) for use in theirs.areas}
        shared = mine.keys() & uses.keys()
        return self._precedes(
            (self._robot.id, {area: mine[area] for area in shared}), (other, {area: uses[area] for area in shared})
        )

    def _of_those_ahead(self, enter_m: float, areas: Sequence[str], situation: Situation) -> list[Order]:
        """The claims on the areas of vehicles ahead on the way: they come first whatever their ranks."""
        leaders = {leader.robot for leader in situation.before(enter_m, self._robot)}
        return [(theirs.rank, other) for other, theirs in self._booking.standing_claims(areas) if other in leaders]

    def _leave(self, situation: Situation) -> None:
        for booked in list(self.booked):
            for area in booked.claim.areas:
                if all(use.exit_m <= situation.progress_m for use in booked.uses if use.area == area):
                    self._booking.leave(booked.claim, area)
            if not booked.claim.areas:
                self.booked.remove(booked)
            elif not booked.claim.begun and not {use.zone for use in booked.remaining} <= situation.near:
                self._give_back(booked, again=True)

    def _yield(self, situation: Situation) -> None:
        """Gives back bookings that are not in use where they would keep others waiting for nothing, or for ever."""
        for index, booked in enumerate(list(self.booked)):
            if booked.claim.begun:
                continue
            if self._stuck_at_line(booked.enter_m, booked.uses, situation) or not self._free_to_claim(
                booked.enter_m, situation
            ):
                for later in reversed(self.booked[index:]):
                    self._give_back(later, again=True)
                return
            mine = (booked.claim.rank, self._robot.id)
            overtaken = [
                order for order in self._of_those_ahead(booked.enter_m, booked.claim.areas, situation) if order > mine
            ]
            if overtaken:
                booked.claim = self._booking.claim_behind(booked.claim, overtaken)
            elif self._keeps_in(booked.claim):
                self._give_back(booked, again=True)
                return

    def _keeps_in(self, claim: Claim) -> bool:
        """Whether one that is in an area of the claim would wait for it to leave: one that has begun anew there."""
        inside = {other for area in claim.areas for other in self._booking.inside(area)}
        return any(
            other in inside and (theirs.rank, other) > (claim.rank, self._robot.id)
            for other, theirs in self._booking.standing_claims(claim.areas)
        )

    def _give_back(self, booked: Booked, *, again: bool = False) -> None:
        self._booking.withdraw(booked.claim)
        self.booked.remove(booked)
        if again:
            self.ahead.insert(0, Passage(booked.uses))

    def _times(self, uses: Sequence[Use], situation: Situation) -> dict[str, AreaUse]:
        """When the robot would use the areas if nobody were in its way."""
        return estimated_uses(uses, situation.progress_m, situation.speed_mps, self._robot.mobility, {})
