"""The supervisor with real processes: restarts, backoff on an injected clock, an end within 5 s, no orphans."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.backoff import Backoff
from launcher.child import ChildSpec, describe_exit
from launcher.paths import ROOT
from launcher.supervisor import Supervisor
from protocol.clock import SimulatedClock, SystemClock
from protocol.messages import ProcessState

IGNORES_TERM = (
    "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print('up', flush=True); time.sleep(600)"
)


class Recorder:
    """Everything that a supervisor said."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.states: list[ProcessState] = []

    def tell(self, name: str, line: str) -> None:
        self.lines.append(f"{name}: {line}")

    def pids(self) -> list[int]:
        return [state.pid for state in self.states if state.state == "running" and state.pid is not None]


def python(name: str, code: str, *, ends_last: bool = False, restart: bool = True) -> ChildSpec:
    return ChildSpec(
        name=name,
        argv=(sys.executable, "-I", "-c", code),
        environment=dict(os.environ),
        folder=ROOT,
        restart="always" if restart else "never",
        ends_last=ends_last,
    )


async def until(condition: Callable[[], bool], limit_s: float = 10.0) -> None:
    deadline = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        await asyncio.sleep(0.005)


def alive(pid: int) -> bool:
    """Whether the process runs; a zombie does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def contains(path: Path, text: str) -> bool:
    return path.exists() and text in path.read_text()


@pytest.fixture
def recorder() -> Recorder:
    return Recorder()


def supervisor(tmp_path: Path, recorder: Recorder, clock: SystemClock | SimulatedClock | None = None) -> Supervisor:
    return Supervisor(tmp_path, clock or SystemClock(), recorder.tell, recorder.states.append)


async def test_a_child_that_dies_is_started_again_and_said_to_be(tmp_path: Path, recorder: Recorder) -> None:
    async with supervisor(tmp_path, recorder) as running:
        child = running.start(python("sleeper", "import time; time.sleep(600)"))
        await until(lambda: len(recorder.pids()) == 1)
        os.kill(recorder.pids()[0], signal.SIGKILL)
        await until(lambda: len(recorder.pids()) == 2)
        assert child.state.restarts == 1
        assert child.state.last_error == "killed by signal 9 (SIGKILL)"
    first, second = recorder.pids()
    assert not alive(first)
    assert not alive(second)
    assert [s.state for s in recorder.states] == ["starting", "running", "restarting", "running", "stopped"]


async def test_a_crash_is_told_with_the_exception_and_kept_in_the_log(tmp_path: Path, recorder: Recorder) -> None:
    async with supervisor(tmp_path, recorder) as running:
        running.start(python("broken", "raise ValueError('no such camera')"))
        await until(lambda: bool(recorder.lines))
    assert "ended with status 1 (ValueError: no such camera); starting it again in 0.2 s" in recorder.lines[0]
    assert "Traceback" in (tmp_path / "broken.log").read_text()


async def test_restarts_wait_longer_each_time_until_a_healthy_run(tmp_path: Path, recorder: Recorder) -> None:
    clock = SimulatedClock()

    def restarting(count: int) -> Callable[[], bool]:
        return lambda: len([s for s in recorder.states if s.state == "restarting"]) == count

    async with supervisor(tmp_path, recorder, clock) as running:
        running.start(python("broken", "raise SystemExit(3)"))
        for count, delay_s in enumerate((0.2, 0.4, 0.8, 1.6, 3.2, 5.0, 5.0), start=1):
            await until(restarting(count))
            started = len(recorder.pids())
            await clock.advance(delay_s - 0.01)
            assert len(recorder.pids()) == started, f"restart {count} came before {delay_s} s"
            await clock.advance(0.02)
            await until(lambda started=started: len(recorder.pids()) == started + 1)


def test_a_healthy_run_makes_the_next_restart_quick_again() -> None:
    backoff = Backoff()
    assert [backoff.delay_s(uptime_s=1.0) for _ in range(3)] == [0.2, 0.4, 0.8]
    assert backoff.delay_s(uptime_s=9.9) == 1.6
    assert backoff.delay_s(uptime_s=10.0) == 0.2
    assert backoff.delay_s(uptime_s=0.0) == 0.4


async def test_a_process_that_runs_once_is_not_restarted(tmp_path: Path, recorder: Recorder) -> None:
    async with supervisor(tmp_path, recorder) as running:
        running.start(python("once", "print('done')", restart=False))
        await until(lambda: recorder.states[-1].state == "stopped")
    assert len(recorder.pids()) == 1


async def test_a_program_that_does_not_exist_is_told(tmp_path: Path, recorder: Recorder) -> None:
    async with supervisor(tmp_path, recorder) as running:
        running.start(ChildSpec("ghost", ("/no/such/program",), dict(os.environ), ROOT))
        await until(lambda: bool(recorder.lines))
    assert "cannot start /no/such/program: No such file or directory" in recorder.lines[0]


async def test_everything_ends_within_5_s_also_what_ignores_sigterm(tmp_path: Path, recorder: Recorder) -> None:
    async with supervisor(tmp_path, recorder) as running:
        running.start(python("stubborn", IGNORES_TERM))
        running.start(python("stubborn-last", IGNORES_TERM, ends_last=True))
        for name in ("stubborn", "stubborn-last"):
            await until(lambda name=name: contains(tmp_path / f"{name}.log", "\nup"))
        start = time.monotonic()
    assert 4.0 <= time.monotonic() - start < 5.0
    assert not any(alive(pid) for pid in recorder.pids())
    assert [state.name for state in recorder.states if state.state == "stopped"] == ["stubborn", "stubborn-last"]


async def test_those_that_end_last_hear_of_it_when_the_others_are_gone(tmp_path: Path, recorder: Recorder) -> None:
    async with supervisor(tmp_path, recorder) as running:
        running.start(python("redis", "import time; time.sleep(600)", ends_last=True))
        running.start(python("writer", "import time; time.sleep(600)"))
        await until(lambda: len(recorder.pids()) == 2)
        start = time.monotonic()
    assert time.monotonic() - start < 2.0
    assert [state.name for state in recorder.states if state.state == "stopped"] == ["writer", "redis"]


async def test_what_a_child_started_itself_ends_with_it(tmp_path: Path, recorder: Recorder) -> None:
    code = """
