"""Who should go first of two, as the one of them sees it that has not booked yet."""

from collections.abc import Callable, Mapping
from typing import TypeAlias

from protocol.messages.zones import AreaUse

Uses: TypeAlias = Mapping[str, AreaUse]
"""By area, when it will be entered and left, in seconds from now."""
Precedence: TypeAlias = Callable[[tuple[str, Uses], tuple[str, Uses]], bool]
"""Whether the first robot (its id and uses) should go before the second. Uses have the areas that both need."""

TIE_S = 1.0
_ALIKE_S = 0.1


def by_arrival(me: tuple[str, Uses], other: tuple[str, Uses]) -> bool:
    """The earlier arrival; within a second of each other the lower id (Gulliver 2025, 3.2)."""
    mine = min(use.enter_s for use in me[1].values())
    theirs = min(use.enter_s for use in other[1].values())
    return me[0] < other[0] if abs(mine - theirs) <= TIE_S else mine < theirs


def by_delay(me: tuple[str, Uses], other: tuple[str, Uses]) -> bool:
    """The one whose going first costs the other less time; when that is about the same, the lower id."""
    theirs = _delay_s(other[1], me[1])
    mine = _delay_s(me[1], other[1])
    return me[0] < other[0] if abs(mine - theirs) <= _ALIKE_S else theirs < mine


def _delay_s(later: Uses, first: Uses) -> float:
    """How much later one is that has to wait for each shared area until the other has left it."""
    return max(0.0, *(first[area].exit_s - use.enter_s for area, use in later.items()))
