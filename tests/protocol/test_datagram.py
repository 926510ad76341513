"""The datagram: golden bytes, round trips, and everything that must be refused."""

import contextlib
import hmac
import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import Struct
from pydantic import BaseModel

from protocol.datagram import (
    MAX_PAYLOAD,
    Datagram,
    Kind,
    ReplayGuard,
    Sequencer,
    Verdict,
    pack,
    unpack,
)
from protocol.errors import DecodeError
from protocol.messages import DriveSetpoint, EmergencyStop, Odometry, Registration, Scan, Status, TrackedPose

finite = st.floats(-1e9, 1e9)
u64 = st.integers(0, 2**64 - 1)
names = st.from_regex(r"[a-z0-9][a-z0-9_-]{0,31}", fullmatch=True)
stamps = st.integers(0, 9 * 10**18 - 1)
poses = st.builds(
    TrackedPose,
    vehicle=names,
    stamp_ns=stamps,
    x=finite,
    y=finite,
    yaw=finite,
    vx=finite,
    vy=finite,
    yaw_rate=finite,
    covariance=st.tuples(*(finite,) * 6),
    cameras=st.lists(names, max_size=4).map(tuple),
    area=st.none() | names,
)
statuses = st.builds(
    Status,
    robot=names,
    sequence=st.integers(0, 2**53),
    stamp_ns=stamps,
    x=st.none() | finite,
    y=st.none() | finite,
    yaw=st.none() | finite,
    linear_mps=finite,
    angular_radps=finite,
    battery=st.none() | st.floats(0, 1),
    faults=st.lists(st.text(max_size=20), max_size=3).map(tuple),
)
drives = st.builds(DriveSetpoint, vehicle=names, sequence=stamps, linear_mps=finite, angular_radps=finite)
odometries = st.builds(
    Odometry,
    vehicle=names,
    session=st.text(max_size=16),
    stamp_ns=stamps,
    x=finite,
    y=finite,
    yaw=finite,
    linear_mps=finite,
    angular_radps=finite,
    battery=st.floats(0, 1),
    range_front_m=st.none() | finite,
)
scans = st.builds(
    Scan, vehicle=names, stamp_ns=stamps, angle_min=finite, angle_increment=finite, ranges_mm=st.binary(max_size=800)
)
stops = st.builds(
    EmergencyStop,
    engaged=st.booleans(),
    epoch=st.integers(0, 2**53),
    stamp_ns=stamps,
    by=st.text(max_size=32),
    reason=st.text(max_size=100),
)
datagrams = st.builds(Datagram, names, u64, u64, st.one_of(poses, statuses, drives, odometries, scans, stops))
keys = st.none() | st.binary(min_size=1, max_size=64)

DRIVE = Datagram(
    "wifibot-14", 1_700_000_000_000_001, 1_700_000_000_000_000_500, DriveSetpoint("wifibot-14", 7, 0.25, -0.5)
)
PAYLOAD = b'{"vehicle":"wifibot-14","sequence":7,"linear_mps":0.25,"angular_radps":-0.5}'
UNSIGNED = bytes.fromhex("4c50 01 03 00 0a 00060a24181e4001 17979cfe362a01f4 004c") + b"wifibot-14" + PAYLOAD
SIGNATURE = bytes.fromhex("3e4a03529f32bfaa04ee23728a3ec2fd8a51aff67cfbc318a3b2c51b0c7edc2e")


def test_golden_bytes() -> None:
    assert pack(DRIVE) == UNSIGNED
    assert unpack(UNSIGNED) == DRIVE


def test_golden_bytes_with_signature() -> None:
    signed = UNSIGNED[:4] + b"\x01" + UNSIGNED[5:] + SIGNATURE
    assert pack(DRIVE, b"a key of the lab") == signed
    assert unpack(signed, b"a key of the lab") == DRIVE


@given(datagrams, st.binary(min_size=1, max_size=200))
def test_signatures_are_those_of_the_standard_library(datagram: Datagram, key: bytes) -> None:
    with contextlib.suppress(ValueError):  # too long
        data = pack(datagram, key)
        assert data[-32:] == hmac.digest(key, data[:-32], "sha256")


