"""Poses of 2023 and 2024: the undistorted picture is a map of the floor (spec localization, eq. 3.8 and 3.9: pixels by a scale).

Here the scale, turn and place of each camera's picture come from its floor tags' centres by a homography, the best that a map
of the plane can do. A vehicle's tag is 0.35 m above that plane, so its parallax stays in the pose, which is what made the
published error half a metre.
"""

import math
from collections.abc import Mapping
from typing import cast

import cv2
import numpy as np

from geometry import SE2
from protocol.lab import FloorTags
from tests.bench.baselines.detector import Array


class FloorPlane:
    """From undistorted pixels to metres on the floor. ValueError with fewer than four floor tags."""

    def __init__(self, seen: Mapping[int, Array], described: FloorTags) -> None:
        both = sorted(set(seen) & set(described.poses))
        if len(both) < 4:
            raise ValueError(f"sees {len(both)} floor tags, a homography needs 4")
        pixels = np.array([seen[tag].mean(axis=0) for tag in both])
        places = np.array([described.poses[tag][:2] for tag in both])
        self._homography = cast("Array", cv2.findHomography(pixels, places)[0])

    def pose(self, corners: Array) -> SE2:
        """T_map_tag of a tag with these corners (4, 2), as if it lay on the floor."""
        on_floor = cv2.perspectiveTransform(corners.reshape(-1, 1, 2), self._homography).reshape(-1, 2)
        x, y = on_floor.mean(axis=0)
        along = on_floor[1] - on_floor[0] + on_floor[2] - on_floor[3]
        return SE2(float(x), float(y), math.atan2(float(along[1]), float(along[0])))
