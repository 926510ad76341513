"""The calibrator over a real Redis: first start, a person's request, a bumped camera, cameras that do not answer."""

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import Any, cast

import msgspec
import pytest

from geometry import SE3
from localization.calibrator import Calibrator
from protocol import keys
from protocol.bus import Bus
from protocol.channels import CALIBRATION_RUNS, CAMERA_STATES, EVENTS, LAB_INSTANCE, SIGHTINGS
from protocol.clock import SystemClock
from protocol.codec import decode, encode
from protocol.messages import (
    Calibration,
    CalibrationProposal,
    CalibrationRun,
    CameraState,
    RunState,
)
from protocol.messages.calibration import CURRENT, PREVIOUS
from tests.localization.sightings import LAB, message, sighting
from tests.localization.synthetic import MOUNTS

LONG_AGO_NS = 60_000_000_000
BUMP = SE3.from_rotvec([0, 0, 0], [0.02, 0.0, 0.0])


class Room:
    """A calibrator at work, and what can be seen of it."""

    def __init__(self, bus: Bus) -> None:
        self.bus, self.clock = bus, SystemClock()

    async def see(self, camera: str, *, mount: SE3 | None = None, ago_ns: int = LONG_AGO_NS, request: int = 0) -> None:
        """The camera has calibrated itself, and tells what it saw."""
        stamp_ns = self.clock.now_ns() - ago_ns
        seen = sighting(camera, stamp_ns, mount=mount)
        await self.bus.publish(SIGHTINGS, camera, message(seen, stamp_ns, request))

    async def use(self, calibration: Calibration) -> None:
        """The cameras have taken it."""
        for name, camera in calibration.cameras.items():
            used = camera.extrinsics(name, calibration.stamp_ns)
            await self.bus.redis.hset(keys.EXTRINSICS, name, encode(used))  # pyright: ignore[reportArgumentType]

    async def ask(self, *cameras: str, run_id: int = 7, age_ns: int = 0) -> CalibrationRun:
        now_ns = self.clock.now_ns() - age_ns
        run = CalibrationRun(
            id=run_id, state=RunState.COLLECTING, stamp_ns=now_ns, started_ns=now_ns, by="olga", cameras=cameras
        )
        await self.bus.publish(CALIBRATION_RUNS, LAB_INSTANCE, run)
        return run

    async def calibration(self, field: str = CURRENT) -> Calibration | None:
        raw = await self._hget(keys.CALIBRATIONS, field)
        return None if raw is None else decode(Calibration, raw)

    async def proposal(self) -> CalibrationProposal | None:
        raw = await self._hget(keys.CALIBRATION_PROPOSALS, LAB_INSTANCE)
        return None if raw is None else decode(CalibrationProposal, raw)

    async def run(self) -> CalibrationRun | None:
        return await self.bus.latest(CALIBRATION_RUNS, LAB_INSTANCE)

    async def said(self) -> list[str]:
        return [received.message.kind for received in await self.bus.history(EVENTS)]

    async def _hget(self, key: str, field: str) -> bytes | None:
        return await cast("Awaitable[bytes | None]", self.bus.redis.hget(key, field))


async def eventually(probe: Callable[[], Awaitable[Any]], within_s: float = 20.0) -> Any:
    deadline = asyncio.get_running_loop().time() + within_s
    while not (value := await probe()):
        assert asyncio.get_running_loop().time() < deadline, "waited in vain"
        await asyncio.sleep(0.02)
    return value


@asynccontextmanager
async def at_work(redis_url: str) -> AsyncGenerator[Room]:
    bus, own = Bus.connect(redis_url), Bus.connect(redis_url)
    task = asyncio.create_task(Calibrator(LAB, own, SystemClock()).run())
    try:
        yield Room(bus)
        assert not task.done(), task.exception()
    finally:
        while not task.done():  # redis-py may lose a cancellation
            task.cancel()
            await asyncio.wait({task}, timeout=0.1)
        await own.close()
        await bus.close()


def off_m(calibration: Calibration, camera: str, mount: SE3) -> float:
    return float(abs(mount.translation - calibration.cameras[camera].translation).max())


@pytest.fixture
async def room(redis_url: str) -> AsyncIterator[Room]:
    async with at_work(redis_url) as made:
        yield made


async def refined(room: Room) -> Calibration:
    """The room after its first start."""
    await room.see("left")
    await room.see("right")
    calibration = cast("Calibration", await eventually(room.calibration))
    await room.use(calibration)
    return calibration


async def test_the_first_start_calibrates_all_cameras_without_being_asked(room: Room) -> None:
    await room.see("left", ago_ns=0)
    await asyncio.sleep(0.6)
    assert await room.calibration() is None, "the other camera may still follow"
    await room.see("right")
    found = cast("Calibration", await eventually(room.calibration))
    assert set(found.cameras) == {"left", "right"}
    assert off_m(found, "left", MOUNTS["left"]) < 0.004
    assert off_m(found, "right", MOUNTS["right"]) < 0.004
    assert set(found.floor_tags) == set(LAB.floor_tags.poses)
    assert found.by == "calibrator"
    assert "calibration_refined" in await room.said()
    await asyncio.sleep(0.6)
    assert await room.calibration() == found, "nothing new, nothing to do"


