"""Ten thousand mutated datagrams per codec: each is refused with the codec's one error, or is a message that is sound."""

import hmac
import math
import random
from collections.abc import Iterator
from hashlib import sha256
from typing import Any

import msgspec
import pytest
from pydantic import BaseModel

from protocol.codec import encode
from protocol.datagram import Datagram, Kind, pack, unpack
from protocol.errors import DecodeError
from protocol.gulliview import GulliViewDetection, GulliViewPacket
from protocol.gulliview import pack as pack_gulliview
from protocol.gulliview import unpack as unpack_gulliview
from protocol.lab import GulliViewLayout
from protocol.messages import (
    DriveSetpoint,
    EmergencyStop,
    Odometry,
    Reason,
    ReasonCode,
    Scan,
    Status,
    TrackedPose,
)
from tests.mutations import mutated

COUNT = 10_000
KEY = b"0123456789abcdef"
NOW_NS = 1_700_000_000_000_000_000
MESSAGES: dict[Kind, Any] = {
    Kind.POSE: TrackedPose(
        "wifibot-14", NOW_NS, 1.0, 2.0, 0.5, 0.1, 0.0, 0.0, (1.0, 0.0, 0.0, 1.0, 0.0, 1.0), ("cam0",)
    ),
    Kind.STATUS: Status(
        robot="wifibot-14",
        sequence=7,
        stamp_ns=NOW_NS,
        x=1.0,
        y=2.0,
        yaw=0.5,
        linear_mps=0.3,
        angular_radps=-0.1,
        ip="10.0.0.7",
        battery=0.5,
        faults=("hot",),
        command_order=(3, 4),
        stopped_by=Reason(code=ReasonCode.OBSTACLE, text="0.3 m"),
    ),
    Kind.DRIVE: DriveSetpoint("wifibot-14", 7, 0.3, -0.1),
    Kind.ODOMETRY: Odometry("wifibot-14", "a", NOW_NS, 1.0, 2.0, 0.5, 0.3, -0.1, 0.9, 0.7),
    Kind.SCAN: Scan("wifibot-14", NOW_NS, -0.04, 0.02, bytes.fromhex("0000 03e8 03e9 0000 ffff")),
    Kind.STOP: EmergencyStop(engaged=True, epoch=NOW_NS // 1_000_000, stamp_ns=NOW_NS, by="anna", reason="smoke"),
}
LAYOUTS: tuple[GulliViewLayout, ...] = ("gulliview-2021", "gulliview-2023", "gulliview-2025a", "gulliview-2025")


def numbers(value: object) -> Iterator[float]:
    """Every number in a message."""
    if isinstance(value, BaseModel):
        value = value.model_dump()
    elif isinstance(value, msgspec.Struct):
        value = msgspec.structs.asdict(value)
    if isinstance(value, dict):
        for item in value.values():
            yield from numbers(item)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from numbers(item)
    elif isinstance(value, int | float):
        yield value


@pytest.mark.parametrize("kind", Kind)
def test_a_mutated_datagram_is_refused_or_sound(kind: Kind) -> None:
    """Unsigned and, half of the time, with its lengths made right again, so that the mutations reach the message."""
    rng = random.Random(kind.value)
    whole = pack(Datagram("wifibot-14", 7, NOW_NS, MESSAGES[kind]))
    payload = encode(MESSAGES[kind])
    head = len(whole) - len(payload)
    refused = 0
    for number in range(COUNT):
        if number % 2:
            data = mutated(whole, rng)
        else:
            changed = mutated(payload, rng)[:1400]
            data = whole[:22] + len(changed).to_bytes(2, "big") + whole[24:head] + changed
        try:
            datagram = unpack(data)
        except DecodeError:
            refused += 1
            continue
        assert all(math.isfinite(value) for value in numbers(datagram.message))
        assert unpack(pack(datagram)) == datagram, "what was understood can be said again"
    assert COUNT // 2 < refused < COUNT, "most are refused, and some are not: the mutations are no mere noise"


@pytest.mark.parametrize("kind", Kind)
def test_where_a_key_is_set_no_mutation_gets_through(kind: Kind) -> None:
    rng = random.Random(kind.value)
    whole = pack(Datagram("wifibot-14", 7, NOW_NS, MESSAGES[kind]), KEY)
    for _ in range(COUNT):
        with pytest.raises(DecodeError):
            unpack(mutated(whole, rng), KEY)
    assert hmac.compare_digest(whole[-32:], hmac.digest(KEY, whole[:-32], sha256))


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_mutated_gulliview_packet_is_refused_or_sound(layout: GulliViewLayout) -> None:
    rng = random.Random(layout)
    detections = tuple(GulliViewDetection(4, 1000, 2000, 0.5, 0.3, 1, 123456, 350) for _ in range(3))
    whole = pack_gulliview(layout, GulliViewPacket(7, 123456789, detections))
    refused = 0
    for number in range(COUNT):
        data = mutated(whole, rng)
        if number % 2:  # of the right length, so that the mutations reach the fields
            data = data[:256].ljust(256, b"\0")
        try:
            packet = unpack_gulliview(layout, data)
        except DecodeError:
            refused += 1
            continue
        for detection in packet.detections:
            assert math.isfinite(detection.theta)
            assert math.isfinite(detection.speed)
        assert unpack_gulliview(layout, pack_gulliview(layout, packet)) == packet
    assert 0 < refused < COUNT
