"""The packets of the existing systems: golden bytes, the receivers' own struct formats, round trips, garbage, frames."""

import contextlib
import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry import SE2, wrap_angle
from protocol.errors import DecodeError
from protocol.gulliview import (
    LAYOUTS,
    SIZE,
    GulliViewDetection,
    GulliViewPacket,
    areas_that_wrap,
    capacity,
    pack,
    split,
    to_map,
    to_wire,
    unpack,
)
from protocol.lab import GulliViewLayout
from tests.localization.synthetic import small_lab

# As the specification writes them, and as known receivers unpack them: positions unsigned.
RECEIVERS: dict[GulliViewLayout, tuple[str, str, int]] = {
    "gulliview-2021": (">IIIQQI", ">IIII", 13),
    "gulliview-2023": (">IIIQQII", ">IIIffI", 9),
    "gulliview-2025a": (">IIIQQII", ">IQIIffI", 6),
    "gulliview-2025": (">IIIQQII", ">IQIIIffI", 6),
}
layouts = st.sampled_from(LAYOUTS)
u32, u64 = st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1)
i32 = st.integers(-(2**31), 2**31 - 1)
f32 = st.floats(width=32, allow_nan=False, allow_infinity=False)


@st.composite
def packets(draw: st.DrawFn) -> tuple[GulliViewLayout, GulliViewPacket]:
    """Any packet that its layout can carry whole."""
    layout = draw(layouts)
    newest, angled, timed = layout == "gulliview-2025", layout != "gulliview-2021", layout.startswith("gulliview-2025")
    zero, zero_f = st.just(0), st.just(0.0)
    detection = st.builds(
        GulliViewDetection,
        tag_id=u32,
        x=i32,
        y=i32,
        theta=f32 if angled else zero_f,
        speed=f32 if angled else zero_f,
        camera_id=u32,
        time_msec=u64 if timed else zero,
        z=i32 if newest else zero,
    )
    packet = GulliViewPacket(
        seq=draw(u32),
        time_msec=draw(u64),
        detections=tuple(draw(st.lists(detection, max_size=capacity(layout)))),
        average_gap=draw(u64) if newest else 0,
        camera_id=draw(u32) if newest else 0,
    )
    return layout, packet


def test_the_golden_vector() -> None:
    packet = GulliViewPacket(
        0, 123456789, (GulliViewDetection(1, 2, 3, 3.5, 3.44, 4), GulliViewDetection(5, 6, 7, 8.5, 8.99, 9))
    )
    golden = bytes.fromhex(
        "00000001 00000002 00000000 00000000075bcd15 0000000000000000 00000000 00000002"
        "00000001 00000002 00000003 40600000 405c28f6 00000004"
        "00000005 00000006 00000007 41080000 410fd70a 00000009"
    ).ljust(256, b"\0")
    assert pack("gulliview-2023", packet) == golden
    found = unpack("gulliview-2023", golden)
    rounded = [(d.tag_id, d.x, d.y, d.theta, round(d.speed, 6), d.camera_id) for d in found.detections]
    assert rounded == [(1, 2, 3, 3.5, 3.44, 4), (5, 6, 7, 8.5, 8.99, 9)]
    assert (found.seq, found.time_msec) == (0, 123456789)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_receiver_of_the_layout_reads_every_field(layout: GulliViewLayout) -> None:
    header_format, detection_format, most = RECEIVERS[layout]
    assert capacity(layout) == most
    detections = tuple(
        GulliViewDetection(n + 1, 100 + n, 200 + n, 0.5, 0.25, 3, 1_700_000_000_000 + n, 350) for n in range(most)
    )
    data = pack(layout, GulliViewPacket(7, 1_700_000_000_123, detections, average_gap=17, camera_id=2))
    assert len(data) == SIZE
    header = struct.unpack_from(header_format, data)
    unused = {"gulliview-2021": (0,), "gulliview-2025": (17, 2)}.get(layout, (0, 0))
    assert header == (1, 2, 7, 1_700_000_000_123, *unused, most)
    size = struct.calcsize(detection_format)
    offset = struct.calcsize(header_format)
    for index, sent in enumerate(detections):
        expected = {
            "gulliview-2021": (sent.tag_id, sent.x, sent.y, 3),
            "gulliview-2023": (sent.tag_id, sent.x, sent.y, 0.5, 0.25, 3),
            "gulliview-2025a": (sent.tag_id, sent.time_msec, sent.x, sent.y, 0.5, 0.25, 3),
            "gulliview-2025": (sent.tag_id, sent.time_msec, sent.x, sent.y, 350, 0.5, 0.25, 3),
        }[layout]
        assert struct.unpack_from(detection_format, data, offset + index * size) == expected
    assert set(data[offset + most * size :]) <= {0}


def test_a_negative_coordinate_wraps_for_receivers_that_read_unsigned() -> None:
    data = pack("gulliview-2023", GulliViewPacket(0, 0, (GulliViewDetection(4, -350, 10),)))
    assert struct.unpack_from(">III", data, 36) == (4, 2**32 - 350, 10)
    assert unpack("gulliview-2023", data).detections[0].x == -350


