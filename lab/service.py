"""The process of the simulated lab: steps the world along the clock, feeds the cameras' rings, answers the bases, keeps
Redis told. Everything that blocks or computes for long runs in two worker threads (drawing releases the interpreter)."""

import asyncio
import contextlib
import logging
import os
import secrets
import sys
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

from lab.base_link import BaseLink
from lab.camera_feed import CameraFeed
from lab.rendering import CameraRenderer
from lab.shared_state import SharedState
from lab.world import World
from protocol.bus import Bus
from protocol.clock import Clock
from protocol.lab import Lab
from protocol.messages import CameraFault
from protocol.settings import Settings, frame_ring

_WORKERS = 2
_MOST_BEHIND_NS = 1_000_000_000
"""A world further behind than this (a suspended computer) leaves the time out instead of catching up."""
_MOST_AHEAD_NS = 100_000_000
"""A clock that was set back by more than this takes the world's time along."""
_REPORT_PERIOD_S = 10.0
_RENDERING_NICENESS = 3
"""Where processors are short, bases answer first: a frame that comes late is left out, a base that does cannot stop in time."""
_logger = logging.getLogger(__name__)


class PortTakenError(Exception):
    """The lab's UDP port cannot be had; the text says which and why."""


class LabService:
    """`run` works until cancelled. PortTakenError when the UDP port cannot be had."""

    def __init__(self, lab: Lab, settings: Settings, clock: Clock) -> None:
        self._lab = lab
        self._settings = settings
        self._clock = clock
        self.world = World(lab, start_ns=clock.now_ns(), session=secrets.token_hex(4))
        self.base_link = BaseLink(self.world, clock, settings.udp_key)
        self.feeds: list[CameraFeed] = []
        self._faults: Mapping[str, CameraFault] = {}

    async def run(self) -> None:
        host, port = self._settings.host, self._lab.ports.lab_udp
        try:
            transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(
                lambda: self.base_link, local_addr=(host, port)
            )
        except OSError as error:
            raise PortTakenError(f"cannot listen on UDP {host}:{port}: {error}; is another lab running?") from error
        executor = ThreadPoolExecutor(_WORKERS, thread_name_prefix="render", initializer=_step_back)
        bus = Bus.connect(self._settings.redis_url, self._clock)
        state = SharedState(self.world, bus, self._clock)
        try:
            await state.restore_vehicles()
            self.world.skip_to(self._clock.now_ns())
            async with asyncio.TaskGroup() as group:
                group.create_task(self._step_world())
                group.create_task(self._open_cameras(executor))
                group.create_task(state.publish_truth())
                group.create_task(state.mirror_objects())
                group.create_task(state.mirror_faults(self._suffer))
                group.create_task(state.save_vehicles())
                group.create_task(self._report())
        finally:
            transport.close()
            executor.shutdown(wait=True, cancel_futures=True)
            for feed in self.feeds:
                feed.close()
            with contextlib.suppress(OSError):  # somebody else's frames may lie there too
                frame_ring(self._settings.state, "").parent.rmdir()
            await bus.close()

    async def _step_world(self) -> None:
        world, step_ns = self.world, round(self.world.step_s * 1e9)
        while True:
            now_ns = self._clock.now_ns()
            behind_ns = now_ns - world.stamp_ns
            if behind_ns > _MOST_BEHIND_NS or behind_ns < -_MOST_AHEAD_NS:
                _logger.warning("the world's time was %.1f s off, set to the clock", -behind_ns / 1e9)
                world.skip_to(now_ns)
            while world.stamp_ns + step_ns <= now_ns:
                world.step()
                self.base_link.tick()
                for feed in self.feeds:
                    feed.tick(world)
            await self._clock.sleep((world.stamp_ns + step_ns - self._clock.now_ns()) / 1e9)

    async def _open_cameras(self, executor: ThreadPoolExecutor) -> None:
        """Draws the empty floors in the workers while the world goes on already."""
        cameras = [camera for camera in self._lab.cameras if camera.source == "sim"]
        for camera in cameras:  # a killed lab leaves its last frames behind
            frame_ring(self._settings.state, camera.id).unlink(missing_ok=True)
        loop = asyncio.get_running_loop()
        for index, camera in enumerate(cameras):
            renderer = await loop.run_in_executor(executor, CameraRenderer, self._lab, camera.id)
            ring = frame_ring(self._settings.state, camera.id)
            feed = CameraFeed(self._lab, renderer, ring, index / len(cameras), executor)
            feed.fault = self._faults.get(camera.id)
            self.feeds.append(feed)
            _logger.info("camera %s runs, %g frames per second into %s", camera.id, camera.rate_hz, ring)

    def _suffer(self, faults: Mapping[str, CameraFault]) -> None:
        self._faults = faults
        for feed in self.feeds:
            feed.fault = faults.get(feed.camera_id)

    async def _report(self) -> None:
        while True:
            await self._clock.sleep(_REPORT_PERIOD_S)
            self.base_link.report()


def _step_back() -> None:
    """Makes the calling thread nicer than the process. Linux alone schedules threads by themselves."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _RENDERING_NICENESS)
