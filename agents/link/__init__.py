"""The agent's ways to the server: registration, commands and responses over HTTP, poses and statuses over UDP."""

from agents.link.commands import CommandStream
from agents.link.datagrams import RobotSocket, bind_host, server_host
from agents.link.http import make_client
from agents.link.registration import Introduction, Registrar, Welcome
from agents.link.responses import ResponseQueue
from agents.link.stops import StopListener, stop_host

__all__ = [
    "CommandStream",
    "Introduction",
    "Registrar",
    "ResponseQueue",
    "RobotSocket",
    "StopListener",
    "Welcome",
    "bind_host",
    "make_client",
    "server_host",
    "stop_host",
]
