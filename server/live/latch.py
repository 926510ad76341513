"""The emergency stop as this server holds it: what Redis has, and beyond that a stop that Redis could not take (spec gpss,
"Safety").

The robots' open streams hear it before anything else is done, and who presses it is never told to come back later: without
Redis it lives in this process alone, and is written as soon as Redis is back.
"""

import asyncio
import logging

from redis.exceptions import RedisError

from protocol.clock import Clock
from protocol.errors import BusUnavailableError
from protocol.messages import EmergencyStop
from server.errors import UnavailableError
from server.live.feeds import CommandFeeds
from server.repositories.emergency_stop import EmergencyStopRepository, newer_epoch

_RETRY_S = 0.2
_AHEAD_MS = 3_600_000
"""An epoch this far ahead of the clock is no robot's: agents hold none that is more than half a minute ahead of theirs."""
_AWAY = (RedisError, OSError, BusUnavailableError, UnavailableError)
_logger = logging.getLogger(__name__)


class EmergencyStopLatch:
    """Engages, releases and reads; `run` must be running for what is not written yet to be written."""

    def __init__(self, repository: EmergencyStopRepository, feeds: CommandFeeds, clock: Clock) -> None:
        self._repository, self._feeds, self._clock = repository, feeds, clock
        self._unwritten = asyncio.Event()
        self._writing: set[asyncio.Future[EmergencyStop]] = set()

    async def get(self) -> EmergencyStop:
        """The latch as Redis has it, or as it will be written."""
        known = self._feeds.emergency_stop
        return known if known is not None and self._unwritten.is_set() else await self._repository.get()

    async def engage(self, reason: str, actor: str) -> EmergencyStop:
        """Engages it; when it is engaged already, the first reason stays. UnavailableError when Redis does not take it: the
        robots have been told then, and it will be written."""
        told = self._tell(reason, actor)
        writing = asyncio.ensure_future(self._repository.engage(told))
        self._writing.add(writing)
        writing.add_done_callback(self._writing.discard)
        writing.add_done_callback(_log_failure)
        try:
            return await asyncio.shield(writing)  # whoever pressed may be gone already
        except _AWAY as error:
            self._unwritten.set()
            raise UnavailableError(
                f"Redis is out of reach. The robots on the {len(self._feeds)} open streams of this server were told to "
                "stop at once; the stop is written as soon as Redis is back, provided that this server still runs then: "
                "do not restart it."
            ) from error

    async def release(self, actor: str) -> EmergencyStop:
        """Releases it for all; nothing is released while Redis is out of reach."""
        if self._writing:  # robots and people know of a stop before Redis does, and this release is of that stop
            await asyncio.wait(self._writing)
        await self._write()
        known = self._feeds.emergency_stop
        # Robots that hold a stop need a greater epoch, also where Redis knows of no stop.
        above = self._feeds.epoch + 1 if known is not None and known.engaged else self._feeds.epoch
        return await self._repository.release(actor, above=above)

    async def look(self) -> bool:
        """Takes what Redis says of the latch; whether that changed anything. When Redis has lost a stop, it is given it again.

        What was heard meanwhile may be newer than what was read: then the next look counts."""
        before = self._feeds.emergency_stop
        stop = await self._repository.get()
        if self._feeds.emergency_stop is not before:
            return False
        changed = self._feeds.stop(stop)
        known = self._feeds.emergency_stop
        if known is not None and known.engaged and not stop.engaged:
            self._unwritten.set()
        return changed

    def held(self, robot: str, epoch: int) -> None:
        """A robot holds a stop of that epoch. One that this server does not know of came by broadcast: it becomes everybody's,
        so that people see it and can release it."""
        known = self._feeds.emergency_stop
        if known is None or epoch <= known.epoch or epoch > self._clock.now_ns() // 1_000_000 + _AHEAD_MS:
            return
        if known.engaged:
            stop = known.model_copy(update={"epoch": epoch})
        else:
            reason = f"{robot} holds an emergency stop that was sent by broadcast"
            stop = EmergencyStop(
                engaged=True, epoch=epoch, stamp_ns=self._clock.now_ns(), by="broadcast", reason=reason
            )
            _logger.warning("%s", reason)
        if self._feeds.stop(stop):
            self._unwritten.set()

    async def run(self) -> None:
        """Writes what Redis could not take, until cancelled."""
        while True:
            await self._unwritten.wait()
            try:
                await self._write()
            except _AWAY:
                await self._clock.sleep(_RETRY_S)

    async def _write(self) -> None:
        known = self._feeds.emergency_stop
        if self._unwritten.is_set() and known is not None and known.engaged:
            await self._repository.restore(known)
        self._unwritten.clear()

    def _tell(self, reason: str, actor: str) -> EmergencyStop:
        """The stop as it is to be written; the streams have it, or know of an earlier one."""
        now_ns = self._clock.now_ns()
        epoch = newer_epoch(self._feeds.epoch, now_ns)
        stop = EmergencyStop(engaged=True, epoch=epoch, stamp_ns=now_ns, by=actor, reason=reason)
        known = self._feeds.emergency_stop
        if known is None or not known.engaged:
            self._feeds.stop(stop)
        return stop


def _log_failure(writing: "asyncio.Future[EmergencyStop]") -> None:
    """Also when nobody waits any more for what was written."""
    if not writing.cancelled() and (error := writing.exception()) is not None:
        _logger.warning("the emergency stop could not be written: %s", error)
