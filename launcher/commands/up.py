"""`./lilliput up`: the whole system for a lab, until Ctrl-C."""

import argparse
import os

from launcher import environment
from launcher.accounts import ServerAccounts
from launcher.errors import UsageError
from launcher.lab_file import add_lab_arguments, read_lab, state_folder
from launcher.output import progress
from launcher.paths import WEB
from launcher.ports import needed_ports, require_free
from launcher.processes import REDIS, SERVER, expand, select
from launcher.state_folder import locked, udp_key
from launcher.system import System, Terminal, run_system
from launcher.web_build import build_web
from protocol.clock import SystemClock
from protocol.timings import run_name


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_lab_arguments(parser)
    parser.add_argument("--only", metavar="NAMES", help="comma-separated processes, e.g. camera-cam0,tracker or camera")
    parser.add_argument("--http-port", type=_port, metavar="N", help="port of the console (default: the lab file's)")
    parser.add_argument("--host", default=os.environ.get("LILLIPUT_HOST", "127.0.0.1"), help="address to listen on")


def run(arguments: argparse.Namespace) -> int:
    path, lab = read_lab(arguments.lab)
    shared_redis = os.environ.get("REDIS_URL", "")
    processes = [process for process in expand(lab) if not (shared_redis and process.kind.name == REDIS)]
    if arguments.only is not None:
        chosen = {name.strip() for name in arguments.only.split(",") if name.strip()}
        if not chosen:
            raise UsageError("--only needs the name of a process")
        processes = select(processes, chosen if shared_redis else {*chosen, REDIS})
    state = state_folder(arguments.state, lab)
    with locked(state):
        port = environment.http_port(lab, arguments.http_port)
        require_free(needed_ports(lab, processes, arguments.host, port))
        if any(process.kind.name == SERVER for process in processes):
            build_web(WEB, progress)
        settings = environment.SystemSettings(
            lab=path,
            state=state,
            redis_url=shared_redis,
            host=arguments.host,
            http_port=port,
            server_url=os.environ.get("LILLIPUT_SERVER") or environment.server_url(arguments.host, port),
            udp_key=udp_key(state, os.environ.get("LILLIPUT_UDP_KEY")),
            run=os.environ.get("LILLIPUT_RUN") or run_name(SystemClock().now_ns()),
            redis_port=lab.ports.redis,
        )
        progress(f"lab {lab.name} ({path}), state and logs in {state}")
        terminal = Terminal(step=progress, result=lambda line: print(line, flush=True))
        run_system(lambda: System(processes, settings, ServerAccounts, terminal))
        progress("everything has ended")
    return 0


def _port(text: str) -> int:
    number = int(text)
    if not 0 < number < 65536:
        raise argparse.ArgumentTypeError("a port is a number from 1 to 65535")
    return number
