"""Who goes first: the distributed booking of exclusive areas, as one robot sees it.

Pure: messages, sightings and times come in, the own message and what may be entered come out. The rules, whose safety is argued
in docs/manoeuvres.md:

1. A robot *claims* all areas of one passage at once, with a rank. Ranks (with the robot's id) order all claims.
2. It *acknowledges* a claim of another by its number, unless it has an established claim of a higher rank on a shared area: no
   claim overtakes an established one. The claimant then claims anew with a higher rank.
3. Whoever has acknowledged a claim makes no later claim of a lower rank on a shared area while that one stands.
4. A claim is *established* once every relevant robot has acknowledged it; it stays so.
5. An area may be entered with an established claim when no acknowledged claim of a lower rank has it any more, and nobody says
   that it is in it.

Safety needs that the newest message counts, that acknowledgements name claims, and rules 4 and 5; rules 2 and 3 keep those who
have been promised their turn from being overtaken. Nothing of this depends on clocks: times serve the order (who would be there
first) and the plan (when an area will be free).
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from msgspec.structs import replace

from protocol.messages.zones import AreaUse, ZoneClaim, ZoneMessage, ZoneMessageType

Order: TypeAlias = tuple[int, str]
"""A claim's rank and its robot: all claims of all robots are ordered by it."""


@dataclass(frozen=True, slots=True)
class Record:
    """The newest message of another robot, and when it came (s, monotonic)."""

    message: ZoneMessage
    heard_s: float


@dataclass(slots=True)
class Claim:
    """One of the robot's own: the areas not yet left, in the order of the way, and those that it may enter or is in."""

    number: int
    rank: int
    areas: tuple[str, ...]
    established: bool = False
    entered: set[str] = field(default_factory=set[str])
    begun: bool = False

    def enter(self, area: str) -> None:
        """The robot is in the area, or cannot stop before it any more."""
        self.entered.add(area)
        self.begun = True


@dataclass(frozen=True, slots=True)
class Standing:
    """How a claim stands: who has not acknowledged it, who is silent, and by area the robots that go before."""

    missing: frozenset[str]
    silent: frozenset[str]
    before: Mapping[str, tuple[str, ...]]

    def open(self, area: str) -> bool:
        """Whether nobody who goes before has the area any more, and all have agreed."""
        return not self.missing and not self.before.get(area)


