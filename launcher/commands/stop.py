"""`./lilliput stop`: the emergency stop for every robot, also when the server or Redis is dead.

It goes by UDP broadcast to the robots' agents, signed with the key of the state folder, and at the same time, where Redis
answers, into the latch, so that guidance, the console and robots that have no agent know it too. Neither way waits for the
other, and each is taken when the other fails. Only a person releases it, in the console.
"""

import argparse
import asyncio
import getpass
import os
from collections.abc import Awaitable
from pathlib import Path

import redis.asyncio
from redis.exceptions import RedisError

from launcher.errors import UsageError
from launcher.lab_file import add_lab_arguments, read_lab, state_folder
from launcher.output import Result, print_result, progress
from launcher.redis_server import private_url, socket_path
from launcher.state_folder import udp_key
from launcher.stop_broadcast import StopBroadcast, broadcast_addresses
from protocol.clock import Clock, SystemClock
from protocol.lab import GPSS_DRIVER, Lab
from protocol.messages import EmergencyStop, Status
from server.errors import ServiceError
from server.repositories.documents import Store
from server.repositories.emergency_stop import EmergencyStopRepository, newer_epoch

_REDIS_S = 2.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_lab_arguments(parser)
    parser.add_argument("--reason", default="", help="why, for everybody to read")
    parser.add_argument(
        "--to",
        action="append",
        metavar="ADDRESS",
        help="send there instead of to all networks of this machine (again for more; a robot behind a router, say)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object to stdout")


def run(arguments: argparse.Namespace) -> int:
    """0 when every robot of the lab that has an agent answered that it holds the stop and, if there are robots without one,
    Redis has it; else 1."""
    _, lab = read_lab(arguments.lab)
    state = state_folder(arguments.state, lab)
    robots = [vehicle.id for vehicle in lab.vehicles if vehicle.driver != GPSS_DRIVER]
    agentless = [vehicle.id for vehicle in lab.vehicles if vehicle.driver == GPSS_DRIVER]
    clock = SystemClock()
    now_ns = clock.now_ns()
    stop = EmergencyStop(
        engaged=True,
        epoch=newer_epoch(0, now_ns),
        stamp_ns=now_ns,
        by=_printable(_who())[:50],
        reason=_printable(arguments.reason)[:200],
    )
    targets = [(address, lab.ports.stop_udp) for address in arguments.to or broadcast_addresses()]
    try:
        broadcast = StopBroadcast(_key(state), clock, robots)
    except (UsageError, OSError) as error:  # no robot believes us, but the server does not ask for the key
        written = asyncio.run(_write(stop, state, lab, clock))
        if written is not None:
            raise UsageError(f"nobody is stopped: {error}; and {written}") from error
        progress(f"no robot is told directly: {error}")
        broadcast = StopBroadcast(None, clock, robots)
    else:
        written = asyncio.run(_both(broadcast.send(stop, targets), _write(stop, state, lab, clock)))
    silent = [robot for robot in robots if robot not in broadcast.answers]
    untold = [] if written is None else agentless
    if arguments.json:
        figures = {
            "robots_stopped": len(robots) - len(silent),
            "robots_silent": len(silent),
            "written": written is None,
        }
        settings = {"silent": silent, "untold": untold, "targets": [address for address, _ in targets]}
        print_result(Result("stop", figures, settings=settings), as_json=True)
    else:
        _tell(broadcast, silent, untold, written)
    return 1 if silent or untold else 0


async def _both(sending: Awaitable[None], writing: Awaitable[str | None]) -> str | None:
    """At the same time; what the second one says. It begins first, and is done long before the robots have answered."""
    written, _ = await asyncio.gather(writing, sending)
    return written


def _tell(broadcast: StopBroadcast, silent: list[str], untold: list[str], written: str | None) -> None:
    for robot, status in sorted(broadcast.answers.items()):
        print(f"{robot}: {_state(status)}", flush=True)
    until = (
        "The server, where it lives, now orders it to stand; else its own switch stops it 0.5 s after the last command"
        if written is None
        else "As long as the server commands it, it may DRIVE ON"
    )
    for robot in silent:
        print(f"{robot}: NO ANSWER. It may be off, or no broadcast reaches it: try --to ADDRESS. {until}", flush=True)
    for robot in untold:
        print(
            f"{robot}: NOT TOLD. It has no agent and hears of a stop by way of Redis only: it may DRIVE ON", flush=True
        )
    for address, why in broadcast.failures.items():
        progress(f"nothing could be sent to {address}: {why}")
    if written is None:
        progress("Redis has the stop for everybody. A person releases it in the console.")
    else:
        progress(f"Robots that answered hold the stop until a person releases it in the console, but {written}.")


def _state(status: Status) -> str:
    speed = abs(status.linear_mps)
    return "holds the stop, stands" if speed < 0.01 else f"holds the stop, braking at {speed:.2f} m/s"


async def _write(stop: EmergencyStop, state: Path, lab: Lab, clock: Clock) -> str | None:
    """Engages the latch in Redis; why not, when that fails."""
    try:
        url = _redis_url(state, lab)
        if url is None:
            return "no Redis runs here to write it to: other parts learn of it from the robots"
        async with asyncio.timeout(_REDIS_S), redis.asyncio.Redis.from_url(url) as client:
            await EmergencyStopRepository(Store(client), clock).engage(stop)
    except (RedisError, OSError, ServiceError, ValueError) as error:
        return f"Redis does not take it ({error or type(error).__name__}): other parts learn of it from the robots"
    return None


def _redis_url(state: Path, lab: Lab) -> str | None:
    url = os.environ.get("REDIS_URL")
    if url:
        return url
    return private_url(state, opened=lab.ports.redis is not None) if socket_path(state).exists() else None


def _key(state: Path) -> bytes:
    """The datagrams' key. UsageError when there is none: a key made now would be nobody's."""
    given = os.environ.get("LILLIPUT_UDP_KEY")
    if not given and not (state / "udp.key").exists():
        raise UsageError(
            f"{state} holds no key (udp.key), so no robot would believe this stop: name the folder of the system with --state, "
            "or set LILLIPUT_UDP_KEY"
        )
    return bytes.fromhex(udp_key(state, given))


def _printable(text: str) -> str:
    """Without what would swell in a datagram, or cannot be written in one: bytes of a shell that are no text."""
    return "".join(character if character.isprintable() else "?" for character in text)


def _who() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return "somebody at a shell"
