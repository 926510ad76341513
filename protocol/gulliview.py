"""The UDP packets of the GulliView systems, bit-exact: pure functions between bytes and packets, and between the map frame and
theirs (spec udp; GulliView 2025, eq. 3.15; GulliView 2023, eq. 3.8-3.9).

All big-endian and packed, no version field, always 256 bytes, zero-padded behind the last detection:

| layout | header | one detection | most |
|---|---|---|---|
| `gulliview-2021` | type, subtype, seq, time_msec, unused, length: 32 B | tag_id, x, y, camera_id: 16 B | 13 |
| `gulliview-2023` | the same with another unused word: 36 B | tag_id, x, y, theta, speed, camera_id: 24 B | 9 |
| `gulliview-2025a` | 36 B | tag_id, time_msec, x, y, theta, speed, camera_id: 32 B | 6 |
| `gulliview-2025` | 36 B with average_gap, camera_id for the unused | the same with z behind y: 36 B | 6 |

Which layout a peer speaks is configuration: the bytes do not tell.
"""

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass

from geometry import wrap_angle
from protocol.errors import DecodeError
from protocol.lab import GulliViewLayout, Lab

SIZE = 256
"""Bytes of every datagram; receivers refuse others."""
TYPE, SUBTYPE = 1, 2
PIXELS_PER_M = 1298.0
"""The unit of the 2021 and 2023 servers (GulliView 2023, eq. 3.8)."""
_MM_PER_M = 1000.0
_SEQUENCE_MODULUS = 2**32


@dataclass(frozen=True, slots=True)
class GulliViewDetection:
    """One tag. `x`, `y`, `z` are int32 in the layout's unit and frame (2025: mm, z up from the floor; 2021, 2023: 1/1298 m);
    `theta` rad, clockwise seen from above in the layout's frame; `speed` m/s; `camera_id` counts the cameras from 0;
    `time_msec` is the capture time since the epoch. What a layout has no room for is not sent and comes back as zero.
    """

    tag_id: int
    x: int
    y: int
    theta: float = 0.0
    speed: float = 0.0
    camera_id: int = 0
    time_msec: int = 0
    z: int = 0


@dataclass(frozen=True, slots=True)
class GulliViewPacket:
    """A datagram. `time_msec` since the epoch; `average_gap` (ms) and `camera_id` exist in `gulliview-2025` alone."""

    seq: int
    time_msec: int
    detections: tuple[GulliViewDetection, ...]
    average_gap: int = 0
    camera_id: int = 0


@dataclass(frozen=True, slots=True)
class _Format:
    """How a layout packs: field names in the order of the struct codes, None for a word that nobody uses."""

    header: struct.Struct
    header_fields: tuple[str | None, ...]
    detection: struct.Struct
    detection_fields: tuple[str, ...]
    capacity: int


# Positions are packed as signed words: the bytes are those of int32, which receivers that unpack `I` read as unsigned.
_LONG = struct.Struct(">IIIQQII")
_PLAIN = ("type", "subtype", "seq", "time_msec", None, None, "length")
_FORMATS: dict[GulliViewLayout, _Format] = {
    "gulliview-2021": _Format(
        struct.Struct(">IIIQQI"),
        ("type", "subtype", "seq", "time_msec", None, "length"),
        struct.Struct(">IiiI"),
        ("tag_id", "x", "y", "camera_id"),
        13,  # a fourteenth would fit; the known senders and receivers stop here
    ),
    "gulliview-2023": _Format(
        _LONG, _PLAIN, struct.Struct(">IiiffI"), ("tag_id", "x", "y", "theta", "speed", "camera_id"), 9
    ),
    "gulliview-2025a": _Format(
        _LONG, _PLAIN, struct.Struct(">IQiiffI"), ("tag_id", "time_msec", "x", "y", "theta", "speed", "camera_id"), 6
    ),
    "gulliview-2025": _Format(
        _LONG,
        ("type", "subtype", "seq", "time_msec", "average_gap", "camera_id", "length"),
        struct.Struct(">IQiiiffI"),
        ("tag_id", "time_msec", "x", "y", "z", "theta", "speed", "camera_id"),
        6,
    ),
}
LAYOUTS: tuple[GulliViewLayout, ...] = tuple(_FORMATS)


def capacity(layout: GulliViewLayout) -> int:
    """The most detections that one datagram of the layout holds."""
    return _FORMATS[layout].capacity


