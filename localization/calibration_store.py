"""The calibrator's reads and writes: what is in force, runs, proposals; each change with its line of history in one MULTI."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar, cast

from pydantic import BaseModel
from redis.asyncio.client import Pipeline
from redis.exceptions import WatchError

from protocol import keys
from protocol.bus import Bus
from protocol.channels import CALIBRATION_RUNS, EVENTS, LAB_INSTANCE
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.messages import Calibration, CalibrationProposal, CalibrationRun, CameraExtrinsics, Event
from protocol.messages.calibration import CURRENT, PREVIOUS

M = TypeVar("M", bound=BaseModel)
_STREAM_LENGTH = 10_000


@dataclass(frozen=True, slots=True)
class Stored:
    """What Redis has; damaged records count as absent, since a new result replaces them."""

    current: Calibration | None
    extrinsics: dict[str, CameraExtrinsics]
    proposal: CalibrationProposal | None


class CalibrationStore:
    """Redis' own errors pass through."""

    def __init__(self, bus: Bus) -> None:
        self._redis = bus.redis

    async def read(self) -> Stored:
        """The result in force, what each camera uses, and the proposal that waits."""
        async with self._redis.pipeline(transaction=True) as reads:
            reads.hget(keys.CALIBRATIONS, CURRENT)  # pyright: ignore[reportUnusedCoroutine]  # queued
            reads.hgetall(keys.EXTRINSICS)  # pyright: ignore[reportUnusedCoroutine]  # queued
            reads.hget(keys.CALIBRATION_PROPOSALS, LAB_INSTANCE)  # pyright: ignore[reportUnusedCoroutine]  # queued
            current, extrinsics, proposal = cast(
                "tuple[bytes | None, dict[bytes, bytes], bytes | None]", tuple(await reads.execute())
            )
        found: dict[str, CameraExtrinsics] = {}
        for name, data in extrinsics.items():
            try:
                found[name.decode(errors="replace")] = decode(CameraExtrinsics, data)
            except DecodeError:
                continue
        return Stored(_decoded(Calibration, current), found, _decoded(CalibrationProposal, proposal))

    async def put_in_force(self, calibration: Calibration, event: Event) -> bool:
        """Makes it the result in force, keeps the one before, drops a proposal that it outdates. False when somebody else
        changed what is in force meanwhile; nothing was written then."""
        async with self._redis.pipeline(transaction=True) as pipeline:
            try:
                await pipeline.watch(keys.CALIBRATIONS)
                before = cast("bytes | None", await pipeline.hget(keys.CALIBRATIONS, CURRENT))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
                known = _decoded(Calibration, before)
                if known is not None and known.stamp_ns > calibration.stamp_ns:
                    return False
                pipeline.multi()
                if known is not None and before is not None:
                    pipeline.hset(keys.CALIBRATIONS, PREVIOUS, before)  # pyright: ignore[reportUnusedCoroutine]  # queued
                pipeline.hset(keys.CALIBRATIONS, CURRENT, encode(calibration))  # pyright: ignore[reportUnusedCoroutine]  # queued
                pipeline.hdel(keys.CALIBRATION_PROPOSALS, LAB_INSTANCE)  # pyright: ignore[reportUnusedCoroutine]  # queued
                _queue_event(pipeline, event)
                await pipeline.execute()
            except WatchError:
                return False
        return True

    async def say(
        self, run: CalibrationRun, *, proposal: CalibrationProposal | None = None, event: Event | None = None
    ) -> bool:
        """Writes how far a run has come, with its outcome; False when another run took its place, or it was decided."""
        live = keys.live(CALIBRATION_RUNS.name)

        def write(pipeline: Pipeline) -> None:
            data = encode(run)
            pipeline.hset(live, LAB_INSTANCE, data)  # pyright: ignore[reportUnusedCoroutine]  # queued
            pipeline.publish(keys.topic(CALIBRATION_RUNS.name, LAB_INSTANCE), data)
            if proposal is not None:
                pipeline.hset(keys.CALIBRATION_PROPOSALS, LAB_INSTANCE, encode(proposal))  # pyright: ignore[reportUnusedCoroutine]  # queued
            if event is not None:
                _queue_event(pipeline, event)

        return await self._if_still(live, run.id, write)

    async def _if_still(self, live: str, run_id: int, write: Callable[[Pipeline], None]) -> bool:
        async with self._redis.pipeline(transaction=True) as pipeline:
            try:
                await pipeline.watch(live)
                raw = cast("bytes | None", await pipeline.hget(live, LAB_INSTANCE))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
                known = _decoded(CalibrationRun, raw)
                if known is None or known.id != run_id or not known.is_open:
                    return False
                pipeline.multi()
                write(pipeline)
                await pipeline.execute()
            except WatchError:
                return False
        return True


def _queue_event(pipeline: Pipeline, event: Event) -> None:
    fields: dict[Any, Any] = {"i": LAB_INSTANCE, "m": encode(event)}
    pipeline.xadd(keys.stream(EVENTS.name), fields, maxlen=_STREAM_LENGTH, approximate=True)


def _decoded(kind: type[M], data: bytes | None) -> M | None:
    try:
        return None if data is None else decode(kind, data)
    except DecodeError:
        return None
