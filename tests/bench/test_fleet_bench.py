"""The fleet benchmark's own arithmetic, its robots' words against the agents', and one run that is as small as can be."""

import json
from array import array
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from launcher.cli import main
from protocol.codec import encode
from protocol.datagram import Datagram, pack, unpack
from protocol.messages import Command, Movement, Reason, ReasonCode, Status
from tests.bench.fleet import Run, figures, measure
from tests.bench.fleet_lab import place, write_fleet_lab
from tests.bench.fleet_observer import Ages
from tests.bench.fleet_robot import CommandReader, Order, Reporter
from tests.bench.fleet_robots import Played

KEY = bytes(range(32))
STOP = b'event: emergency_stop\ndata: {"engaged":false}\n\n'


def told(sequence: int) -> bytes:
    """A command as the server sends it."""
    order = Command(
        robot="robot-0000",
        epoch=7,
        sequence=sequence,
        stamp_ns=1000 + sequence,
        deadline_ns=2000 + sequence,
        movement=Movement.NO_ACTION,
        reason=Reason(code=ReasonCode.IDLE),
    )
    return b"event: command\ndata: " + encode(order) + b"\n\n"


@given(st.lists(st.integers(1, 400), max_size=40))
@example([399])
def test_commands_are_read_however_the_stream_is_cut(cuts: list[int]) -> None:
    pieces = [STOP, told(1), b": keep-alive\n\n", told(2), told(3), STOP, told(4)]
    stream = b"HTTP/1.1 200 OK\r\n\r\n" + b"".join(b"%x\r\n%s\r\n" % (len(piece), piece) for piece in pieces)
    reader, found = CommandReader(), list[Order]()
    for cut in cuts:
        found += reader.take(stream[:cut])
        stream = stream[cut:]
    found += reader.take(stream)
    assert [order.sequence for order in found] == [1, 2, 3, 4]
    assert found[0] == Order(7, 1, 1001, 2001)
    assert reader.told


def test_statuses_are_those_that_an_agent_sends() -> None:
    reporter = Reporter("robot-0003", 1.5, 2.25, KEY, 41)
    first = unpack(reporter.datagram(5_000_000_000), KEY)
    assert isinstance(first.message, Status)
    assert (first.sender, first.sequence, first.message.command_order) == ("robot-0003", 41, None)
    reporter.order, reporter.heard_ns = Order(7, 9, 1, 2), 5_900_000_000
    data = reporter.datagram(6_000_000_000)
    second = unpack(data, KEY)
    assert isinstance(second.message, Status)
    assert (second.message.command_order, second.message.command_age_s, second.message.x) == ((7, 9), 0.1, 1.5)
    agents = pack(Datagram("robot-0003", 42, 6_000_000_000, second.message), KEY)
    assert unpack(agents, KEY) == second
    assert abs(len(agents) - len(data)) < 20
    assert list(json.loads(second.payload)) == list(Status.model_fields)


def test_each_status_counts_once_and_old_ones_not_at_all() -> None:
    ages = Ages()
    for number, stamp_ns in ((1, 10), (2, 20), (2, 20), (1, 10)):
        ages.add("a", number, stamp_ns * 1_000_000, 50_000_000)
    assert (list(ages.ms), ages.seen) == ([40.0, 30.0], 2)


def test_figures() -> None:
    played = Played(1000, 500, 3, 4, array("d", [5.0] * 99 + [105.0]), 1, 10.0, 2.0)
    cpu_s, rss_mb = {"redis": 1.0, "server": 3.0}, {"redis": 10.0, "server": 90.0}
    found = figures(Run(50, played, array("d", [10.0, 20.0, 30.0]), array("d"), cpu_s, rss_mb, 998, 990))
    assert (found["robots_50_lost"], found["robots_50_superseded"], found["robots_50_starved"]) == (2, 8, 1)
    assert found["robots_50_refused"] == 4
    assert (found["robots_50_status_median_ms"], found["robots_50_command_median_ms"]) == (20.0, 5.0)
    assert found["robots_50_command_p99_ms"] == pytest.approx(6.0)
    assert (found["robots_50_cpu_percent"], found["robots_50_cpu_percent_per_robot"]) == (40.0, 0.8)
    assert (found["robots_50_rss_mb"], found["robots_50_statuses_hz"]) == (100.0, 50.0)
    assert "robots_50_console_median_ms" not in found


def test_a_lab_for_any_number_of_robots(tmp_path: Path) -> None:
    _, lab = write_fleet_lab(tmp_path, 7)
    places = [place(number, 7) for number in range(7)]
    assert len(lab.vehicles) == len(set(places)) == 7
    assert all(lab.area_at(x, y) is not None for x, y in places)
    with pytest.raises(ValueError, match="at least one"):
        write_fleet_lab(tmp_path, 0)


def test_three_robots_are_heard_and_commanded() -> None:
    found = figures(measure(3, 1.0, console=True, warm_up_s=0.5))
    assert found["robots_3_lost"] == 0
    assert found["robots_3_statuses_hz"] == pytest.approx(30.0, rel=0.3)
    assert found["robots_3_commands_hz"] > 10.0
    assert 0.0 < found["robots_3_status_median_ms"] < 1000.0
    assert 0.0 < found["robots_3_command_median_ms"] < 1000.0
    assert 0.0 < found["robots_3_console_median_ms"] < 1000.0
    assert found["robots_3_rss_mb"] > 50.0


@pytest.mark.parametrize("arguments", [["--robots", "0"], ["--seconds", "0"], ["--seconds", "nan"]])
def test_bad_use_is_one_line(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "fleet", *arguments]) == 2
    assert arguments[0] in capsys.readouterr().err