@given(datagrams, keys)
def test_every_kind_survives_the_wire(datagram: Datagram, key: bytes | None) -> None:
    try:
        data = pack(datagram, key)
    except ValueError:
        assert isinstance(datagram.message, Status | TrackedPose)  # the only ones with room for 1400 bytes
        return
    assert unpack(data, key) == datagram


@given(st.binary(max_size=200), keys)
def test_garbage_is_refused(data: bytes, key: bytes | None) -> None:
    with pytest.raises(DecodeError):
        unpack(data, key)


@given(st.binary(max_size=200))
def test_garbage_behind_a_right_header_is_refused(payload: bytes) -> None:
    header = UNSIGNED[:22] + len(payload).to_bytes(2, "big") + b"wifibot-14"
    with pytest.raises(DecodeError):
        unpack(header + payload)


@given(datagrams, keys, st.data())
def test_a_cut_off_or_lengthened_datagram_is_refused(
    datagram: Datagram, key: bytes | None, data: st.DataObject
) -> None:
    try:
        whole = pack(datagram, key)
    except ValueError:
        return
    size = data.draw(st.integers(0, len(whole) - 1))
    for wrong in (whole[:size], whole + b"\0"):
        with pytest.raises(DecodeError):
            unpack(wrong, key)


@given(datagrams, st.data())
def test_no_flipped_bit_passes_the_signature(datagram: Datagram, data: st.DataObject) -> None:
    key = b"a key of the lab"
    try:
        whole = bytearray(pack(datagram, key))
    except ValueError:
        return
    bit = data.draw(st.integers(0, 8 * len(whole) - 1))
    whole[bit // 8] ^= 1 << bit % 8
    with pytest.raises(DecodeError):
        unpack(bytes(whole), key)


@given(st.integers(0, 8 * len(UNSIGNED) - 1))
def test_a_flipped_bit_without_signature_is_another_message_or_refused(bit: int) -> None:
    damaged = bytearray(UNSIGNED)
    damaged[bit // 8] ^= 1 << bit % 8
    with contextlib.suppress(DecodeError):
        assert unpack(bytes(damaged)) != DRIVE


def test_forged_and_unsigned_ones_are_refused_where_a_key_is_set() -> None:
    with pytest.raises(DecodeError, match="not signed"):
        unpack(pack(DRIVE), b"right")
    with pytest.raises(DecodeError, match="signature"):
        unpack(pack(DRIVE, b"wrong"), b"right")
    assert unpack(pack(DRIVE, b"right"), None) == DRIVE


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (UNSIGNED[:10], "shorter than its header"),
        (b"XX" + UNSIGNED[2:], "begins with b'XX'"),
        (UNSIGNED[:2] + b"\x02" + UNSIGNED[3:], "version 2"),
        (UNSIGNED[:3] + b"\x09" + UNSIGNED[4:], "kind 9"),
        (UNSIGNED[:4] + b"\x80" + UNSIGNED[5:], "flags 0x80"),
        (UNSIGNED[:5] + b"\x09" + UNSIGNED[6:-1], "Drive"),
        (UNSIGNED[:24] + b"\xff" + UNSIGNED[25:], "UTF-8"),
        (UNSIGNED[:5] + b"\x00" + UNSIGNED[6:24] + UNSIGNED[34:], "without a sender"),
        (UNSIGNED.replace(b"0.25", b"null"), "DriveSetpoint"),
        (UNSIGNED[:3] + b"\x01" + UNSIGNED[4:], "TrackedPose"),
    ],
)
def test_the_error_says_what_is_wrong(data: bytes, words: str) -> None:
    with pytest.raises(DecodeError) as caught:
        unpack(data)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("datagram", "words"),
    [
        (Datagram("", 1, 1, DRIVE.message), "1 to 32 bytes"),
        (Datagram("ä" * 17, 1, 1, DRIVE.message), "34"),
        (Datagram("a", 1, 1, Registration(robot="a", host="h", udp_port=1)), "Registration does not travel"),
        (Datagram("a", 1, 1, DriveSetpoint("x" * MAX_PAYLOAD, 1, 0, 0)), "exceed"),
        (Datagram("a", -1, 1, DRIVE.message), "sequence"),
        (Datagram("a", 1, 2**64, DRIVE.message), "stamp"),
    ],
)
def test_what_does_not_fit_is_not_packed(datagram: Datagram, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        pack(datagram)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_set_point_that_is_no_number_does_not_arrive(value: float) -> None:
    with pytest.raises(DecodeError, match="linear_mps"):
        unpack(pack(Datagram("a", 1, 1, DriveSetpoint("wifibot-14", 1, value, 0.0))))


@given(st.sampled_from(Kind), st.dictionaries(st.text(max_size=8), st.integers() | st.none() | st.text(), max_size=5))
def test_any_other_json_is_refused(kind: Kind, value: dict[str, Any]) -> None:
    payload = json.dumps(value).encode()
    head = UNSIGNED[:3] + bytes([kind]) + UNSIGNED[4:22] + len(payload).to_bytes(2, "big") + b"wifibot-14"
    with pytest.raises(DecodeError):
        unpack(head + payload)


def datagram(sequence: int, stamp_ns: int = 0, sender: str = "wifibot-14") -> Datagram:
    message: BaseModel | Struct = DRIVE.message
    return Datagram(sender, sequence, stamp_ns, message)


NOW = 10_000_000_000


@pytest.mark.parametrize(
    ("age_ns", "verdict"),
    [
        (0, Verdict.FRESH),
        (1_000_000_000, Verdict.FRESH),
        (1_000_000_001, Verdict.OLD),
        (-500_000_000, Verdict.FRESH),
        (-500_000_001, Verdict.FUTURE),
        (10**18, Verdict.OLD),
        (-(10**18), Verdict.FUTURE),
    ],
)
def test_the_guard_judges_the_age(age_ns: int, verdict: Verdict) -> None:
    guard = ReplayGuard(max_age_s=1.0, max_ahead_s=0.5)
    assert guard.check(datagram(1, NOW - age_ns), NOW) is verdict
    assert guard.counts[verdict] == 1


def test_the_guard_lets_each_datagram_through_once_and_in_order() -> None:
    guard = ReplayGuard()
    verdicts = [guard.check(datagram(sequence, NOW), NOW) for sequence in (5, 5, 7, 6, 7, 8)]
    assert verdicts == [
        Verdict.FRESH,
        Verdict.DUPLICATE,
        Verdict.FRESH,
        Verdict.OUT_OF_ORDER,
        Verdict.DUPLICATE,
        Verdict.FRESH,
    ]


def test_the_guard_keeps_senders_apart_and_can_forget_one() -> None:
    guard = ReplayGuard()
    assert guard.check(datagram(9, NOW, "a"), NOW) is Verdict.FRESH
    assert guard.check(datagram(3, NOW, "b"), NOW) is Verdict.FRESH
    guard.forget("a")
    guard.forget("never heard of")
    assert guard.check(datagram(1, NOW, "a"), NOW) is Verdict.FRESH
    assert guard.check(datagram(3, NOW, "b"), NOW) is Verdict.DUPLICATE


def test_a_refused_datagram_does_not_move_the_sequence_on() -> None:
    guard = ReplayGuard()
    assert guard.check(datagram(100, NOW + 10**12), NOW) is Verdict.FUTURE
    assert guard.check(datagram(1, NOW), NOW) is Verdict.FRESH


@given(st.lists(st.integers(0, 30), max_size=60))
def test_what_passes_the_guard_is_strictly_increasing(sequences: list[int]) -> None:
    guard = ReplayGuard()
    passed = [s for s in sequences if guard.check(datagram(s, NOW), NOW) is Verdict.FRESH]
    assert passed == sorted(set(passed))
    assert sum(guard.counts.values()) == len(sequences)
    assert passed[-1:] == ([max(sequences)] if sequences else [])


def test_a_restarted_sender_goes_on_above_its_old_numbers() -> None:
    before = Sequencer(NOW)
    numbers = [before.next() for _ in range(1000)]
    assert numbers == list(range(NOW // 1000, NOW // 1000 + 1000))
    assert Sequencer(NOW + 1_000_000_000).next() > numbers[-1]
