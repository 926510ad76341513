"""Says in the log whether the estimator is as good as it thinks: seldom while it is, once a minute while it is not."""

import logging
import math

from agents.pilot import Pilot

LOOK_EVERY_S = 60.0
TELL_EVERY_S = 600.0
_logger = logging.getLogger(__name__)


class ConsistencyLog:
    """Of one robot; to be asked as often as one likes."""

    def __init__(self, pilot: Pilot, now_s: float) -> None:
        self._pilot = pilot
        self._look_s = now_s + LOOK_EVERY_S
        self._told_s = -math.inf

    def look(self, now_s: float) -> None:
        """`now_s`: the monotonic clock."""
        if now_s < self._look_s:
            return
        self._look_s = now_s + LOOK_EVERY_S
        report = self._pilot.consistency()
        if report is None or report.count == 0:
            return
        if not report.is_consistent or now_s - self._told_s >= TELL_EVERY_S:
            self._told_s = now_s
            _logger.log(logging.INFO if report.is_consistent else logging.WARNING, "pose estimate %s", report)
