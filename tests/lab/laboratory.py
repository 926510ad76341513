"""A simulated lab as a running service, and a robot's computer that talks to it over real UDP."""

import socket
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from protocol.datagram import Datagram, Sequencer, pack, unpack
from protocol.messages import DriveSetpoint, Odometry, Scan
from protocol.settings import Settings
from tests.lab.rooms import GULLIVER

PATIENCE_S = 30.0


def free_udp_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def write_lab(folder: Path, **simulation: Any) -> Path:
    """The shipped room with two cameras of 480 x 270 pixels and a free port; keywords add to its simulation."""
    lab = yaml.safe_load(GULLIVER.read_text())
    lab["cameras"] = lab["cameras"][:2]
    for camera in lab["cameras"]:
        intrinsics = camera["intrinsics"] | {"fx": 286.0, "fy": 286.0, "cx": 240.0, "cy": 135.0}
        camera.update(width=480, height=270, rate_hz=20, intrinsics=intrinsics)
    lab["simulation"]["mounts"] = {name: lab["simulation"]["mounts"][name] for name in ("cam0", "cam1")}
    lab["simulation"] |= simulation
    lab["ports"]["lab_udp"] = free_udp_port()
    file = folder / "lab.yaml"
    file.write_text(yaml.safe_dump(lab))
    return file


def settings_for(lab: Path, redis_url: str, key: bytes | None = None) -> Settings:
    return Settings(
        lab=lab,
        state=lab.parent / "state",
        redis_url=redis_url,
        server_url="http://127.0.0.1:1",
        host="127.0.0.1",
        udp_key=key,
        token="",
    )


class RobotComputer:
    """The other end of a base's cable."""

    def __init__(self, vehicle: str, port: int, key: bytes | None = None) -> None:
        self.vehicle = vehicle
        self.key = key
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.connect(("127.0.0.1", port))
        self.socket.setblocking(False)
        self.odometry: list[Odometry] = []
        self.scans: list[Scan] = []
        self._sequencer = Sequencer(time.time_ns())

    def drive(self, linear_mps: float, angular_radps: float = 0.0, vehicle: str | None = None) -> bytes:
        """Sends a set-point and returns its bytes."""
        number = self._sequencer.next()
        message = DriveSetpoint(vehicle or self.vehicle, number, linear_mps, angular_radps)
        data = pack(Datagram(self.vehicle, number, time.time_ns(), message), self.key)
        self.send(data)
        return data

    def send(self, data: bytes) -> None:
        try:
            self.socket.send(data)
        except ConnectionRefusedError:  # the lab is not up yet
            self.socket.send(data)

    def receive(self) -> list[Odometry]:
        """Takes in what has come; returns all odometry so far."""
        while True:
            try:
                data = self.socket.recv(4096)
            except (BlockingIOError, ConnectionRefusedError):
                return self.odometry
            message = unpack(data, self.key).message
            if isinstance(message, Scan):
                self.scans.append(message)
                continue
            assert isinstance(message, Odometry)
            self.odometry.append(message)


@contextmanager
def robot_computer(vehicle: str, port: int, key: bytes | None = None) -> Generator[RobotComputer]:
    computer = RobotComputer(vehicle, port, key)
    try:
        yield computer
    finally:
        computer.socket.close()


def wait_until(condition: Callable[[], object], what: str) -> None:
    """For tests without an event loop."""
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, f"not within {PATIENCE_S} s: {what}"
        time.sleep(0.01)
