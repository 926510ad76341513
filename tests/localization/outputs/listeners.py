"""Who hears what leaves the tracker, and a pose that leaves it."""

import asyncio
import socket
from collections.abc import Callable

from protocol.datagram import Datagram, unpack
from protocol.messages import Registration, TrackedPose

STAMP_NS = 1_700_000_000_123_000_000


def pose(vehicle: str = "robot-10", x: float = 1.0, y: float = 0.5, yaw: float = 0.3) -> TrackedPose:
    return TrackedPose(vehicle, STAMP_NS, x, y, yaw, 0.3, 0.4, 0.2, (1e-6, 0, 0, 1e-6, 0, 1e-6), ("right",), "room")


class Ear:
    """A socket on loopback that somebody sends to."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)
        self.port: int = self.socket.getsockname()[1]

    def registration(self, robot: str, host: str = "127.0.0.1") -> Registration:
        return Registration(robot=robot, host=host, udp_port=self.port)

    def all(self) -> list[bytes]:
        """What has arrived; on loopback a datagram is there when `sendto` returns."""
        heard: list[bytes] = []
        while True:
            try:
                heard.append(self.socket.recv(2048))
            except BlockingIOError:
                return heard

    def poses(self, key: bytes | None = None) -> list[Datagram]:
        return [unpack(data, key) for data in self.all()]


async def until(condition: Callable[[], bool]) -> None:
    """Lets the loop and its threads go on until the condition holds."""
    for _ in range(5000):
        if condition():
            return
        await asyncio.sleep(0.002)
    raise AssertionError("waited in vain")
