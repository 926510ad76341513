"""What an agent is started with, and the pace it keeps."""

import asyncio
import contextlib
import re
from pathlib import Path

import pytest

from agents.__main__ import main
from agents.drivers import DriverSite, SimDriver, make_driver
from agents.pacing import Pacer
from protocol.clock import SimulatedClock, SystemClock
from tests.agents.agent_world import KEY, LAB, ROBOT


@pytest.mark.parametrize(
    ("arguments", "environment", "message"),
    [
        (["wifibot-14"], {}, "LILLIPUT_LAB"),
        (["wifibot-99"], {"LILLIPUT_LAB": "labs/gulliver.yaml"}, "no vehicle 'wifibot-99'.*wifibot-14"),
        (["wifibot-14", "--lab", "nowhere.yaml"], {}, "nowhere.yaml"),
        (["wifibot-14", "--server", "8000"], {"LILLIPUT_LAB": "labs/gulliver.yaml"}, "http://HOST:PORT"),
        (["wifibot-14"], {"LILLIPUT_LAB": "labs/gulliver.yaml", "LILLIPUT_UDP_KEY": "xyz"}, "hexadecimal"),
    ],
)
def test_wrong_settings_are_told_in_a_sentence(arguments: list[str], environment: dict[str, str], message: str) -> None:
    with pytest.raises(SystemExit, match=message):
        main(arguments, environment)


def test_an_unknown_driver_is_told(tmp_path: Path) -> None:
    text = re.sub(
        r"    wifibot-1[45]: \[\[.*\n", "", Path("labs/gulliver.yaml").read_text()
    )  # tours are for simulated ones
    lab = tmp_path / "lab.yaml"
    lab.write_text(
        text.replace(
            "    driver: sim\n    tag: {family: tag36h11, id: 14",
            "    driver: tractor\n    tag: {family: tag36h11, id: 14",
        )
    )
    with pytest.raises(SystemExit, match="driver 'tractor'"):
        main(["wifibot-14", "--lab", str(lab)], {})


def test_the_driver_of_the_lab_file_talks_to_the_lab() -> None:
    assert isinstance(make_driver(DriverSite(LAB.vehicle(ROBOT), LAB, SystemClock(), KEY)), SimDriver)


async def test_the_pacer_keeps_its_rate_and_counts_overruns() -> None:
    clock = SimulatedClock()
    pacer = Pacer(clock, 20.0)
    rounds: list[float] = []

    async def loop() -> None:
        while True:
            rounds.append(clock.monotonic_s())
            if len(rounds) == 3:
                clock.wait(0.12)  # a round that takes too long
            await pacer.wait()

    task = asyncio.create_task(loop())
    await clock.advance(0.4)
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task
    assert pacer.overruns == 1
    assert rounds == pytest.approx([0.0, 0.05, 0.1, 0.25, 0.3, 0.35, 0.4])
