"""How many robots one server bears: 10, 100 and 1,000 of them over real UDP and HTTP on loopback, with the real server, guidance
and Redis, one console watching."""

import argparse
import asyncio
import multiprocessing
import tempfile
from array import array
from collections.abc import AsyncGenerator, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

import httpx
import numpy as np

from launcher.errors import LauncherError, UsageError
from launcher.output import Result, progress
from protocol.channels import INTAKE
from protocol.clock import Clock, SystemClock
from tests.bench.fleet_lab import write_fleet_lab
from tests.bench.fleet_observer import Ages, follow_console, follow_fleet
from tests.bench.fleet_robots import Load, Played, play
from tests.bench.fleet_system import System, running

FLEETS = (10, 100, 1000)
_WARM_UP_S = 5.0
_SETTLE_S = 0.5 + 2.0 / INTAKE.rate_hz
_UP_S = 180.0
_END_S = 10.0


@dataclass(frozen=True, slots=True)
class Run:
    """One fleet's: what the robots met, what the observers saw (of the console only where one watched), the processor time by
    process while robots counted (s), the most memory by process (MB), and how many statuses the intake accepted and the fleet
    state showed since the start."""

    robots: int
    played: Played
    fleet: "array[float]"
    console: "array[float]"
    cpu_s: Mapping[str, float]
    rss_mb: Mapping[str, float]
    accepted: int
    shown: int


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--robots",
        type=int,
        nargs="+",
        default=list(FLEETS),
        metavar="N",
        help="sizes of fleets (default: 10 100 1000)",
    )
    parser.add_argument("--seconds", type=float, default=20.0, help="to count, for each fleet (default: 20)")
    parser.add_argument("--no-console", action="store_true", help="nobody watches")


def run(arguments: argparse.Namespace) -> Result:
    if any(robots < 1 for robots in arguments.robots):
        raise UsageError("--robots must be at least 1 each")
    if not arguments.seconds >= 1.0:
        raise UsageError(f"--seconds must be at least 1, not {arguments.seconds:g}")
    found: dict[str, float | int] = {}
    for robots in arguments.robots:
        progress(f"fleet of {robots}: starting")
        found |= figures(measure(robots, arguments.seconds, console=not arguments.no_console))
        told = f"robots_{robots}_status_p99_ms"
        progress(f"fleet of {robots}: {told} {found[told]:.0f}, lost {found[f'robots_{robots}_lost']}")
    settings = {"robots": arguments.robots, "seconds": arguments.seconds, "console": not arguments.no_console}
    return Result("fleet", found, settings=settings)


def measure(robots: int, seconds: float, *, console: bool, warm_up_s: float = _WARM_UP_S) -> Run:
    """A fleet of that size for that long. LauncherError when the system or the robots do not come up, or end early."""
    clock = SystemClock()
    with tempfile.TemporaryDirectory(prefix="lilliput-fleet-") as name:
        folder = Path(name)
        path, lab = write_fleet_lab(folder, robots)
        with running(lab, path, folder) as system:
            load = Load(system.tokens, lab.ports.http, system.udp_key)
            return asyncio.run(_observed(system, load, seconds, clock, warm_up_s, console=console))


def figures(done: Run) -> dict[str, float | int]:
    """The run in figures; `cpu_percent` is of one core."""
    key = f"robots_{done.robots}"
    found: dict[str, float | int] = {}
    ages = {"status": done.fleet, "command": done.played.command_ms, "console": done.console}
    for name, ms in ages.items():
        if len(ms):
            found[f"{key}_{name}_median_ms"], found[f"{key}_{name}_p99_ms"] = _percentiles(ms)
    found[f"{key}_lost"] = done.played.sent - done.accepted
    found[f"{key}_superseded"] = done.accepted - done.shown
    found[f"{key}_starved"] = done.played.starved
    found[f"{key}_refused"] = done.played.refused
    cpu = {name: 100.0 * used / done.played.seconds for name, used in done.cpu_s.items()}
    found[f"{key}_cpu_percent"] = sum(cpu.values())
    found[f"{key}_cpu_percent_per_robot"] = sum(cpu.values()) / done.robots
    found |= {f"{key}_{name}_cpu_percent": percent for name, percent in cpu.items()}
    found[f"{key}_load_cpu_percent"] = 100.0 * done.played.cpu_s / done.played.seconds
    found[f"{key}_rss_mb"] = sum(done.rss_mb.values())
    found |= {f"{key}_{name}_rss_mb": megabytes for name, megabytes in done.rss_mb.items()}
    found[f"{key}_statuses_hz"] = done.played.statuses / done.played.seconds
    found[f"{key}_commands_hz"] = len(done.played.command_ms) / done.played.seconds
    return found


def _percentiles(ms: Sequence[float]) -> tuple[float, float]:
    median, p99 = np.percentile(np.asarray(ms), (50.0, 99.0))
    return float(median), float(p99)


async def _observed(
    system: System, load: Load, seconds: float, clock: Clock, warm_up_s: float, *, console: bool
) -> Run:
    fleet, shown = Ages(), Ages()
    async with _playing(load) as robots:
        following = [asyncio.create_task(follow_fleet(system.redis_url, fleet, clock))]
        try:
            await _heard(robots, _UP_S)
            if console:
                following.append(asyncio.create_task(follow_console(system.url, system.operator, shown, clock)))
            await clock.sleep(warm_up_s)
            fleet.ms, shown.ms = array("d"), array("d")
            cpu_s, most = system.cpu_s(), system.rss_mb()
            robots.send("count")
            until_s = clock.monotonic_s() + seconds
            while clock.monotonic_s() < until_s:
                await clock.sleep(min(1.0, until_s - clock.monotonic_s()))
                most = {name: max(most[name], now) for name, now in system.rss_mb().items()}
            used = {name: now - cpu_s[name] for name, now in system.cpu_s().items()}
            fleet_ms, shown_ms = fleet.ms, shown.ms
            fleet.ms, shown.ms = array("d"), array("d")
            robots.send("stop")
            played = await _heard(robots, _END_S)
            assert isinstance(played, Played)
            await clock.sleep(_SETTLE_S)
            accepted = await _accepted(system)
            for task in following:
                if task.done():
                    task.result()
            return Run(len(load.tokens), played, fleet_ms, shown_ms, used, most, accepted, fleet.seen)
        finally:
            for task in following:
                task.cancel()
            await asyncio.gather(*following, return_exceptions=True)


@asynccontextmanager
async def _playing(load: Load) -> AsyncGenerator[Connection]:
    """The robots' process; it ends with the context."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=play, args=(theirs, load), daemon=True)
    process.start()
    theirs.close()
    try:
        yield ours
    finally:
        ours.close()
        await asyncio.to_thread(process.join, 1.0)
        if process.is_alive():
            process.terminate()
            await asyncio.to_thread(process.join, _END_S)


async def _heard(robots: Connection, within_s: float) -> object:
    """What the robots' process says next. LauncherError when that is what went wrong."""
    if not await asyncio.to_thread(robots.poll, within_s):
        raise LauncherError(f"the robots said nothing for {within_s:g} s")
    try:
        said: object = robots.recv()
    except EOFError:
        raise LauncherError("the robots' process ended") from None
    if isinstance(said, str):
        raise LauncherError(said)
    return said


async def _accepted(system: System) -> int:
    headers = {"Authorization": f"Bearer {system.operator}"}
    async with httpx.AsyncClient(base_url=system.url, headers=headers, trust_env=False, timeout=10.0) as client:
        answer = (await client.get("/api/health")).raise_for_status().json()
    return int(answer["udp"]["accepted"])