class Booking:
    """One robot's. `boot` and the numbers of claims must be higher than those of its life before (ns of its clock will do);
    a robot not heard for `silent_s` counts as silent."""

    def __init__(self, robot: str, boot: int, silent_s: float = 0.5) -> None:
        self.robot = robot
        self.claims: list[Claim] = []
        self._boot = boot
        self._silent_s = silent_s
        self._sequence = 0
        self._number = boot
        self._records: dict[str, Record] = {}
        self._acked: dict[str, set[int]] = {}
        self._type = ZoneMessageType.HB

    @property
    def records(self) -> Mapping[str, Record]:
        """The newest message of every robot that was heard and not forgotten."""
        return self._records

    def hear(self, message: ZoneMessage, now_s: float) -> bool:
        """Whether the message was newer than what was known of its robot. It is acknowledged by `acknowledge` alone."""
        known = self._records.get(message.robot)
        if message.robot == self.robot or (known is not None and _age(message) <= _age(known.message)):
            return False
        self._records[message.robot] = Record(message, now_s)
        standing = {claim.number for claim in message.claims}
        self._acked[message.robot] = self._acked.get(message.robot, set()) & standing
        return True

    def forget(self, robot: str) -> None:
        """Nothing is known of that robot any more: it has been seen far from the zones, or a person has released its hold."""
        self._records.pop(robot, None)
        self._acked.pop(robot, None)

    def standing_claims(self, areas: Collection[str]) -> list[tuple[str, ZoneClaim]]:
        """Others' claims on one of the areas."""
        return [(robot, claim) for robot, claim in self._others() if _shares(claim, areas)]

    def unanswered(self, areas: Collection[str]) -> list[tuple[str, ZoneClaim]]:
        """Those of them that are neither acknowledged nor established: one could still go before."""
        return [
            (robot, claim)
            for robot, claim in self.standing_claims(areas)
            if claim.number not in self._acked[robot] and not claim.established
        ]

    def claim(
        self, areas: tuple[str, ...], wish: int, *, before: Iterable[Order] = (), behind: Iterable[Order] = ()
    ) -> Claim:
        """Books the areas with a rank of `wish` as nearly as can be, lower than those of `before` and higher than those of
        `behind`. Where that contradicts, `behind` counts, and with it what was acknowledged or is established (rule 3)."""
        bound = [
            (claim.rank, robot)
            for robot, claim in self._others()
            if _shares(claim, areas) and (claim.established or claim.number in self._acked[robot])
        ]
        rank = min((self._ahead(order) for order in before), default=wish)
        rank = max(min(rank, wish), *(self._behind(order) for order in (*bound, *behind)), -(2**62))
        self._number += 1
        claim = Claim(self._number, rank, areas)
        self.claims.append(claim)
        self._type = ZoneMessageType.ENTER
        return claim

    def claim_behind(self, claim: Claim, behind: Iterable[Order]) -> Claim:
        """Makes a claim that is neither established nor begun anew, with a higher rank than those."""
        self.withdraw(claim)
        return self.claim(claim.areas, claim.rank, behind=behind)

    def withdraw(self, claim: Claim) -> None:
        """Gives back a claim none of whose areas were entered. ValueError otherwise."""
        if claim.begun:
            raise ValueError(f"claim {claim.number} is in use")
        self.claims.remove(claim)
        self._type = ZoneMessageType.EXIT

    def leave(self, claim: Claim, area: str) -> None:
        """The robot has left the area wholly: it is free for the next."""
        claim.areas = tuple(other for other in claim.areas if other != area)
        claim.entered.discard(area)
        if not claim.areas:
            self.claims.remove(claim)
        self._type = ZoneMessageType.EXIT

    def acknowledge(self) -> None:
        """Acknowledges what rule 2 allows, and claims anew where a claim of the robot's own met an established one of a higher
        rank that will not be overtaken."""
        for robot, theirs in self._others():
            if theirs.number not in self._acked[robot] and not any(
                mine.established and _shares(theirs, mine.areas) and (theirs.rank, robot) < (mine.rank, self.robot)
                for mine in self.claims
            ):
                self._acked[robot].add(theirs.number)
        for mine in [claim for claim in self.claims if not claim.established]:
            if any(self._is_refused(mine, robot, theirs) for robot, theirs in self._others()):
                renewed = self.claim(mine.areas, mine.rank)
                self.claims.remove(renewed)
                mine.number, mine.rank = renewed.number, renewed.rank

    def standing(self, claim: Claim, relevant: Collection[str], now_s: float) -> Standing:
        """Establishes the claim when the `relevant` robots and all that claim one of its areas have acknowledged it."""
        asked = set(relevant) | {robot for robot, theirs in self._others() if _shares(theirs, claim.areas)}
        asked.discard(self.robot)
        silent = frozenset(robot for robot in asked if self._is_silent(robot, now_s))
        missing = frozenset(robot for robot in asked if robot in silent or not self._has_acked(robot, claim.number))
        if not missing:
            claim.established = True
        return Standing(frozenset() if claim.established else missing, silent, self.before(claim))

    def before(self, claim: Claim) -> dict[str, tuple[str, ...]]:
        """By area of the claim, the robots that go before and still have it, or are in it."""
        ahead = [
            (robot, theirs)
            for robot, theirs in self._others()
            if theirs.number in self._acked[robot] and (theirs.rank, robot) < (claim.rank, self.robot)
        ]
        return {
            area: tuple(sorted({robot for robot, theirs in ahead if _shares(theirs, (area,))} | self.inside(area)))
            for area in claim.areas
        }

    def inside(self, area: str) -> set[str]:
        """The robots that say they are in the area, whatever their ranks: one that has begun anew there has forgotten its
        rank."""
        return {robot for robot, theirs in self._others() for use in theirs.areas if use.inside and use.area == area}

    def message(self, uses: Mapping[str, AreaUse], authority: tuple[float, float] | None = None) -> ZoneMessage:
        """What is to be sent now to all who matter. `uses` has, by area, when it will be entered and left."""
        self._sequence += 1
        kind, self._type = self._type, ZoneMessageType.HB
        return ZoneMessage(
            kind,
            self.robot,
            self._boot,
            self._sequence,
            tuple(
                ZoneClaim(
                    claim.number,
                    claim.rank,
                    claim.established,
                    tuple(replace(uses[area], inside=area in claim.entered) for area in claim.areas),
                )
                for claim in self.claims
            ),
            {robot: tuple(sorted(numbers)) for robot, numbers in self._acked.items() if numbers},
            authority,
        )

    def _others(self) -> list[tuple[str, ZoneClaim]]:
        return [(robot, claim) for robot, record in self._records.items() for claim in record.message.claims]

    def _is_refused(self, mine: Claim, robot: str, theirs: ZoneClaim) -> bool:
        return (
            theirs.established
            and _shares(theirs, mine.areas)
            and (theirs.rank, robot) > (mine.rank, self.robot)
            and not self._has_acked(robot, mine.number)
        )

    def _has_acked(self, robot: str, number: int) -> bool:
        record = self._records.get(robot)
        return record is not None and number in record.message.acks.get(self.robot, ())

    def _is_silent(self, robot: str, now_s: float) -> bool:
        record = self._records.get(robot)
        return record is None or now_s - record.heard_s > self._silent_s

    def _behind(self, order: Order) -> int:
        rank, robot = order
        return rank if robot < self.robot else rank + 1

    def _ahead(self, order: Order) -> int:
        rank, robot = order
        return rank if self.robot < robot else rank - 1


def _age(message: ZoneMessage) -> tuple[int, int]:
    return message.boot, message.sequence


def _shares(claim: ZoneClaim, areas: Collection[str]) -> bool:
    return any(use.area in areas for use in claim.areas)
