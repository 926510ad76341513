"""How long a robot has waited for what is in its way, and what came of looking for a way around it."""

from dataclasses import dataclass, replace

from protocol.messages import Blockage, Reason, ReasonCode


@dataclass(frozen=True, slots=True)
class Stuck:
    """Since when (monotonic seconds) a robot waits for something in its way, what that is, and what came of the search for a way
    around it: why there is none, and when to search again."""

    since_s: float | None = None
    blockage: Blockage | None = None
    in_vain: str = ""
    again_s: float = 0.0

    def after(self, reason: Reason | None, blockage: Blockage | None, now_s: float) -> "Stuck":
        """After a cycle with, or without, a reason to wait."""
        if reason is None or reason.code is ReasonCode.OUTSIDE_AREA:
            return Stuck()
        since_s = now_s if self.since_s is None else self.since_s
        return replace(self, since_s=since_s, blockage=blockage)

    def for_s(self, now_s: float) -> float:
        """How long it has lasted; 0 when it does not."""
        return 0.0 if self.since_s is None else now_s - self.since_s
