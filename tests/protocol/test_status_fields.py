"""The quick reading of statuses: the same fields as the model, the same values, and nothing that the model would refuse."""

import random

import msgspec
import pytest

from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.messages import Reason, ReasonCode, Status
from protocol.messages.status_fields import ReasonFields, StatusFields, read_status
from tests.mutations import mutated

FULL = Status(
    robot="wifibot-14",
    sequence=17,
    stamp_ns=1_700_000_000_000_000_000,
    x=1.25,
    y=-2.5,
    yaw=0.25,
    linear_mps=0.3,
    angular_radps=-0.1,
    ip="127.0.0.1",
    area="camp",
    battery=0.83,
    faults=("left wheel", "übel"),
    command_order=(7, 9),
    stopped_by=Reason(code=ReasonCode.EMERGENCY_STOP, text="by hand", since_ns=5),
    pose_age_s=0.05,
    command_age_s=0.1,
    command_loss=0.0,
    stop_epoch=12,
)
LEAST = Status(robot="a", sequence=0, stamp_ns=0, linear_mps=0.0, angular_radps=0.0)


def test_the_fields_are_the_models() -> None:
    for fields, model in ((StatusFields, Status), (ReasonFields, Reason)):
        assert {field.name for field in msgspec.structs.fields(fields)} == set(model.model_fields)
        required = {field.name for field in msgspec.structs.fields(fields) if field.required}
        assert required == {name for name, field in model.model_fields.items() if field.is_required()}


@pytest.mark.parametrize("status", [FULL, LEAST])
def test_what_is_read_is_what_was_said(status: Status) -> None:
    fields = read_status(encode(status))
    assert fields is not None
    assert decode(Status, encode(fields)) == status
    assert read_status(status.model_dump_json(exclude_defaults=True).encode()) == fields


@pytest.mark.parametrize(
    "wrong",
    [
        *('"robot":"Wifibot"', '"robot":"a\\n"', '"robot":""', '"sequence":-1', '"sequence":1.0'),
        '"stamp_ns":9000000000000000000',
        *('"x":1.1e9', '"linear_mps":null', '"battery":1.1', '"mode":"auto"', '"command_order":[1]', '"command_order":[1,-1]'),
        *('"stopped_by":{"code":"tired"}', '"stopped_by":{}', '"pose_age_s":-0.1', '"command_loss":true', '"more":1'),
    ],
)  # fmt: skip
def test_what_the_model_refuses_is_not_taken(wrong: str) -> None:
    data = encode(LEAST)[:-1] + b"," + wrong.encode() + b"}"
    with pytest.raises(DecodeError):
        decode(Status, data)
    assert read_status(data) is None


def test_of_mutated_statuses_nothing_is_taken_that_the_model_refuses() -> None:
    rng, taken = random.Random(5), 0
    for number in range(3000):
        data = mutated(encode((FULL, LEAST)[number % 2]), rng)
        fields = read_status(data)
        if fields is not None:
            taken += 1
            assert decode(Status, data) == decode(Status, encode(fields)), data
    assert taken > 50
