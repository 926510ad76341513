"""What the launcher tells its children through their environment (`protocol.settings` reads it), and their command lines."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from launcher.child import ChildSpec
from launcher.paths import PYTHON, ROOT
from launcher.processes import ProcessInstance
from protocol.lab import Lab

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENCV_FOR_THREADS_NUM": "1", "OPENBLAS_NUM_THREADS": "1"}
"""Many processes share the machine: libraries that start a thread per core would only get in each other's way."""


@dataclass(frozen=True, slots=True)
class SystemSettings:
    """What all processes of one system are told. `host` is what servers bind to, `server_url` where agents find it; `run` names
    the folder of stage timings that they share (each has one of its own when it is empty); `redis_port` opens the private
    Redis to GPSS robots."""

    lab: Path
    state: Path
    redis_url: str
    host: str
    http_port: int
    server_url: str
    udp_key: str
    run: str = ""
    redis_port: int | None = None


def server_url(host: str, port: int) -> str:
    """The address of the server for processes on this machine, given what it binds to."""
    reachable = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(host, f"[{host}]" if ":" in host else host)  # noqa: S104
    return f"http://{reachable}:{port}"


def http_port(lab: Lab, given: int | None) -> int:
    """The console's port: as given on the command line, else the lab file's."""
    return given if given is not None else lab.ports.http


def child_environment(settings: SystemSettings, token: str, base: Mapping[str, str] = os.environ) -> dict[str, str]:
    """The environment of one child; `token` is its API token or empty."""
    environment = {
        **base,
        **ONE_THREAD,
        "PYTHONPATH": str(ROOT),
        "PYTHONUNBUFFERED": "1",
        "LILLIPUT_LAB": str(settings.lab),
        "LILLIPUT_STATE": str(settings.state),
        "LILLIPUT_HOST": settings.host,
        "LILLIPUT_HTTP_PORT": str(settings.http_port),
        "LILLIPUT_SERVER": settings.server_url,
        "LILLIPUT_UDP_KEY": settings.udp_key,
        "REDIS_URL": settings.redis_url,
    }
    if settings.run:
        environment["LILLIPUT_RUN"] = settings.run
    environment.pop("LILLIPUT_TOKEN", None)
    if token:
        environment["LILLIPUT_TOKEN"] = token
    return environment


def python_argv(process: ProcessInstance) -> tuple[str, ...]:
    """The command line of a process of the table that is a Python module."""
    return (PYTHON, "-P", *process.argv)


def child_spec(process: ProcessInstance, settings: SystemSettings, token: str) -> ChildSpec:
    """How the supervisor starts a process of the table."""
    return ChildSpec(
        name=process.name,
        argv=python_argv(process),
        environment=child_environment(settings, token),
        folder=ROOT,
        restart=process.kind.restart,
        niceness=process.kind.niceness,
    )
