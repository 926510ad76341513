"""A whole running system: Redis first, then accounts, then every other process of the table, until asked to stop."""

import asyncio
import os
import shutil
import signal
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Protocol

from launcher.child import ChildSpec
from launcher.environment import SystemSettings, child_spec
from launcher.paths import ROOT
from launcher.process_states import ProcessStates
from launcher.processes import REDIS, SERVER, ProcessInstance
from launcher.redis_server import (
    Opening,
    find_redis_server,
    prepare_folders,
    private_url,
    redis_argv,
    shown_url,
    socket_path,
    wait_for_redis,
    write_users,
)
from launcher.supervisor import Supervisor
from launcher.web_server import answers
from protocol.bus import Bus
from protocol.clock import Clock, SystemClock
from protocol.settings import frames_folder

REDIS_START_S = 60.0
"""A private Redis may have a long append-only file to read."""
REDIS_ANSWER_S = 5.0
CANCEL_AGAIN_S = 0.3
SERVER_FIRST_S = 10.0
"""How long the others wait for the server to answer; they can do without, but complain."""
SLOW_START_S = 60.0


class Accounts(Protocol):
    """What a system needs of the server's users and tokens, once Redis is up."""

    async def ensure_admin(self) -> str | None:
        """The new password when there was no admin yet, else None."""
        ...

    async def start_tours(self) -> list[str]:
        """Gives the simulated vehicles of a new lab something to do; which ones."""
        ...

    async def robot_tokens(self, robots: Sequence[str]) -> dict[str, str]:
        """A valid API token for each robot."""
        ...


@dataclass(frozen=True, slots=True)
class Terminal:
    """Where lines go: `step` says what goes on, `result` what the person asked for."""

    step: Callable[[str], None]
    result: Callable[[str], None]


