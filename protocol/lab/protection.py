"""What keeps a vehicle from touching anything by itself: its safety scanner, the fields around it, its battery's limits."""

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

from protocol.lab.base import LabModel, NonNegative, PoseXYYaw, Positive

MOST_BEAMS = 400
"""A scan of so many beams still fits a datagram."""
_FARTHEST_M = 65.0
"""Ranges travel as whole millimetres in 16 bits."""


class ScannerSpec(LabModel):
    """A 2D safety scanner. `pose` is its x, y (m) and yaw (rad) seen from the rotation centre; its `beams` lie evenly over
    `field_rad` around that yaw, both borders included unless it looks all around. It measures from `range_min_m` to
    `range_m`, `rate_hz` times a second."""

    pose: PoseXYYaw = (0.0, 0.0, 0.0)
    field_rad: Annotated[float, Field(gt=0, le=2 * math.pi + 1e-3)] = 1.5 * math.pi
    beams: Annotated[int, Field(ge=2, le=MOST_BEAMS)] = 271
    range_min_m: NonNegative = 0.02
    range_m: Annotated[float, Field(gt=0, le=_FARTHEST_M)] = 4.0
    rate_hz: Annotated[float, Field(gt=0, le=50)] = 33.0

    @model_validator(mode="after")
    def _measures_something(self) -> Self:
        if self.range_min_m >= self.range_m:
            raise ValueError(f"range_min_m {self.range_min_m:g} leaves nothing below range_m {self.range_m:g}")
        return self

    @property
    def angle_min_rad(self) -> float:
        """Of the first beam, counter-clockwise from the scanner's own x axis."""
        return -self.field_rad / 2

    @property
    def angle_increment_rad(self) -> float:
        all_around = self.field_rad > 2 * math.pi - 1e-3
        return self.field_rad / (self.beams if all_around else self.beams - 1)


class ProtectiveFieldSpec(LabModel):
    """The fields that the agent watches where a vehicle has a scanner (agents/protection).

    - `margin_m`: what must remain free around everything that the outline sweeps until it stands.
    - `reaction_s`: from an echo to the beginning of braking: a turn of the scanner, transport, the motors' delay; on ROS 2
      the agent adds a round of its control loop (50 ms).
    - `clear_s`: how long the protective field must have been clear before the robot moves again.
    - `warning_s`, `warning_margin_m`: the warning field reaches as much farther as the robot drives in this time, and keeps so
      much free around it.
    - `slow_mps`: the speed of the outline's fastest point while anything is in the warning field.
    - `neighbours`: so many neighbouring beams with echoes side by side are a thing at once; fewer are one when the next turn
      of the scanner shows them again.
    """

    margin_m: NonNegative = 0.08
    reaction_s: NonNegative = 0.15
    clear_s: NonNegative = 1.0
    warning_s: NonNegative = 1.0
    warning_margin_m: NonNegative = 0.2
    slow_mps: Positive = 0.12
    neighbours: Annotated[int, Field(ge=1, le=20)] = 3


class BatterySpec(LabModel):
    """Shares of a full charge: below `low` people are warned, below `empty` the robot stands still."""

    low: Annotated[float, Field(ge=0, le=1)] = 0.2
    empty: Annotated[float, Field(ge=0, le=1)] = 0.05

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.empty > self.low:
            raise ValueError(f"empty {self.empty:g} is above low {self.low:g}")
        return self
