"""`./lilliput stop`: agents on this machine hold it, Redis has it, and the shell says so; with a dead server too."""

import asyncio
import json
import socket
from collections.abc import AsyncIterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import yaml

from agents.link import StopListener
from agents.link.stops import LOOPBACK_BROADCAST
from agents.safety import EmergencyStopLatch
from launcher.cli import main
from launcher.stop_broadcast import StopBroadcast, broadcast_addresses
from protocol.bus import Bus
from protocol.channels import EMERGENCY_STOP, LAB_INSTANCE
from protocol.clock import SystemClock
from protocol.lab import GPSS_DRIVER
from protocol.messages import EmergencyStop, Status

GULLIVER = Path(__file__).parents[2] / "labs" / "gulliver.yaml"
KEY = "ab" * 32
CLOCK = SystemClock()


class Robot:
    """An agent's part of it."""

    def __init__(self, robot: str) -> None:
        self.id, self.latch = robot, EmergencyStopLatch()
        self.latch.update(EmergencyStop(engaged=False))
        self.listener = StopListener(bytes.fromhex(KEY), CLOCK, self._on_stop, self._status)

    def _on_stop(self, stop: EmergencyStop) -> None:
        self.latch.update(stop)

    def _status(self, sequence: int) -> Status:
        epoch = self.latch.epoch if self.latch.engaged else None
        return Status(
            robot=self.id,
            sequence=sequence,
            stamp_ns=CLOCK.now_ns(),
            linear_mps=0.2,
            angular_radps=0.0,
            stop_epoch=epoch,
        )


@pytest.fixture
def port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def lab(tmp_path: Path, port: int) -> Path:
    """The shipped lab with two robots and a free port."""
    description: dict[str, Any] = yaml.safe_load(GULLIVER.read_text())
    description["vehicles"] = description["vehicles"][:2]
    description["simulation"].update(starts={}, tours={})
    description["ports"]["stop_udp"] = port
    file = tmp_path / "lab.yaml"
    file.write_text(yaml.safe_dump(description))
    (tmp_path / "state").mkdir()
    (tmp_path / "state" / "udp.key").write_text(KEY)
    return file


@pytest.fixture
async def robots(port: int) -> AsyncIterator[list[Robot]]:
    found = [Robot("wifibot-14"), Robot("wifibot-15")]
    for robot in found:
        await robot.listener.open(LOOPBACK_BROADCAST, port)
    yield found
    for robot in found:
        robot.listener.close()
    await asyncio.sleep(0)


async def stop(lab: Path, *more: str) -> int:
    arguments = ["stop", "--lab", str(lab), "--state", str(lab.parent / "state"), "--to", LOOPBACK_BROADCAST, *more]
    return await asyncio.to_thread(main, arguments)


def without_agents(lab: Path) -> None:
    description: dict[str, Any] = yaml.safe_load(lab.read_text())
    for vehicle in description["vehicles"]:
        vehicle["driver"] = GPSS_DRIVER
    lab.write_text(yaml.safe_dump(description))


async def latch(redis_url: str) -> EmergencyStop:
    bus = Bus.connect(redis_url, CLOCK)
    known = await bus.latest(EMERGENCY_STOP, LAB_INSTANCE)
    await bus.close()
    assert known is not None
    return known


