"""Messages as JSON: round trips, and one error for everything that is not the message it should be."""

import json
from collections.abc import Sequence
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import Struct
from pydantic import BaseModel, ValidationError

from protocol.channels import CHANNELS
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.messages import (
    Command,
    Detection,
    FloorRaster,
    GroundTruth,
    Movement,
    Odometry,
    Reason,
    ReasonCode,
    Status,
    Target,
    TrackedPose,
    TruePose,
    Waypoint,
)

POSE = TrackedPose(
    "wifibot-14", 5, 1.0, 2.0, 0.5, 0.1, 0.0, 0.0, (1.0, 0.0, 0.0, 1.0, 0.0, 1.0), ("cam0", "cam1"), "camp"
)
COMMAND = Command(
    robot="wifibot-14",
    epoch=3,
    sequence=9,
    stamp_ns=5,
    deadline_ns=6,
    movement=Movement.MOVE_TO,
    reason=Reason(code=ReasonCode.ROUTE),
    target=Target(x=1.0, y=2.0),
    speed_mps=0.3,
)
MESSAGES: Sequence[BaseModel | Struct] = (
    POSE,
    COMMAND,
    Waypoint(id="dock", area="camp", x=-1.5, y=2.25, yaw=3.1),
    GroundTruth(5, {"wifibot-14": TruePose(1.0, 2.0, 3.0, 0.0, 0.0)}, 0),
    FloorRaster("cam0", 5, -0.35, -0.3, 0.05, 9, 1, bytes(range(2)), b"\xff\x80"),
    Odometry("wifibot-14", "s1", 5, 1.0, 2.0, 3.0, 0.1, 0.0, 0.9, None),
    Detection("tag36h11", 14, ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)), 55.0, 1.0, 2.0, 0.1, POSE.covariance),
)


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_messages_survive_the_wire(message: BaseModel | Struct) -> None:
    data = encode(message)
    assert decode(type(message), data) == message
    assert decode(type(message), data.decode()) == message


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_an_unknown_field_is_refused_and_named(message: BaseModel | Struct) -> None:
    fields = json.loads(encode(message)) | {"colour": "red"}
    with pytest.raises(DecodeError, match=f"{type(message).__name__}.*colour|colour.*"):
        decode(type(message), json.dumps(fields))


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_each_field_of_another_type_is_refused(message: BaseModel | Struct) -> None:
    fields = json.loads(encode(message))
    for name in fields:
        with pytest.raises(DecodeError, match=f"not a {type(message).__name__}"):
            decode(type(message), json.dumps(fields | {name: {"not": ["this"]}}))


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999", "null", '"1.0"'])
@pytest.mark.parametrize(("message", "name"), [(POSE, "x"), (COMMAND, "speed_mps"), (MESSAGES[2], "x")])
def test_a_number_that_is_none_is_refused(message: BaseModel | Struct, name: str, number: str) -> None:
    fields = json.loads(encode(message)) | {name: "@"}
    with pytest.raises(DecodeError):
        decode(type(message), json.dumps(fields).replace('"@"', number))


@given(st.binary(max_size=100), st.sampled_from(CHANNELS))
def test_garbage_raises_nothing_but_a_decode_error(data: bytes, channel: Any) -> None:
    with pytest.raises(DecodeError, match=channel.message.__name__):
        decode(channel.message, data)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=10,
)


@given(st.sampled_from(MESSAGES), st.data())
def test_damaged_fields_raise_nothing_but_a_decode_error(message: BaseModel | Struct, data: st.DataObject) -> None:
    fields = json.loads(encode(message))
    damaged = fields | {data.draw(st.sampled_from(sorted(fields))): data.draw(json_values)}
    try:
        decode(type(message), json.dumps(damaged))
    except DecodeError as error:
        assert str(error).startswith(f"not a {type(message).__name__}: ")


def test_deeply_nested_garbage_is_refused() -> None:
    for kind in (TrackedPose, Status):
        with pytest.raises(DecodeError):
            decode(kind, b'{"a":' * 50_000)
        with pytest.raises(DecodeError):
            decode(kind, b"[" * 50_000)


@pytest.mark.parametrize(
    "fields",
    [
        {"movement": Movement.MOVE_TO, "target": None},
        {"movement": Movement.ROTATE, "target": None},
        {"movement": Movement.ROTATE, "target": Target(x=0, y=0)},
        {"robot": "Not An Id"},
        {"speed_mps": -0.1},
        {"epoch": -1},
        {"stamp_ns": 2**63},
    ],
)
def test_a_command_that_says_too_little_is_refused(fields: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        Command(**{**COMMAND.model_dump(), **fields})


def test_commands_are_ordered_by_epoch_then_sequence() -> None:
    older_brain = COMMAND.model_copy(update={"epoch": 2, "sequence": 99})
    assert older_brain.order < COMMAND.order < COMMAND.model_copy(update={"sequence": 10}).order
