"""The newest tracks for a camera's loop, fetched in a thread of its own: a slow Redis must not hold frames up.

It reads the channel's newest messages at a fixed rate instead of being told of each one: a hundred messages a second for
every camera would cost more than looking for tags does.
"""

import logging
import threading

import redis

from protocol.bus import SyncBus
from protocol.channels import POSES
from protocol.messages import TrackedPose

_logger = logging.getLogger(__name__)


class PoseFeed:
    """Keeps `newest` up to date until closed; while Redis is out of reach it stays as it was, and ages."""

    def __init__(self, bus: SyncBus, rate_hz: float) -> None:
        self._bus, self._period_s = bus, 1.0 / rate_hz
        self._newest: dict[str, TrackedPose] = {}
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="pose-feed", daemon=True)
        self._thread.start()

    @property
    def newest(self) -> dict[str, TrackedPose]:
        """Vehicle id -> its newest pose, of any age."""
        return self._newest

    def close(self) -> None:
        self._ended.set()
        self._thread.join(timeout=0.2)

    def _run(self) -> None:
        while not self._ended.wait(self._period_s):
            try:
                self._newest = self._bus.latest_all(POSES) or self._newest
            except redis.RedisError:
                _logger.exception("cannot read the tracks")  # and go on: the camera also follows what it saw last
