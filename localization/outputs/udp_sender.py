"""One UDP socket for everything that the tracker sends. Nothing waits: what the system does not take at once is lost, as the
next pose is as good as this one was."""

import logging
import socket
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from protocol.clock import Clock

_logger = logging.getLogger(__name__)

Address = tuple[str, int]
"""An IPv4 address and a port."""
_TELL_EVERY_S = 30.0


@dataclass(slots=True)
class Counts:
    """Datagrams handed to the system, and those that it refused."""

    sent: int = 0
    failed: int = 0


class UdpSender:
    """Sends datagrams without blocking and without raising. Broadcast addresses are allowed."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        self._told_s: dict[Address, float] = {}

    def send(self, data: bytes, address: Address, receiver: str, counts: Counts) -> bool:
        """Whether the system took the datagram; if not, a line in the log (now and then) names the receiver and the reason."""
        try:
            self._socket.sendto(data, address)
        except OSError as error:
            counts.failed += 1
            self._tell(address, receiver, error)
            return False
        counts.sent += 1
        return True

    def close(self) -> None:
        """Sending afterwards counts as failed."""
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _tell(self, address: Address, receiver: str, error: OSError) -> None:
        now_s = self._clock.monotonic_s()
        if now_s - self._told_s.get(address, -_TELL_EVERY_S) >= _TELL_EVERY_S:
            self._told_s[address] = now_s
            _logger.warning("poses for %s do not leave for %s:%d: %s", receiver, *address, error.strerror or error)
