"""`./lilliput run PROCESS`: one process of the table in the foreground, for containers and service managers.

It gets the same environment as under `up`: settings come from the environment where given, the datagram key and the
robots' tokens from the state folder. It waits for Redis first and is then replaced by the process, so that signals and
the exit status are the process's own.
"""

import argparse
import asyncio
import os

from launcher import environment
from launcher.accounts import ServerAccounts
from launcher.errors import UsageError
from launcher.lab_file import add_lab_arguments, read_lab, state_folder
from launcher.output import progress
from launcher.paths import ROOT
from launcher.processes import PROCESSES, REDIS, SERVER, ProcessInstance, expand, select
from launcher.redis_server import (
    Opening,
    find_redis_server,
    prepare_folders,
    redis_argv,
    wait_for_redis,
    write_users,
)
from launcher.state_folder import udp_key
from protocol.clock import SystemClock

REDIS_START_S = 60.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = "processes and when a lab has them:\n" + "\n".join(
        f"  {kind.name + ('-ID' if '{id}' in kind.argv else ''):<12}{kind.runs}" for kind in PROCESSES
    )
    parser.add_argument("process", metavar="PROCESS", help="a name of the process table, e.g. server or camera-cam0")
    add_lab_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    path, lab = read_lab(arguments.lab)
    found = select(expand(lab), {arguments.process})
    if len(found) != 1:
        raise UsageError(f"{arguments.process} is several processes; choose one of {', '.join(p.name for p in found)}")
    process, state = found[0], state_folder(arguments.state, lab)
    state.mkdir(parents=True, exist_ok=True, mode=0o700)
    if process.kind.name == REDIS:
        prepare_folders(state)
        opening = None
        if lab.ports.redis is not None:
            opening = Opening(os.environ.get("LILLIPUT_HOST") or "127.0.0.1", lab.ports.redis)
            write_users(state)
        return _become(redis_argv(find_redis_server(), state, opening), dict(os.environ))
    url = os.environ.get("REDIS_URL")
    if not url:
        raise UsageError("set REDIS_URL to the Redis that all processes share (`./lilliput up` starts one by itself)")
    host = os.environ.get("LILLIPUT_HOST") or "127.0.0.1"
    port = environment.http_port(lab, None)
    settings = environment.SystemSettings(
        lab=path,
        state=state,
        redis_url=url,
        host=host,
        http_port=port,
        server_url=os.environ.get("LILLIPUT_SERVER") or environment.server_url(host, port),
        udp_key=udp_key(state, os.environ.get("LILLIPUT_UDP_KEY")),
    )
    token = asyncio.run(_prepare(process, settings))
    return _become(environment.python_argv(process), environment.child_environment(settings, token))


async def _prepare(process: ProcessInstance, settings: environment.SystemSettings) -> str:
    """Waits for Redis, makes the first user when this is the server; the token of an agent."""
    await wait_for_redis(settings.redis_url, SystemClock(), REDIS_START_S)
    if process.kind.name == SERVER:
        password = await ServerAccounts(settings).ensure_admin()
        if password is not None:
            await ServerAccounts(settings).start_tours()
            progress(f"Log in as: admin, password {password} (shown only this once)")
    if not process.kind.needs_token:
        return ""
    given = os.environ.get("LILLIPUT_TOKEN")
    return given or (await ServerAccounts(settings).robot_tokens([process.id]))[process.id]


def _become(argv: tuple[str, ...], settings: dict[str, str]) -> int:
    os.chdir(ROOT)
    os.execvpe(argv[0], argv, settings)  # noqa: S606  # a list, and no shell is wanted
