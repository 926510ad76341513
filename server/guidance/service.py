"""Guidance as a service: acquires the lease, then a cycle at its rate; stands by while another is active; goes on by itself
after Redis, or the lease, was away."""

import logging

import redis
import redis.asyncio

from protocol.clock import Clock
from protocol.lab import Lab
from server.guidance.fleet import Guidance, takeover_event
from server.guidance.parameters import GuidanceParameters
from server.guidance.snapshot import Outcome
from server.guidance.store import GuidanceStore, newer_epochs, obeyed_epochs

_logger = logging.getLogger(__name__)
_STANDBY_S = 0.2
_RETRY_S = 0.1


class GuidanceService:
    """Runs until its task is cancelled, and then gives the lease back."""

    def __init__(self, lab: Lab, client: redis.asyncio.Redis, clock: Clock, parameters: GuidanceParameters) -> None:
        self._store = GuidanceStore(client, clock)
        self._clock = clock
        self._lab, self._parameters = lab, parameters
        self._core = Guidance(lab, parameters)
        self._period_s = 1.0 / parameters.rate_hz
        self._epoch: int | None = None
        self._last_epoch = 0
        self._down = False

    @property
    def epoch(self) -> int | None:
        """The epoch while active, None while standing by."""
        return self._epoch

    async def run(self) -> None:
        next_s = self._clock.monotonic_s()
        try:
            while True:
                try:
                    wait_s = await self._turn()
                    self._note_up()
                except (redis.RedisError, OSError) as error:
                    self._note_down(error)
                    wait_s = _RETRY_S
                # A cycle that ran late is not made up for: the next one starts from now.
                next_s = max(next_s + wait_s, self._clock.monotonic_s())
                await self._clock.sleep(next_s - self._clock.monotonic_s())
        finally:
            await self._give_back()

    async def _turn(self) -> float:
        """One cycle, or one try to become active; the seconds until the next."""
        if self._epoch is None and not await self._become_active():
            return _STANDBY_S
        assert self._epoch is not None
        snapshot = await self._store.snapshot()
        if newer_epochs(obeyed_epochs(snapshot), self._epoch):
            # Redis lost the newest epoch (a power cut): robots would refuse every command.
            _logger.warning("robots know a newer epoch than %d; taking a new one", self._epoch)
            await self._store.release(self._epoch)
            self._epoch = None
            return 0.0
        if not await self._store.say(self._core.cycle(snapshot, self._epoch), self._epoch):
            _logger.warning("epoch %d lost its lease; standing by", self._epoch)
            self._epoch = None
            return _STANDBY_S
        return self._period_s

    async def _become_active(self) -> bool:
        snapshot = await self._store.snapshot()
        above = max(self._last_epoch, await self._store.highest_epoch(snapshot))
        epoch = await self._store.acquire(above)
        if epoch is None:
            return False
        self._epoch = self._last_epoch = epoch
        # What it remembers of robots is of before: another may have driven them on since.
        self._core = Guidance(self._lab, self._parameters, said=self._core.sequence)
        _logger.info("active, epoch %d", epoch)
        news = Outcome(commands={}, states={}, changes=(), events=(takeover_event(epoch, snapshot.now_ns),))
        return await self._store.say(news, epoch)

    async def _give_back(self) -> None:
        if self._epoch is None:
            return
        try:
            await self._store.release(self._epoch)
        except (redis.RedisError, OSError) as error:
            _logger.warning("could not give the lease back, it runs out by itself: %s", error)
        self._epoch = None

    def _note_down(self, error: Exception) -> None:
        if not self._down:
            _logger.warning("Redis is out of reach: %s", error)
        self._down = True

    def _note_up(self) -> None:
        if self._down:
            _logger.info("Redis is back")
        self._down = False
