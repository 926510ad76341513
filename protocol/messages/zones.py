"""What robots tell one another about exclusive zones: msgspec structs, checked when decoded, frozen.

Every message says all that its robot claims and all that it has acknowledged, so a later one replaces an earlier one: lost,
doubled and overtaken messages need no handling but "the newest counts".
"""

from enum import StrEnum
from typing import Annotated

from msgspec import Meta, Struct

from protocol.messages.base import Real, Whole

AreaId = Annotated[str, Meta(min_length=1, max_length=65)]
"""A sub-area, as `zone/sub-area`."""
MOST_AREAS = 24
MOST_CLAIMS = 4


class ZoneMessageType(StrEnum):
    """Spec manoeuvres: HB while nothing happens, ENTER when a booking begins, EXIT when areas were left."""

    HB = "HB"
    ENTER = "ENTER"
    EXIT = "EXIT"


class AreaUse(Struct, frozen=True, forbid_unknown_fields=True):
    """A sub-area that the robot has yet to leave, and in how many seconds from the message's stamp it expects to touch it first
    and to have left it (seconds from now need no agreement of clocks). `inside`: it is in it, or cannot stop before it any
    more."""

    area: AreaId
    enter_s: Real
    exit_s: Real
    inside: bool = False


class ZoneClaim(Struct, frozen=True, forbid_unknown_fields=True):
    """A booking of some sub-areas at once. `number` names it, no other claim of the robot has it. Of two claims that share an
    area the one of the lower `rank` goes first (of equal ones, the lower robot id's); `established`: all who matter have
    acknowledged it, so no claim of a lower rank is acknowledged any more."""

    number: Whole
    rank: Whole
    established: bool
    areas: Annotated[tuple[AreaUse, ...], Meta(max_length=MOST_AREAS)]


class ZoneMessage(Struct, frozen=True, forbid_unknown_fields=True):
    """Robot to robots near a zone. Ordered by (`boot`, `sequence`); `boot` is when the sender's manoeuvring began (ns), and what
    it had promised before that it may have forgotten. `acks` has, by robot, the numbers of the claims it has acknowledged: of
    those of a lower rank than its own it will use no shared area before they are released. `authority` is where its rotation
    centre may come to rest without a further permission (m, map frame; None: anywhere on its way)."""

    type: ZoneMessageType
    robot: Annotated[str, Meta(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]
    boot: Whole
    sequence: Whole
    claims: Annotated[tuple[ZoneClaim, ...], Meta(max_length=MOST_CLAIMS)] = ()
    acks: dict[str, tuple[Whole, ...]] = {}
    authority: tuple[Real, Real] | None = None
