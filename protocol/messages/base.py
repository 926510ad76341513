"""Field types and the base of the pydantic messages."""

from typing import Annotated

import msgspec
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError


def _refuse_text(value: object) -> object:
    if type(value) is int:  # nearly always: this is on the way of every status and command
        return value
    if isinstance(value, bool | str | bytes):
        raise PydanticCustomError("int_type", "Input should be a valid integer")
    return value


Identifier = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]
LARGEST = 1e9
"""Of metres, radians, seconds and their quotients: what is beyond is nonsense, and its square might be no number any more."""
_HIGHEST = 9 * 10**18
"""Of whole numbers: fits 63 bits, and JSON's readers can hold it exactly."""
Finite = Annotated[float, Field(strict=True, ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
"""Numbers are strict everywhere, as `protocol.codec` has them: neither "0.3" nor true is one."""
Positive = Annotated[float, Field(strict=True, gt=0, le=LARGEST, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(strict=True, ge=0, le=LARGEST, allow_inf_nan=False)]
NUMERIC = BeforeValidator(_refuse_text)
"""For whole numbers: as JSON has them, 5.0 is one where it comes by HTTP, neither "5" nor true is."""
Counted = Annotated[int, Field(ge=0, lt=_HIGHEST), NUMERIC]
StampNs = Annotated[int, Field(ge=0, lt=_HIGHEST), NUMERIC]
"""Nanoseconds since the epoch, until 2255."""
Flag = Annotated[bool, Field(strict=True)]

PointXY = tuple[Finite, Finite]
"""Metres in the map frame."""


Whole = Annotated[int, msgspec.Meta(ge=-_HIGHEST, le=_HIGHEST)]
Real = Annotated[float, msgspec.Meta(ge=-LARGEST, le=LARGEST)]
"""The same for structs."""


class Message(BaseModel):
    """Base of the low-rate messages: frozen, unknown fields refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)
