"""Types that the lab description's models share: identifiers, bounded numbers, outlines."""

import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field
from shapely.geometry import Polygon

Identifier = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]
"""Lower-case letters, digits, dashes and underscores: safe in URLs, Redis keys and file names."""
Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
PointXY = tuple[Finite, Finite]
PoseXYYaw = tuple[Finite, Finite, Finite]
Outline = Annotated[tuple[PointXY, ...], Field(min_length=3)]
Family = Literal["tag36h11"]


class LabModel(BaseModel):
    """Base of everything in the lab file: frozen, unknown keys refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def require_simple(outline: tuple[PointXY, ...], what: str) -> None:
    """Raises ValueError unless the outline is a simple polygon with an inside."""
    polygon = Polygon(outline)
    if not polygon.is_valid or polygon.area <= 0 or math.isnan(polygon.area):
        raise ValueError(f"{what} is not a simple polygon with an inside")
