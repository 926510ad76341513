"""Field types and the base of the pydantic messages."""

from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError


def _refuse_text(value: object) -> object:
    if isinstance(value, bool | str | bytes):
        raise PydanticCustomError("int_type", "Input should be a valid integer")
    return value


Identifier = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]
Finite = Annotated[float, Field(strict=True, allow_inf_nan=False)]
"""Numbers are strict everywhere, as `protocol.codec` has them: neither "0.3" nor true is one."""
Positive = Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False)]
NUMERIC = BeforeValidator(_refuse_text)
"""For whole numbers: as JSON has them, 5.0 is one where it comes by HTTP, neither "5" nor true is."""
StampNs = Annotated[int, Field(ge=0, lt=9 * 10**18), NUMERIC]
"""Nanoseconds since the epoch, until 2255. A limit that JSON's readers can hold, and that fits 63 bits."""
Flag = Annotated[bool, Field(strict=True)]


class Message(BaseModel):
    """Base of the low-rate messages: frozen, unknown fields refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)
