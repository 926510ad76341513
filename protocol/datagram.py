"""The project's own UDP datagram: pure functions between bytes and messages, and a guard against replays.

Layout, big-endian:

| bytes | field |
|---|---|
| 2 | magic `LP` |
| 1 | version, 1 |
| 1 | kind: 1 POSE, 2 STATUS, 3 DRIVE, 4 ODOMETRY, 5 SCAN, 6 STOP |
| 1 | flags: bit 0 set when an HMAC follows the payload; the others are 0 |
| 1 | length of the sender's id, 1..32 |
| 8 | sequence: starts at the sender's clock in microseconds and grows by one per datagram |
| 8 | stamp: nanoseconds since the epoch at which it was sent |
| 2 | length of the payload, at most 1400 |
| n | sender id, UTF-8 |
| n | payload: the message as JSON |
| 32 | HMAC-SHA256 over all that precedes, where a key is configured |

Starting the sequence at the clock lets a restarted sender go on without a handshake: its numbers are larger than before.
"""

import hmac
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from types import MappingProxyType

from msgspec import Struct
from pydantic import BaseModel

from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.messages import DriveSetpoint, EmergencyStop, Odometry, Scan, Status, TrackedPose

MAGIC = b"LP"
VERSION = 1
TRACKER, LAB = "tracker", "lab"
"""Who sends POSE, and ODOMETRY and SCAN; STATUS and DRIVE bear the id of the robot that sends them."""
MAX_PAYLOAD = 1400
"""Keeps a datagram within one Ethernet frame."""
_HEADER = struct.Struct(">2sBBBBQQH")
_HMAC_FLAG = 1
_HMAC_SIZE = 32


class Kind(IntEnum):
    """What the payload is."""

    POSE = 1
    STATUS = 2
    DRIVE = 3
    ODOMETRY = 4
    SCAN = 5
    STOP = 6


MESSAGES: dict[Kind, type[BaseModel | Struct]] = {
    Kind.POSE: TrackedPose,
    Kind.STATUS: Status,
    Kind.DRIVE: DriveSetpoint,
    Kind.ODOMETRY: Odometry,
    Kind.SCAN: Scan,
    Kind.STOP: EmergencyStop,
}
_BY_NUMBER = {int(kind): (kind, message) for kind, message in MESSAGES.items()}
_KINDS: dict[type[BaseModel | Struct], Kind] = {message: kind for kind, message in MESSAGES.items()}


@dataclass(frozen=True, slots=True)
class Datagram:
    """A message with its envelope; `stamp_ns` is when it was sent, `payload` the message's bytes where it was received."""

    sender: str
    sequence: int
    stamp_ns: int
    message: BaseModel | Struct
    payload: bytes = field(default=b"", compare=False, repr=False)


def pack(datagram: Datagram, key: bytes | None = None) -> bytes:
    """The datagram's bytes, signed when there is a key. ValueError when it does not fit the layout."""
    kind = _KINDS.get(type(datagram.message))
    if kind is None:
        raise ValueError(f"{type(datagram.message).__name__} does not travel by datagram")
    return pack_payload(kind, datagram.sender, datagram.sequence, datagram.stamp_ns, encode(datagram.message), key)


def pack_payload(
    kind: Kind, sender: str, sequence: int, stamp_ns: int, payload: bytes, key: bytes | None = None
) -> bytes:
    """The same from a message that is encoded already."""
    sender_bytes = sender.encode()
    if not 1 <= len(sender_bytes) <= 32:
        raise ValueError(f"a sender id has 1 to 32 bytes, {sender!r} has {len(sender_bytes)}")
    if len(payload) > MAX_PAYLOAD:
        raise ValueError(f"{len(payload)} bytes of {kind.name} exceed the {MAX_PAYLOAD} of a datagram")
    for name, value in (("sequence", sequence), ("stamp", stamp_ns)):
        if not 0 <= value < 2**64:
            raise ValueError(f"{name} {value} does not fit a datagram")
    flags = _HMAC_FLAG if key else 0
    header = _HEADER.pack(MAGIC, VERSION, kind, flags, len(sender_bytes), sequence, stamp_ns, len(payload))
    body = header + sender_bytes + payload
    return body + _signature(key, body) if key else body


