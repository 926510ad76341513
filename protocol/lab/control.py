"""Settings of a vehicle's path following: key `control` of a vehicle in the lab file. What is left out is the default of the
vehicle's kind (agents/control/settings.py, whose config classes explain every setting and bear the same names)."""

from typing import Annotated, Literal

from pydantic import Field

from protocol.lab.base import LabModel, NonNegative, Positive

ControllerName = Literal["gpss", "go_to_goal", "frenet"]
Angle = Annotated[float, Field(gt=0, le=3.15)]


class GpssControl(LabModel):
    """Of the report's controller; the report's own constants are not for setting."""

    passed_m: Positive | None = None
    face_rad: Angle | None = None


class GoToGoalControl(LabModel):
    """Of the WifiBots' controller."""

    accept_m: Positive | None = None
    gain_per_s: Positive | None = None
    turn_above_rad: Angle | None = None


class FrenetControl(LabModel):
    """Of the path-following controller."""

    corner_cut_m: Positive | None = None
    pivot_above_rad: Angle | None = None
    turn_above_rad: Angle | None = None
    settle_m: Positive | None = None
    settle_s: Positive | None = None
    lead_s: NonNegative | None = None
    braking_mps2: Positive | None = None
    lateral_mps2: Positive | None = None
    approach_per_s: Positive | None = None
    tolerance_m: Positive | None = None
    swivel_s: NonNegative | None = None


class ControlSpec(LabModel):
    """Which controller drives the vehicle (None: the agent's default), and the settings of each that differ from its kind's."""

    controller: ControllerName | None = None
    gpss: GpssControl = GpssControl()
    go_to_goal: GoToGoalControl = GoToGoalControl()
    frenet: FrenetControl = FrenetControl()
