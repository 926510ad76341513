"""Output of children: all of it in a capped log, warnings and errors on the terminal, never a flood."""

from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from launcher.log_file import ECHO_LINES, ECHO_WINDOW_S, CappedLog, OutputReader
from protocol.clock import SimulatedClock


def reader(log: CappedLog, told: list[str], clock: SimulatedClock, *, echo: bool = True) -> OutputReader:
    return OutputReader(log, told.append, clock.monotonic_s, echo)


def test_a_full_log_is_renamed_and_both_stay_under_the_cap(tmp_path: Path) -> None:
    log = CappedLog(tmp_path / "logs" / "a.log", cap_bytes=100)
    for number in range(50):
        log.write(f"line {number:4}\n".encode())
    files = sorted((tmp_path / "logs").iterdir())
    assert [file.name for file in files] == ["a.log", "a.log.1"]
    assert all(file.stat().st_size <= 100 for file in files)
    kept = (files[1].read_text() + files[0].read_text()).splitlines()
    assert kept == [f"line {number:4}" for number in range(50 - len(kept), 50)]


def test_a_folder_that_vanished_loses_lines_and_nothing_else(tmp_path: Path) -> None:
    log = CappedLog(tmp_path / "logs" / "a.log")
    (tmp_path / "logs").rmdir()
    log.write(b"lost\n")


def test_warnings_and_errors_are_shown_other_lines_are_not(tmp_path: Path) -> None:
    told: list[str] = []
    lines = reader(CappedLog(tmp_path / "a.log"), told, SimulatedClock())
    lines.feed(b"INFO fine\nWARNING: cam0 is dark\n2025 ERROR x\nNO_ERRORS here\n")
    assert told == ["WARNING: cam0 is dark", "2025 ERROR x"]
    silent = reader(CappedLog(tmp_path / "b.log"), told, SimulatedClock(), echo=False)
    silent.feed(b"WARNING overcommit\n")
    assert len(told) == 2


async def test_a_flood_is_cut_and_counted(tmp_path: Path) -> None:
    told: list[str] = []
    clock = SimulatedClock()
    lines = reader(CappedLog(tmp_path / "a.log"), told, clock)
    lines.feed(b"WARNING again\n" * 100)
    assert told == ["WARNING again"] * ECHO_LINES
    await clock.advance(ECHO_WINDOW_S)
    lines.feed(b"WARNING later\n")
    assert told[ECHO_LINES:] == [f"(95 more lines in {tmp_path / 'a.log'})", "WARNING later"]


def test_a_line_without_end_is_not_gathered_for_ever(tmp_path: Path) -> None:
    lines = reader(CappedLog(tmp_path / "a.log"), [], SimulatedClock())
    for _ in range(100):
        lines.feed(b"x" * 10_000)
    lines.end()
    assert len(lines.last_line) <= 20_000


@given(pieces=st.lists(st.binary(max_size=30), max_size=20))
def test_pieces_of_any_kind_give_the_same_lines(pieces: list[bytes]) -> None:
    told_whole: list[str] = []
    told_pieces: list[str] = []
    whole = reader(CappedLog(Path("/dev/null")), told_whole, SimulatedClock())
    cut = reader(CappedLog(Path("/dev/null")), told_pieces, SimulatedClock())
    content = b"ERROR ".join(pieces)
    whole.feed(content)
    for position in range(0, len(content), 3):
        cut.feed(content[position : position + 3])
    whole.end()
    cut.end()
    assert told_pieces == told_whole
    assert cut.last_line == whole.last_line
