"""The tracker process's shell: events of lost and found vehicles, stage timings, packets over real sockets."""

import asyncio
import socket
import struct
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest

from localization.outputs import UdpSender, outputs_of
from localization.timings import SegmentWriter, TimingLog, camera_stages
from localization.track_reports import QUIET_S, TrackReports, sentence
from localization.tracker import TrackerService
from localization.tracking import TrackTransition
from protocol.bus import Bus
from protocol.channels import DETECTIONS, EVENTS, POSES
from protocol.clock import SimulatedClock
from protocol.lab import GulliViewOutput, Outputs
from protocol.messages import Detection, Event, FrameDetections
from protocol.timings import Header, read_run
from tests.localization.synthetic import small_lab
from tests.redis_fixture import RedisServer


def transition(tracked: bool, vehicle: str = "robot-10") -> TrackTransition:
    return TrackTransition(vehicle, 5, tracked, (1.0, 0.5))


def test_a_vehicle_that_comes_and_goes_is_told_of_now_and_then() -> None:
    reports = TrackReports()
    told: list[bool] = []
    for tenth in range(300):  # half a minute, a change each tenth of a second
        reports.note(transition(tenth % 2 == 0))
        told += [each.tracked for each in reports.take_due(tenth / 10)]
    told += [each.tracked for each in reports.take_due(100.0)]
    assert told[0]
    assert len(told) <= 30 / QUIET_S + 1
    assert all(a != b for a, b in pairwise(told)), "each event is a change"
    assert told[-1] is False, "the last state is told in the end"


def test_a_vehicle_that_was_never_seen_is_not_told_as_lost() -> None:
    reports = TrackReports()
    reports.note(transition(False))
    assert reports.take_due(0.0) == []


def test_one_vehicle_does_not_silence_another() -> None:
    reports = TrackReports()
    for vehicle in ("robot-10", "robot-11"):
        reports.note(transition(True, vehicle))
    assert [each.vehicle for each in reports.take_due(0.0)] == ["robot-10", "robot-11"]
    reports.note(transition(False))
    assert reports.take_due(QUIET_S - 0.1) == []
    (lost,) = reports.take_due(QUIET_S)
    assert sentence(lost) == "robot-10 is lost, last seen at (1.00, 0.50) m"


def test_stages_that_did_not_happen_are_left_out() -> None:
    frame = FrameDetections("left", 10**9, 10**9 + 5_000_000, 1, False, (), {"wait": 1.0, "window": 2.0, "full": 0.0})
    assert camera_stages(frame, 0.0, 0.25) == {"wait": 1.0, "window": 2.0, "send": 0.25, "total": 5.0}
    assert camera_stages(frame, 3.0, 0.25)["decode"] == 3.0


class Room:
    """The service on a real Redis and a clock that the test moves."""

    def __init__(self, redis_url: str, folder: Path, port: int, sender: UdpSender, clock: SimulatedClock) -> None:
        outputs = Outputs(gulliview=(GulliViewOutput(layout="gulliview-2025", host="127.0.0.1", port=port),))
        self.lab = small_lab().model_copy(update={"outputs": outputs})
        self.clock, self.bus = clock, Bus.connect(redis_url)
        self.folder = folder
        header = Header("r", 1, 1, "tracker", "tracker", "small", "m", "0", ("track",))
        self.timings = TimingLog(SegmentWriter(folder, header, 10**6, clock.now_ns))
        self.outputs = outputs_of(self.lab, self.bus, sender, clock, None)
        self.service = TrackerService(self.lab, self.bus, self.outputs, self.timings, clock)

    async def show(self, age_s: float = 0.0) -> None:
        """A camera sees robot-10's tag."""
        variance = (1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6)
        corners = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
        detection = Detection("tag36h11", 10, corners, 60.0, 1.0, 0.5, 0.3, variance)
        stamp_ns = self.clock.now_ns() - round(age_s * 1e9)
        frame = FrameDetections("left", stamp_ns, stamp_ns, 1, False, (detection,), {})
        await self.bus.publish(DETECTIONS, "left", frame)

    async def events(self) -> list[Event]:
        return [received.message for received in await self.bus.history(EVENTS)]


async def test_from_detections_to_packets_events_and_timings(redis_server: RedisServer, tmp_path: Path) -> None:
    clock = SimulatedClock()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear, UdpSender(clock) as sender:
        ear.bind(("127.0.0.1", 0))
        ear.setblocking(False)
        room = Room(redis_server.url, tmp_path / "r", ear.getsockname()[1], sender, clock)
        await room.show(age_s=0.010)
        tasks = [asyncio.ensure_future(work()) for work in (room.service.run, room.service.look_for_lost)]
        data = await asyncio.wait_for(asyncio.get_running_loop().sock_recv(ear, 2048), 10)
        assert struct.unpack_from(">IIIQQII", data)[6] == 1
        tag_id, _, x, y, *_ = struct.unpack_from(">IQIIIffI", data, 36)
        assert (tag_id, x, y) == (10, 500, 1000)

        await clock.advance(0.3)
        await _eventually(room, ["vehicle_found"])
        await clock.advance(6.0)
        await _eventually(room, ["vehicle_found", "vehicle_lost"])
        found, lost = await room.events()
        assert (found.level.value, lost.level.value) == ("info", "warning")
        assert lost.text.startswith("robot-10 is lost, last seen at (")
        assert set(await room.bus.latest_all(POSES)) == {"robot-10"}

        room.timings.write()
        run = read_run(tmp_path / "r")
        (wait,) = run.values("tracker", "wait")[1]
        assert wait == pytest.approx(10.0, abs=0.01)
        assert set(run.stages("tracker")) == {"wait", "track", "send", "publish", "total"}
        assert run.values("tracker", "total")[1][0] == pytest.approx(10.0, abs=0.01)

        for task in tasks:
            while not task.done():
                task.cancel()
                await asyncio.wait({task}, timeout=0.1)
        await room.bus.close()


async def _eventually(room: Room, kinds: list[str]) -> None:
    for _ in range(2000):
        if [event.kind for event in await room.events()] == kinds:
            return
        await asyncio.sleep(0.002)
    raise AssertionError(f"events {msgspec.json.encode([e.kind for e in await room.events()])!r}, not {kinds}")