def pack(layout: GulliViewLayout, packet: GulliViewPacket) -> bytes:
    """The packet's 256 bytes. ValueError, naming the field, for what does not fit the layout."""
    form = _FORMATS[layout]
    if len(packet.detections) > form.capacity:
        raise ValueError(f"{len(packet.detections)} detections exceed the {form.capacity} of a {layout} datagram")
    values = {"type": TYPE, "subtype": SUBTYPE, "length": len(packet.detections)}
    header = [values.get(name, getattr(packet, name, 0)) if name else 0 for name in form.header_fields]
    parts = [_packed(form.header, header, form.header_fields, f"{layout} header")]
    for index, detection in enumerate(packet.detections):
        fields = [getattr(detection, name) for name in form.detection_fields]
        parts.append(_packed(form.detection, fields, form.detection_fields, f"{layout} detection {index}"))
    return b"".join(parts).ljust(SIZE, b"\0")


def unpack(layout: GulliViewLayout, data: bytes) -> GulliViewPacket:
    """The packet in `data`, positions as signed words. DecodeError when it is not one of the layout. What stands in unused
    words and behind the last detection is not looked at, as by the receivers that exist."""
    form = _FORMATS[layout]
    if len(data) != SIZE:
        raise DecodeError(f"{layout}: {len(data)} bytes, a datagram has {SIZE}")
    header = {
        name: value for name, value in zip(form.header_fields, form.header.unpack_from(data), strict=True) if name
    }
    for name, expected in (("type", TYPE), ("subtype", SUBTYPE)):
        if header.pop(name) != expected:
            raise DecodeError(f"{layout}: {name} is not {expected}")
    length = header.pop("length")
    if length > form.capacity:
        raise DecodeError(f"{layout}: {length} detections announced, a datagram holds {form.capacity}")
    detections: list[GulliViewDetection] = []
    for index in range(length):
        found = form.detection.unpack_from(data, form.header.size + index * form.detection.size)
        fields = dict(zip(form.detection_fields, found, strict=True))
        for name in ("theta", "speed"):
            if not math.isfinite(fields.get(name, 0.0)):
                raise DecodeError(f"{layout}: {name} of detection {index} is {fields[name]}")
        detections.append(GulliViewDetection(**fields))
    return GulliViewPacket(detections=tuple(detections), **header)


def split(
    layout: GulliViewLayout,
    seq: int,
    time_msec: int,
    detections: Sequence[GulliViewDetection],
    *,
    average_gap: int = 0,
    camera_id: int = 0,
) -> list[GulliViewPacket]:
    """As many packets as the detections need: the same time, `seq` rising by one (modulo 2^32) from the one given; none for no
    detections."""
    step = capacity(layout)
    return [
        GulliViewPacket(
            (seq + number) % _SEQUENCE_MODULUS,
            time_msec,
            tuple(detections[start : start + step]),
            average_gap,
            camera_id,
        )
        for number, start in enumerate(range(0, len(detections), step))
    ]


def to_wire(layout: GulliViewLayout, x_m: float, y_m: float, yaw: float) -> tuple[int, int, float]:
    """x, y (the layout's unit, rounded) and theta of a pose in the map frame (m, rad)."""
    if layout in ("gulliview-2021", "gulliview-2023"):
        return round(x_m * PIXELS_PER_M), round(y_m * PIXELS_PER_M), wrap_angle(-yaw)
    return round(y_m * _MM_PER_M), round(x_m * _MM_PER_M), wrap_angle(math.pi / 2 - yaw)


def to_map(layout: GulliViewLayout, detection: GulliViewDetection) -> tuple[float, float, float]:
    """x, y (m) and yaw (rad) in the map frame of a detection; `gulliview-2021` has no angle, its yaw means nothing."""
    if layout in ("gulliview-2021", "gulliview-2023"):
        return detection.x / PIXELS_PER_M, detection.y / PIXELS_PER_M, wrap_angle(-detection.theta)
    return detection.y / _MM_PER_M, detection.x / _MM_PER_M, wrap_angle(math.pi / 2 - detection.theta)


def areas_that_wrap(lab: Lab) -> list[str]:
    """Sentences on the areas in which a coordinate is negative: known receivers unpack positions as unsigned words."""
    sentences: list[str] = []
    for area in lab.areas:
        below = [
            f"{axis} = {lowest:g} m"
            for axis, lowest in (("x", min(x for x, _ in area.outline)), ("y", min(y for _, y in area.outline)))
            if lowest < 0
        ]
        if below:
            sentences.append(
                f"area {area.id!r} reaches {' and '.join(below)}: GulliView receivers read negative coordinates as huge"
                " positive ones; move the lab's origin if a robot drives there by them"
            )
    return sentences


def _packed(form: struct.Struct, values: Sequence[int | float], names: Sequence[str | None], where: str) -> bytes:
    try:
        return form.pack(*values)
    except (struct.error, OverflowError):
        codes = form.format.lstrip(">")
        for name, code, value in zip(names, codes, values, strict=True):
            try:
                struct.pack(f">{code}", value)
            except (struct.error, OverflowError):
                raise ValueError(f"{where}: {name} {value} does not fit") from None
        raise