async def test_what_a_person_asks_for_is_proposed_and_not_yet_in_force(room: Room) -> None:
    before = await refined(room)
    run = await room.ask("left", "right")
    await room.see("left", ago_ns=0, request=run.id)

    async def half() -> bool:
        now = await room.run()
        return now is not None and now.answered == ("left",)

    await eventually(half)
    await room.see("right", mount=BUMP @ MOUNTS["right"], ago_ns=0, request=run.id)
    proposal = cast("CalibrationProposal", await eventually(room.proposal))
    assert await room.calibration() == before
    assert proposal.not_answered == ()
    steady, moved = proposal.cameras["left"], proposal.cameras["right"]
    assert steady.is_new
    assert steady.reprojection_before_px is not None
    assert moved.reprojection_before_px is not None
    assert moved.reprojection_before_px > 10 * moved.reprojection_after_px
    assert moved.reprojection_after_px < 0.3
    assert moved.camera_moved_m == pytest.approx(0.02, abs=0.004)
    assert moved.floor_shift_mean_m == pytest.approx(0.02, abs=0.004)
    assert steady.floor_shift_max_m is not None
    assert steady.floor_shift_max_m < 0.004
    assert proposal.floor_tags[2].cameras == ("left", "right")
    state = await room.run()
    assert state is not None
    assert (state.state, state.id, state.by) == (RunState.PROPOSED, run.id, "olga")


async def test_a_camera_that_does_not_answer_is_named_and_keeps_its_last_sighting(room: Room) -> None:
    await refined(room)
    state = CameraState("right", 1, False, "no frames for 12 s", 960, 540, 0, 0, 0, 0, 0, (), None, {})
    await room.bus.publish(CAMERA_STATES, "right", state)
    await room.see("left", ago_ns=0, request=7)
    await room.ask("left", "right", age_ns=LONG_AGO_NS)
    proposal = cast("CalibrationProposal", await eventually(room.proposal))
    assert proposal.not_answered == ("right",)
    assert proposal.cameras["left"].is_new
    assert not proposal.cameras["right"].is_new
    run = await room.run()
    assert run is not None
    assert run.text == "right did not answer (no frames for 12 s)"


async def test_a_run_without_any_answer_fails_and_says_why(room: Room) -> None:
    await room.ask("left", age_ns=LONG_AGO_NS)

    async def failed() -> CalibrationRun | None:
        run = await room.run()
        return run if run is not None and run.state is RunState.FAILED else None

    run = cast("CalibrationRun", await eventually(failed))
    assert run.text == "left did not answer (its process has never reported)"
    assert await room.proposal() is None
    assert "calibration_failed" in await room.said()


async def test_a_camera_that_was_bumped_is_refined_again_and_outdates_a_proposal(room: Room) -> None:
    before = await refined(room)
    run = await room.ask("left")
    await room.see("left", ago_ns=0, request=run.id)
    await eventually(room.proposal)
    await room.see("right", mount=BUMP @ MOUNTS["right"], ago_ns=0)

    async def again() -> Calibration | None:
        now = await room.calibration()
        return now if now != before else None

    now = cast("Calibration", await eventually(again))
    assert off_m(now, "right", BUMP @ MOUNTS["right"]) < 0.004
    assert off_m(now, "left", MOUNTS["left"]) < 0.004
    assert await room.calibration(PREVIOUS) == before
    assert await room.proposal() is None

    async def discarded() -> bool:
        run = await room.run()
        return run is not None and run.state is RunState.DISCARDED

    await eventually(discarded)


async def test_a_calibrator_that_was_killed_goes_on_with_the_run(redis_url: str) -> None:
    async with at_work(redis_url) as room:
        await refined(room)
        run = await room.ask("left", "right")
        await room.see("left", ago_ns=0, request=run.id)
    async with at_work(redis_url) as room:
        await room.see("right", ago_ns=0, request=run.id)
        proposal = cast("CalibrationProposal", await eventually(room.proposal))
        assert proposal.calibration.id == run.id


async def test_extrinsics_that_give_no_joint_result_stay_the_cameras_own(room: Room) -> None:
    await room.see("left")
    stamp_ns = room.clock.now_ns() - LONG_AGO_NS
    blind = msgspec.structs.replace(message(sighting("right", stamp_ns), stamp_ns), corners={})
    await room.bus.publish(SIGHTINGS, "right", blind)

    async def told() -> bool:
        return "calibration_not_refined" in await room.said()

    await eventually(told)
    await asyncio.sleep(0.6)
    assert (await room.said()).count("calibration_not_refined") == 1, "tried once, not all the time"
    assert await room.calibration() is None