class System:
    """Runs the given processes. Without `settings.redis_url` they must include the private Redis."""

    def __init__(
        self,
        processes: Sequence[ProcessInstance],
        settings: SystemSettings,
        accounts: Callable[[SystemSettings], Accounts],
        terminal: Terminal,
        clock: Clock | None = None,
    ) -> None:
        self._processes = processes
        self._private_redis = not settings.redis_url
        if self._private_redis:
            url = private_url(settings.state, opened=settings.redis_port is not None)
            settings = replace(settings, redis_url=url)
        self._settings = settings
        self._accounts = accounts
        self._terminal = terminal
        self._clock = clock or SystemClock()
        self._stop = asyncio.Event()
        self._supervisor: Supervisor | None = None
        self._untold_password: str | None = None

    def stop(self) -> None:
        """Ends the system in order; asked again, at once."""
        if self._stop.is_set() and self._supervisor is not None:
            self._supervisor.kill_all()
        self._stop.set()

    async def run_until_stopped(self) -> None:
        """Returns when `stop` was called and everything has ended. LauncherError when the start fails."""
        bus = Bus.connect(self._settings.redis_url, self._clock)
        states: list[ProcessStates] = []
        supervisor = Supervisor(
            self._settings.state / "logs",
            self._clock,
            tell=lambda name, line: self._terminal.step(f"{name}: {line}"),
            changed=lambda state: states[0].changed(state) if states else None,
        )
        states.append(ProcessStates(bus, self._clock, supervisor.states))
        try:
            async with supervisor:
                self._supervisor = supervisor
                starting = asyncio.create_task(self._start(supervisor, states[0]))
                stopping = asyncio.create_task(self._stop.wait())
                try:
                    await asyncio.wait({starting, stopping}, return_when=asyncio.FIRST_COMPLETED)
                finally:
                    stopping.cancel()
                    await _end(starting)
                    self._terminal.step("ending everything")
                if not starting.cancelled():
                    starting.result()  # the start failed: it has no other end
        finally:
            self._tell_password()
            self._supervisor = None
            await bus.close()
            if self._private_redis:
                _remove_socket_folder(self._settings)
            shutil.rmtree(frames_folder(self._settings.state), ignore_errors=True)

    async def _start(self, supervisor: Supervisor, states: ProcessStates) -> None:
        settings = self._settings
        if self._private_redis:
            self._terminal.step("starting Redis (private, in the state folder)")
            prepare_folders(settings.state)
            opening = None
            if settings.redis_port is not None:
                opening = Opening(settings.host, settings.redis_port)
                write_users(settings.state)
            supervisor.start(
                ChildSpec(
                    name=REDIS,
                    argv=redis_argv(find_redis_server(), settings.state, opening),
                    environment=os.environ,
                    folder=ROOT,
                    echo=False,
                    ends_last=True,
                )
            )
        else:
            self._terminal.step(f"using Redis at {shown_url(settings.redis_url)}")
        patience_s = REDIS_START_S if self._private_redis else REDIS_ANSWER_S
        await wait_for_redis(settings.redis_url, self._clock, patience_s)
        if self._private_redis:
            await states.forget_all()
        others = [process for process in self._processes if process.kind.name != REDIS]
        accounts = self._accounts(settings)
        has_server = any(process.kind.name == SERVER for process in others)
        if has_server:
            self._untold_password = await accounts.ensure_admin()
            if self._untold_password is not None and (driving := await accounts.start_tours()):
                self._terminal.step(f"first start: {', '.join(driving)} drive the tours of the lab file")
        tokens = await accounts.robot_tokens([process.id for process in others if process.kind.needs_token])
        if others:
            self._terminal.step(f"starting {', '.join(process.name for process in others)}")
        first = [process for process in others if process.kind.starts_first]
        for process in first:
            supervisor.start(child_spec(process, settings, tokens.get(process.id, "")))
        if has_server:
            await self._wait_for_server(SERVER_FIRST_S)
        for process in others:
            if process not in first:
                supervisor.start(child_spec(process, settings, tokens.get(process.id, "")))
        async with asyncio.TaskGroup() as group:
            group.create_task(states.publish_for_ever())
            if has_server:
                group.create_task(self._announce())

    async def _announce(self) -> None:
        """Says where the console is, and the first password, when the server answers."""
        url = self._settings.server_url
        if not await self._wait_for_server(SLOW_START_S):
            log = self._settings.state / "logs" / "server.log"
            self._terminal.step(f"the console does not answer yet; the reason may stand in {log}")
            await self._wait_for_server(float("inf"))
        self._terminal.result(f"Console:   {url}")
        self._tell_password()
        self._terminal.step("Ctrl-C ends everything")

    async def _wait_for_server(self, limit_s: float) -> bool:
        """Whether the server answered in this time."""
        deadline_s = self._clock.monotonic_s() + limit_s
        while not await answers(self._settings.server_url):
            if self._clock.monotonic_s() >= deadline_s:
                return False
            await self._clock.sleep(0.1)
        return True

    def _tell_password(self) -> None:
        """At the latest when everything ends: it is made only once, so it must not be lost."""
        if self._untold_password is not None:
            self._terminal.result(f"Log in as: admin, password {self._untold_password} (shown only this once)")
            self._untold_password = None


def run_system(system: Callable[[], System]) -> None:
    """Runs a system until SIGINT, SIGTERM or SIGHUP; LauncherError when its start fails."""

    async def run() -> None:
        running = system()
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            loop.add_signal_handler(number, running.stop)
        await running.run_until_stopped()

    asyncio.run(run())


async def _end(task: asyncio.Task[None]) -> None:
    """Cancels until it is over: before Python 3.12 `asyncio.wait_for`, which redis-py uses, may lose a cancellation that
    comes together with an answer."""
    while not task.done():
        task.cancel()
        await asyncio.wait({task}, timeout=CANCEL_AGAIN_S)


def _remove_socket_folder(settings: SystemSettings) -> None:
    socket = socket_path(settings.state)
    socket.unlink(missing_ok=True)
    if socket.parent != settings.state.resolve():
        with suppress(OSError):
            socket.parent.rmdir()
