"""`./lilliput stop`: agents on this machine hold it, Redis has it, and the shell says so; with a dead server too."""

import asyncio
import json
import socket
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from agents.link import StopListener
from agents.link.stops import LOOPBACK_BROADCAST
from agents.safety import EmergencyStopLatch
from launcher.cli import main
from launcher.stop_broadcast import broadcast_addresses
from protocol.bus import Bus
from protocol.channels import EMERGENCY_STOP, LAB_INSTANCE
from protocol.clock import SystemClock
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

    def _status(self) -> Status:
        epoch = self.latch.epoch if self.latch.engaged else None
        return Status(
            robot=self.id, sequence=1, stamp_ns=CLOCK.now_ns(), linear_mps=0.2, angular_radps=0.0, stop_epoch=epoch
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


async def test_every_robot_holds_it_and_redis_has_it(
    lab: Path, robots: list[Robot], redis_url: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("REDIS_URL", redis_url)
    assert await stop(lab, "--reason", "smoke", "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert result["figures"] == {"robots_stopped": 2, "robots_silent": 0, "written": True}
    assert [robot.latch.engaged for robot in robots] == [True, True]
    bus = Bus.connect(redis_url, CLOCK)
    known = await bus.latest(EMERGENCY_STOP, LAB_INSTANCE)
    await bus.close()
    assert known is not None and (known.engaged, known.reason) == (True, "smoke")
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


async def test_without_the_systems_key_it_says_what_to_do(lab: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (lab.parent / "state" / "udp.key").unlink()
    assert await stop(lab) == 2
    assert "udp.key" in capsys.readouterr().err
    assert not (lab.parent / "state" / "udp.key").exists(), "a key made now would be nobody's"


def test_the_loopback_is_among_the_networks() -> None:
    assert broadcast_addresses()[0] == LOOPBACK_BROADCAST
