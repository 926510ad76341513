"""Looks whether the ports that a system needs are free, before anything is started."""

import errno
import socket
from collections.abc import Iterable
from dataclasses import dataclass

from launcher.errors import UsageError
from launcher.processes import INTAKE, REDIS, SERVER, ProcessInstance
from protocol.lab import Lab


@dataclass(frozen=True, slots=True)
class Port:
    """A port that a process will bind, and how to choose another one."""

    purpose: str
    kind: socket.SocketKind
    host: str
    number: int
    change: str


def needed_ports(lab: Lab, processes: Iterable[ProcessInstance], host: str, http_port: int) -> list[Port]:
    """The ports that these processes bind."""
    kinds = {process.kind.name for process in processes}
    ports: list[Port] = []
    if REDIS in kinds and lab.ports.redis is not None:
        ports.append(_in_lab_file("Redis for GPSS robots", socket.SOCK_STREAM, host, lab.ports.redis, "redis"))
    if SERVER in kinds:
        ports.append(Port("the console", socket.SOCK_STREAM, host, http_port, "give another with --http-port"))
    if INTAKE in kinds:
        ports.append(_in_lab_file("robots' datagrams", socket.SOCK_DGRAM, host, lab.ports.robots_udp, "robots_udp"))
    if "scene" in kinds:
        ports.append(_in_lab_file("the 3D scene", socket.SOCK_STREAM, "127.0.0.1", lab.ports.scene, "scene"))
    if "lab" in kinds:
        ports.append(_in_lab_file("the simulated lab", socket.SOCK_DGRAM, host, lab.ports.lab_udp, "lab_udp"))
    return ports


def require_free(ports: Iterable[Port]) -> None:
    """UsageError, naming the port and how to change it, for the first one that cannot be bound."""
    for port in ports:
        family = socket.AF_INET6 if ":" in port.host else socket.AF_INET
        with socket.socket(family, port.kind) as probe:
            if port.kind == socket.SOCK_STREAM:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((port.host, port.number))
            except OSError as error:
                raise UsageError(_sentence(port, error)) from error


def _sentence(port: Port, error: OSError) -> str:
    kind = "TCP" if port.kind == socket.SOCK_STREAM else "UDP"
    if error.errno == errno.EADDRINUSE:
        return f"{kind} port {port.number} ({port.purpose}) is in use by another program: {port.change}"
    if error.errno == errno.EACCES:
        return f"{kind} port {port.number} ({port.purpose}) needs root: {port.change}"
    return f"cannot listen on {port.host} {kind} port {port.number} ({port.purpose}): {error.strerror or error}"


def _in_lab_file(purpose: str, kind: socket.SocketKind, host: str, number: int, key: str) -> Port:
    return Port(purpose, kind, host, number, f"change ports.{key} in the lab file")