async def test_every_robot_holds_it_and_redis_has_it(
    lab: Path, robots: list[Robot], redis_url: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("REDIS_URL", redis_url)
    assert await stop(lab, "--reason", "smoke", "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert result["figures"] == {"robots_stopped": 2, "robots_silent": 0, "written": True}
    assert [robot.latch.engaged for robot in robots] == [True, True]
    known = await latch(redis_url)
    assert (known.engaged, known.reason) == (True, "smoke")
    assert known.epoch == robots[0].latch.epoch, "one release is for all"


async def test_it_works_with_everything_dead_and_says_who_is_silent(
    lab: Path, robots: list[Robot], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("REDIS_URL", raising=False)
    robots[1].listener.close()
    await asyncio.sleep(0)
    assert await stop(lab) == 1
    told = capsys.readouterr()
    assert "wifibot-14: holds the stop, braking at 0.20 m/s" in told.out
    assert "wifibot-15: NO ANSWER" in told.out
    assert "until a person releases it in the console" in told.err
    assert robots[0].latch.engaged and not robots[1].latch.engaged


async def test_without_the_systems_key_it_says_what_to_do(
    lab: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("REDIS_URL", raising=False)
    (lab.parent / "state" / "udp.key").unlink()
    assert await stop(lab) == 2
    told = capsys.readouterr().err
    assert "nobody is stopped" in told and "udp.key" in told and "no Redis runs here" in told
    assert not (lab.parent / "state" / "udp.key").exists(), "a key made now would be nobody's"


async def test_without_the_systems_key_the_server_still_hears_of_it(
    lab: Path, redis_url: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("REDIS_URL", redis_url)
    (lab.parent / "state" / "udp.key").unlink()
    assert await stop(lab) == 1, "no robot vouches for it"
    told = capsys.readouterr()
    assert "no robot is told directly" in told.err
    assert "wifibot-14: NO ANSWER" in told.out and "orders it to stand" in told.out
    assert (await latch(redis_url)).engaged


async def test_the_latch_does_not_wait_for_robots_that_are_silent(
    lab: Path, redis_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Here patience ends only when Redis has it."""
    in_redis: list[bool] = []

    async def patient(*_: object) -> None:
        bus = Bus.connect(redis_url, CLOCK)
        with suppress(TimeoutError):
            async with asyncio.timeout(2.0):
                while (known := await bus.latest(EMERGENCY_STOP, LAB_INSTANCE)) is None or not known.engaged:  # noqa: ASYNC110  # Redis'
                    await asyncio.sleep(0.01)
                in_redis.append(True)
        await bus.close()

    monkeypatch.setattr(StopBroadcast, "send", patient)
    monkeypatch.setenv("REDIS_URL", redis_url)
    assert await stop(lab) == 1
    assert in_redis == [True]


async def test_robots_without_an_agent_are_stopped_by_redis_or_not_at_all(
    lab: Path, redis_url: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    without_agents(lab)
    monkeypatch.setattr("launcher.stop_broadcast.PATIENCE_S", 0.1)
    monkeypatch.setenv("REDIS_URL", redis_url)
    assert await stop(lab) == 0
    assert (await latch(redis_url)).engaged
    capsys.readouterr()
    monkeypatch.setenv("REDIS_URL", "redis://127.0.0.1:1")
    assert await stop(lab) == 1
    assert "wifibot-14: NOT TOLD" in capsys.readouterr().out


async def test_who_is_silent_may_drive_on_when_redis_has_no_stop_either(
    lab: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("launcher.stop_broadcast.PATIENCE_S", 0.1)
    monkeypatch.setenv("REDIS_URL", "redis://127.0.0.1:1")
    assert await stop(lab) == 1
    told = capsys.readouterr()
    assert "wifibot-14: NO ANSWER" in told.out and "may DRIVE ON" in told.out
    assert "0.5 s after the last command" not in told.out


async def test_an_address_that_nothing_can_be_sent_to_is_told_and_keeps_nobody_else_from_hearing_it(
    lab: Path, robots: list[Robot], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("REDIS_URL", raising=False)
    assert await stop(lab, "--to", "0.0.0.256") == 0
    assert [robot.latch.engaged for robot in robots] == [True, True]
    assert "nothing could be sent to 0.0.0.256" in capsys.readouterr().err


async def test_without_a_socket_the_latch_is_written_all_the_same(
    lab: Path, redis_url: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    async def closed(*_: object) -> None:
        raise OSError(24, "Too many open files")

    monkeypatch.setattr(StopBroadcast, "_open", closed)
    monkeypatch.setenv("REDIS_URL", redis_url)
    assert await stop(lab) == 1
    assert f"nothing could be sent to {LOOPBACK_BROADCAST}: Too many open files" in capsys.readouterr().err
    assert (await latch(redis_url)).engaged


async def test_a_reason_in_bytes_that_are_no_text_stops_robots_too(
    lab: Path, robots: list[Robot], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("REDIS_URL", raising=False)
    assert await stop(lab, "--reason", "fum\udce9e\n" + "\x01" * 300) == 0
    assert robots[0].latch.engaged


def test_the_loopback_is_among_the_networks() -> None:
    assert broadcast_addresses()[0] == LOOPBACK_BROADCAST
