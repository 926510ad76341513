"""One supervised process: started, watched, started again with backoff when it ends, and ended with all that it started.

Every child leads a process group of its own (so the terminal's Ctrl-C does not reach it and its whole group can be
ended), and the kernel kills it when the supervisor dies (`launcher/death_signal.py`).
"""

import asyncio
import os
import signal
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from launcher.backoff import Backoff
from launcher.log_file import CappedLog, OutputReader
from launcher.processes import Restart
from protocol.clock import Clock
from protocol.messages import ProcessState

GUARD = Path(__file__).with_name("death_signal.py")
_PIECE = 65536
_LAST_OUTPUT_S = 0.5


@dataclass(frozen=True, slots=True)
class ChildSpec:
    """What to run. `echo`: warnings in its output also reach the terminal. `ends_last`: ended after the others. `niceness`: how
    far it steps back for others when processors are short."""

    name: str
    argv: tuple[str, ...]
    environment: Mapping[str, str]
    folder: Path
    restart: Restart = "always"
    echo: bool = True
    ends_last: bool = False
    niceness: int = 0


class Child:
    """Keeps one process running until told to stop. `tell` gets lines for the terminal, `changed` every new state."""

    def __init__(
        self,
        spec: ChildSpec,
        log: CappedLog,
        clock: Clock,
        tell: Callable[[str], None],
        changed: Callable[[ProcessState], None],
    ) -> None:
        self.spec = spec
        self._log = log
        self._clock = clock
        self._tell = tell
        self._changed = changed
        self._backoff = Backoff()
        self._stopping = asyncio.Event()
        self._process: asyncio.subprocess.Process | None = None
        self._restarts = 0
        self._last_error = ""
        self.state = self._report("starting")

    async def keep_running(self) -> None:
        """Returns after `terminate` or `kill`, or when a process that is not restarted has ended."""
        while not self._stopping.is_set():
            started_s = self._clock.monotonic_s()
            last_line = await self._run_once()
            if self._stopping.is_set() or self.spec.restart == "never":
                break
            delay_s = self._backoff.delay_s(self._clock.monotonic_s() - started_s)
            said = f" ({last_line})" if last_line else ""
            self._tell(f"{self._last_error}{said}; starting it again in {delay_s:.1f} s, log: {self._log.path}")
            self._restarts += 1
            self._report("restarting")
            await self._pause(delay_s)
        self._report("stopped")

    def terminate(self) -> None:
        """Asks the process group to end, and starts nothing any more."""
        self._stopping.set()
        self._signal(signal.SIGTERM)

    def kill(self) -> None:
        """Ends the process group at once, and starts nothing any more."""
        self._stopping.set()
        self._signal(signal.SIGKILL)

    def refresh(self) -> ProcessState:
        """The present state with a fresh stamp."""
        self.state = self.state.model_copy(update={"stamp_ns": self._clock.now_ns()})
        return self.state

    async def _run_once(self) -> str:
        """One life of the process; its last line of output."""
        reader = OutputReader(self._log, self._tell, self._clock.monotonic_s, self.spec.echo)
        self._log.write(f"--- starting {' '.join(self.spec.argv)}\n".encode())
        read_end, write_end = os.pipe()
        output = asyncio.create_task(_read_output(read_end, reader))
        try:
            self._process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-I", "-S", str(GUARD), str(os.getpid()), str(self.spec.niceness), *self.spec.argv),
                cwd=self.spec.folder,
                env=dict(self.spec.environment),
                stdin=asyncio.subprocess.DEVNULL,
                stdout=write_end,
                stderr=write_end,
                start_new_session=True,
            )
        except OSError as error:
            self._last_error = f"could not be started: {error}"
            return ""
        finally:
            os.close(write_end)
            if self._process is None:
                output.cancel()
        try:
            if self._stopping.is_set():  # told to stop while the process was coming up
                self._signal(signal.SIGTERM)
            else:
                self._report("running")
            status = await self._process.wait()
            self._last_error = describe_exit(status)
        finally:
            self._signal(signal.SIGKILL)  # whatever it started itself must not live on
            self._process = None
            await _finish(output)
        return reader.last_line if status else ""

    async def _pause(self, seconds: float) -> None:
        sleeping = asyncio.create_task(self._clock.sleep(seconds))
        stopping = asyncio.create_task(self._stopping.wait())
        try:
            await asyncio.wait({sleeping, stopping}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            sleeping.cancel()
            stopping.cancel()

    def _signal(self, number: signal.Signals) -> None:
        if self._process is not None:
            with suppress(ProcessLookupError, PermissionError):  # the group is gone, or only its zombie is left (macOS)
                os.killpg(self._process.pid, number)

    def _report(self, state: str) -> ProcessState:
        now_ns = self._clock.now_ns()
        self.state = ProcessState.model_validate(
            {
                "name": self.spec.name,
                "state": state,
                "pid": self._process.pid if self._process and state == "running" else None,
                "restarts": self._restarts,
                "since_ns": now_ns,
                "stamp_ns": now_ns,
                "last_error": self._last_error,
            }
        )
        self._changed(self.state)
        return self.state


def describe_exit(status: int) -> str:
    """A process's exit status in words; negative ones are signals, as in `subprocess`."""
    if status >= 0:
        return f"ended with status {status}"
    with suppress(ValueError):
        return f"killed by signal {-status} ({signal.Signals(-status).name})"
    return f"killed by signal {-status}"


async def _read_output(read_end: int, reader: OutputReader) -> None:
    pipe = os.fdopen(read_end, "rb", 0)
    stream = asyncio.StreamReader()
    transport, _ = await asyncio.get_running_loop().connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(stream), pipe
    )
    try:
        while piece := await stream.read(_PIECE):
            reader.feed(piece)
    finally:
        reader.end()
        transport.close()


async def _finish(output: asyncio.Task[None]) -> None:
    """Reads what is left in the pipe; a process that left its group may hold it open, so not for ever."""
    await asyncio.wait({output}, timeout=_LAST_OUTPUT_S)
    output.cancel()
    await asyncio.wait({output})
