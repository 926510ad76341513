"""Which tags exist and what their corners are: the lab description seen by the detector (spec localization, "The room").

A tag's frame has its origin at the tag's centre, x from the left-bottom to the right-bottom corner as AprilTag's own
library names them, y from there to the top, z out of the print (design, "The lab description").
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from protocol.lab import Lab, VehicleSpec

TagKey = tuple[str, int]
"""Family and id: what a tag says of itself."""

_UNIT_CORNERS = np.array([[0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]])
"""OpenCV's ArUco begins at what AprilTag calls right-bottom and goes on clockwise as seen in the image."""


def tag_corners(size_m: float) -> NDArray[np.float64]:
    """The corners of a tag in its own frame, metres, shape (4, 2), in the order in which detections have them."""
    return _UNIT_CORNERS * size_m


@dataclass(frozen=True, slots=True)
class KnownTags:
    """The tags of a lab: where the floor tags lie (T_map_tag) and which vehicle wears which tag."""

    floor: dict[TagKey, SE2]
    floor_size_m: float
    vehicles: dict[TagKey, VehicleSpec]

    @classmethod
    def of(cls, lab: Lab) -> Self:
        family = lab.floor_tags.family
        return cls(
            floor={(family, tag_id): SE2(*pose) for tag_id, pose in lab.floor_tags.poses.items()},
            floor_size_m=lab.floor_tags.size_m,
            vehicles={(vehicle.tag.family, vehicle.tag.id): vehicle for vehicle in lab.vehicles},
        )

    def keys(self) -> frozenset[TagKey]:
        """Every tag that may be believed when it is read."""
        return frozenset(self.floor) | frozenset(self.vehicles)

    def families(self) -> tuple[str, ...]:
        """The families to look for."""
        return tuple(sorted({family for family, _ in self.keys()}))

    def floor_corners(self, key: TagKey) -> NDArray[np.float64]:
        """The corners of a floor tag in the map frame, metres, shape (4, 2)."""
        return self.floor[key].apply(tag_corners(self.floor_size_m))