def unpack(
    data: bytes,
    key: bytes | None = None,
    readers: Mapping[Kind, Callable[[bytes], Struct | None]] = MappingProxyType({}),
) -> Datagram:
    """The datagram in `data`. DecodeError when it is short, of another layout, forged, or unsigned although a key is set;
    a signature is not looked at where no key is configured. Payloads of some kinds may have quicker `readers`: what such a one
    does not take is read in the usual way."""
    if len(data) < _HEADER.size:
        raise DecodeError(f"datagram of {len(data)} bytes is shorter than its header ({_HEADER.size})")
    magic, version, kind_number, flags, sender_size, sequence, stamp_ns, payload_size = _HEADER.unpack_from(data)
    if magic != MAGIC:
        raise DecodeError(f"datagram begins with {magic!r}, not {MAGIC!r}")
    if version != VERSION:
        raise DecodeError(f"datagram version {version}, this side speaks {VERSION}")
    if flags & ~_HMAC_FLAG:
        raise DecodeError(f"unknown datagram flags {flags:#04x}")
    signed = bool(flags & _HMAC_FLAG)
    body_size = _HEADER.size + sender_size + payload_size
    if len(data) != body_size + (_HMAC_SIZE if signed else 0):
        raise DecodeError(
            f"datagram of {len(data)} bytes, its header announces {body_size} and {'an' if signed else 'no'} HMAC"
        )
    if key is not None:
        if not signed:
            raise DecodeError("datagram is not signed, a key is configured")
        if not hmac.compare_digest(_signature(key, data[:body_size]), data[body_size:]):
            raise DecodeError("datagram signature does not match")
    if kind_number not in _BY_NUMBER:
        raise DecodeError(f"unknown datagram kind {kind_number}")
    kind, message_type = _BY_NUMBER[kind_number]
    try:
        sender = data[_HEADER.size : _HEADER.size + sender_size].decode()
    except UnicodeDecodeError as error:
        raise DecodeError("datagram sender is not UTF-8") from error
    if not sender:
        raise DecodeError("datagram without a sender")
    payload = data[_HEADER.size + sender_size : body_size]
    reader = readers.get(kind)
    message = reader(payload) if reader is not None else None
    return Datagram(sender, sequence, stamp_ns, message or decode(message_type, payload), payload)


def _signature(key: bytes, body: bytes) -> bytes:
    """HMAC-SHA256 (RFC 2104)."""
    return hmac.digest(key, body, "sha256")


class Verdict(StrEnum):
    """What the replay guard says of a datagram."""

    FRESH = "fresh"
    OLD = "old"
    FUTURE = "future"
    DUPLICATE = "duplicate"
    OUT_OF_ORDER = "out_of_order"


class ReplayGuard:
    """Lets each sender's datagrams through once, in order, while they are fresh; counts every verdict.

    `max_age_s` bounds how old a stamp may be, `max_ahead_s` how far in the future.
    """

    def __init__(self, max_age_s: float = 1.0, max_ahead_s: float = 0.5) -> None:
        self._max_age_ns = round(max_age_s * 1e9)
        self._max_ahead_ns = round(max_ahead_s * 1e9)
        self._newest: dict[str, int] = {}
        self.counts: dict[Verdict, int] = dict.fromkeys(Verdict, 0)

    def check(self, datagram: Datagram, now_ns: int) -> Verdict:
        """Only FRESH ones are to be used; they move the sender's newest sequence on."""
        sender, sequence = datagram.sender, datagram.sequence
        if -self._max_ahead_ns <= now_ns - datagram.stamp_ns <= self._max_age_ns and sequence > self._newest.get(
            sender, -1
        ):
            self._newest[sender] = sequence
            verdict = Verdict.FRESH
        else:
            verdict = self._refused(datagram, now_ns)
        self.counts[verdict] += 1
        return verdict

    def forget(self, sender: str) -> None:
        """Lets a sender start over, as after a registration with a clock that was set back."""
        self._newest.pop(sender, None)

    def _refused(self, datagram: Datagram, now_ns: int) -> Verdict:
        age_ns = now_ns - datagram.stamp_ns
        if age_ns > self._max_age_ns:
            return Verdict.OLD
        if -age_ns > self._max_ahead_ns:
            return Verdict.FUTURE
        return Verdict.DUPLICATE if datagram.sequence == self._newest[datagram.sender] else Verdict.OUT_OF_ORDER


class Sequencer:
    """Numbers a sender's datagrams from its clock in microseconds upwards."""

    def __init__(self, now_ns: int) -> None:
        self._next = now_ns // 1000

    def next(self) -> int:
        number = self._next
        self._next += 1
        return number