import subprocess, sys
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
print("grandchild", child.pid, flush=True)
child.wait()
"""
    async with supervisor(tmp_path, recorder) as running:
        running.start(python("parent", code))
        log = tmp_path / "parent.log"
        await until(lambda: contains(log, "\ngrandchild"))
        grandchild = int(log.read_text().rpartition("\ngrandchild")[2].split()[0])
        os.kill(recorder.pids()[0], signal.SIGKILL)
        await until(lambda: not alive(grandchild))


async def test_an_error_in_the_block_ends_the_children_and_comes_through(tmp_path: Path, recorder: Recorder) -> None:
    with pytest.raises(RuntimeError, match="while running"):
        async with supervisor(tmp_path, recorder) as running:
            running.start(python("sleeper", "import time; time.sleep(600)"))
            await until(lambda: bool(recorder.pids()))
            raise RuntimeError("while running")
    assert not alive(recorder.pids()[0])


async def test_cancelling_ends_the_children(tmp_path: Path, recorder: Recorder) -> None:
    async def hold() -> None:
        async with supervisor(tmp_path, recorder) as running:
            running.start(python("sleeper", "import time; time.sleep(600)"))
            await asyncio.Event().wait()

    task = asyncio.create_task(hold())
    await until(lambda: bool(recorder.pids()))
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert not alive(recorder.pids()[0])


@pytest.mark.skipif(sys.platform != "linux", reason="the kernel's parent-death signal is Linux's")
def test_kill_9_of_the_supervisor_leaves_no_orphan(tmp_path: Path) -> None:
    code = f"""
import asyncio, os, sys
from pathlib import Path
from launcher.child import ChildSpec
from launcher.supervisor import Supervisor
from protocol.clock import SystemClock
async def main():
    told = lambda state: print(state.pid, flush=True) if state.pid else None
    async with Supervisor(Path({str(tmp_path)!r}), SystemClock(), lambda name, line: None, told) as supervisor:
        for number in range(3):
            argv = (sys.executable, "-I", "-c", {IGNORES_TERM!r})
            supervisor.start(ChildSpec(f"child{{number}}", argv, dict(os.environ), Path("/")))
        await asyncio.Event().wait()
asyncio.run(main())
"""
    parent = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
    with parent:
        assert parent.stdout is not None
        pids = [int(parent.stdout.readline()) for _ in range(3)]
        asyncio.run(until(lambda: all(contains(tmp_path / f"child{number}.log", "\nup") for number in range(3))))
        assert all(alive(pid) for pid in pids)
        parent.kill()
    asyncio.run(until(lambda: not any(alive(pid) for pid in pids), limit_s=3.0))


def test_exit_statuses_in_words() -> None:
    assert describe_exit(3) == "ended with status 3"
    assert describe_exit(-11) == "killed by signal 11 (SIGSEGV)"
    assert describe_exit(-200) == "killed by signal 200"