@given(packets())
def test_packing_and_unpacking_return_the_packet(made: tuple[GulliViewLayout, GulliViewPacket]) -> None:
    layout, packet = made
    assert unpack(layout, pack(layout, packet)) == packet


@given(layouts, st.binary(min_size=SIZE, max_size=SIZE) | st.binary(max_size=2 * SIZE))
def test_garbage_raises_nothing_but_decode_error(layout: GulliViewLayout, data: bytes) -> None:
    for candidate in (data, struct.pack(">II", 1, 2) + data[8:]):
        with contextlib.suppress(DecodeError):
            unpack(layout, candidate)


@pytest.mark.parametrize(
    ("at", "word", "named"),
    [
        (0, 2, "type is not 1"),
        (4, 1, "subtype is not 2"),
        (32, 10, "10 detections announced, a datagram holds 9"),
        (48, 0x7FC00000, "theta of detection 0 is nan"),
        (52, 0x7F800000, "speed of detection 0 is inf"),
    ],
)
def test_what_is_wrong_is_named(at: int, word: int, named: str) -> None:
    data = bytearray(pack("gulliview-2023", GulliViewPacket(0, 0, (GulliViewDetection(1, 2, 3),))))
    data[at : at + 4] = struct.pack(">I", word)
    with pytest.raises(DecodeError, match=named):
        unpack("gulliview-2023", bytes(data))


@pytest.mark.parametrize("size", [0, 255, 257])
def test_another_length_is_refused(size: int) -> None:
    with pytest.raises(DecodeError, match=f"{size} bytes, a datagram has 256"):
        unpack("gulliview-2025", bytes(size))


@pytest.mark.parametrize(
    ("packet", "named"),
    [
        (GulliViewPacket(2**32, 0, ()), "header: seq 4294967296 does not fit"),
        (GulliViewPacket(0, 0, (GulliViewDetection(1, 2**31, 0),)), "detection 0: x 2147483648 does not fit"),
        (GulliViewPacket(0, 0, (GulliViewDetection(1, 0, 0, speed=1e39),)), "detection 0: speed 1e\\+39 does not fit"),
        (GulliViewPacket(0, 0, (GulliViewDetection(1, 0, 0),) * 7), "7 detections exceed the 6"),
    ],
)
def test_what_does_not_fit_is_named(packet: GulliViewPacket, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        pack("gulliview-2025", packet)


@given(layouts, st.integers(0, 40), u32)
def test_many_detections_share_one_time_in_packets_of_rising_seq(
    layout: GulliViewLayout, count: int, first: int
) -> None:
    detections = [GulliViewDetection(n, n, n) for n in range(count)]
    made = split(layout, first, 99, detections)
    assert [packet.seq for packet in made] == [(first + n) % 2**32 for n in range(len(made))]
    assert {packet.time_msec for packet in made} <= {99}
    assert [detection for packet in made for detection in packet.detections] == detections
    assert len(made) == -(-count // capacity(layout))
    assert all(len(pack(layout, packet)) == SIZE for packet in made)


def test_a_tag_turned_by_hand_in_both_frames() -> None:
    """A tag at 2 m along the room and 1 m across. GulliView's x runs across the room and y along it, clockwise: its x axis
    is the map's +y. A tag that faces along the room (yaw 0) faces GulliView's +y: a quarter turn clockwise from its x."""
    assert to_wire("gulliview-2025", 2.0, 1.0, 0.0) == (1000, 2000, pytest.approx(math.pi / 2))
    # Turned left by a quarter it faces across the room, which is GulliView's x axis.
    assert to_wire("gulliview-2025", 2.0, 1.0, math.pi / 2) == (1000, 2000, pytest.approx(0.0))
    # 2023: the same axes as the map, angles the other way round.
    assert to_wire("gulliview-2023", 2.0, 1.0, 0.3) == (2596, 1298, pytest.approx(-0.3))


@given(
    layouts,
    st.floats(-100, 100),
    st.floats(-100, 100),
    st.floats(-math.pi, math.pi, exclude_min=True),
)
def test_to_the_wire_and_back(layout: GulliViewLayout, x: float, y: float, yaw: float) -> None:
    wire_x, wire_y, theta = to_wire(layout, x, y, yaw)
    back = SE2(*to_map(layout, GulliViewDetection(1, wire_x, wire_y, theta)))
    assert (back.x, back.y) == pytest.approx((x, y), abs=0.51e-3)
    assert abs(wrap_angle(back.yaw - yaw)) < 1e-9


def test_areas_with_negative_coordinates_are_named() -> None:
    lab = small_lab()
    shifted = lab.model_copy(
        update={"areas": (lab.areas[0].model_copy(update={"outline": ((-0.5, 0.0), (1.0, 0.0), (1.0, 2.0))}),)}
    )
    (sentence,) = areas_that_wrap(shifted)
    assert f"{lab.areas[0].id!r} reaches x = -0.5 m:" in sentence
    positive = shifted.areas[0].model_copy(update={"outline": ((0.0, 0.0), (1.0, 0.0), (1.0, 2.0))})
    assert areas_that_wrap(lab.model_copy(update={"areas": (positive,)})) == []
