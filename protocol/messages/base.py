"""Field types and the base of the pydantic messages."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Identifier = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
StampNs = Annotated[int, Field(ge=0, lt=2**63)]
PointXY = tuple[Finite, Finite]
"""Metres in the map frame."""


class Message(BaseModel):
    """Base of the low-rate messages: frozen, unknown fields refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)
