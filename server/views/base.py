"""Base of the views and of request bodies."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from protocol.messages.base import Finite

PointXY = tuple[Finite, Finite]
"""Metres in the map frame."""
Outline = tuple[PointXY, ...]
AgeS = Annotated[float, Field(ge=0, description="Seconds, by the server's clock, when the answer was made.")]


class View(BaseModel):
    """An answer: frozen; every field is always present."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Body(BaseModel):
    """A request: unknown fields are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Problem(BaseModel):
    """Why a request was refused."""

    detail: str = Field(examples=["route 'charge' is being driven by wifibot-14; stop it before it is changed"])


def age_s(stamp_ns: int, now_ns: int) -> float:
    """Never negative (clocks of two machines differ a little), to the millisecond."""
    return max(0, (now_ns - stamp_ns) // 1_000_000) / 1000
