"""How large tags appear to a calibrated camera: what the whole-picture searches are tuned to."""

import numpy as np
from numpy.typing import NDArray

from localization.detection import TagSizes
from localization.detection.observation import side_length
from localization.projection import CameraView, PointsAtInfinityError, undistort
from localization.tags import KnownTags, tag_corners

Array = NDArray[np.float64]

_STEPS = 5
_FARTHEST_HEIGHTS = 3.0
"""A camera that sees the horizon is asked for tags up to this many times its height away."""


def vehicle_tag_sizes(view: CameraView, known: KnownTags) -> list[TagSizes]:
    """The sizes in pixels of every kind of vehicle tag, over the places where the picture may show it; a kind that fits nowhere
    below the camera is left out."""
    kinds = {(vehicle.tag.size_m, vehicle.tag.height_m) for vehicle in known.vehicles.values()}
    found = [_sides(view, size_m, height_m) for size_m, height_m in sorted(kinds)]
    return [TagSizes(min(sides), max(sides)) for sides in found if sides]


def floor_tag_sizes(view: CameraView, known: KnownTags) -> list[TagSizes]:
    """The same of the floor tags, if there are any."""
    sides = _sides(view, known.floor_size_m, 0.0) if known.floor else []
    return [TagSizes(min(sides), max(sides))] if sides else []


def _sides(view: CameraView, size_m: float, height_m: float) -> list[float]:
    """Side lengths (px) of level tags of that size at that height, over a grid of the picture's points."""
    model = view.model
    u, v = np.meshgrid(np.linspace(0, model.width - 1, _STEPS), np.linspace(0, model.height - 1, _STEPS))
    plane = undistort(model, np.column_stack([u.ravel(), v.ravel()]))
    farthest_m = _FARTHEST_HEIGHTS * float(view.T_map_camera.translation[2])
    sides: list[float] = []
    for ray in plane:
        try:
            (centre,) = view.hits(ray[None], height_m).points
        except PointsAtInfinityError:
            continue  # above the horizon
        corners = np.column_stack([centre + tag_corners(size_m), np.full(4, height_m)])
        pixels, meant = view.project(corners)
        if meant.all() and float(view.distance_m(corners).max()) <= farthest_m:
            sides.append(side_length(pixels))
    return sides
