"""A first pose of a camera from the floor tags that it sees (PnP), and how well a pose explains them.

Where every adjustment begins; spec localization, "Better than the reports".
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE3, CameraModel

Array = NDArray[np.float64]

MIN_TAGS = 2
"""One tag alone leaves the camera's tilt open by whole degrees, and sometimes flips it."""


class ExtrinsicsError(Exception):
    """The floor tags seen do not give a pose; the text says why."""


def initial_pose(
    model: CameraModel, seen: Mapping[int, Array], expected: Mapping[int, Array], tags: Sequence[int]
) -> SE3:
    """T_map_camera from the corners `seen` (tag id -> (4, 2), pixels) of `tags`, which lie at `expected` (tag id -> (4, 2),
    metres in the map frame); all tags weigh the same. ExtrinsicsError when they are too few or give no pose."""
    if len(tags) < MIN_TAGS:
        raise ExtrinsicsError(f"sees {listed(tags)}, needs {MIN_TAGS} floor tags to find its own place")
    candidates = _candidates(model, *_points(seen, expected, tags))
    if not candidates:
        raise ExtrinsicsError(f"the corners of {listed(tags)} do not give a pose")
    above = [pose for pose in candidates if pose.translation[2] > 0]
    if not above:
        raise ExtrinsicsError(f"{listed(tags)} put the camera below the floor; are their ids and yaws right?")
    return min(above, key=lambda pose: rms_px(model, pose, seen, expected, tags))


def reprojection_px(
    model: CameraModel, T_map_camera: SE3, seen: Mapping[int, Array], expected: Mapping[int, Array]
) -> dict[int, float]:
    """RMS distance in pixels per tag between its corners seen and where the pose wants them."""
    return {tag: rms_px(model, T_map_camera, seen, expected, [tag]) for tag in sorted(set(seen) & set(expected))}


def rms_px(
    model: CameraModel,
    T_map_camera: SE3,
    seen: Mapping[int, Array],
    expected: Mapping[int, Array],
    tags: Iterable[int],
) -> float:
    """RMS distance in pixels between the corners of `tags` seen and expected."""
    floor, image = _points(seen, expected, tags)
    T_camera_map = T_map_camera.inverse()
    projected, _ = cv2.projectPoints(
        floor, T_camera_map.rotvec(), np.array(T_camera_map.translation), model.matrix(), model.distortion_array()
    )
    return float(np.sqrt(np.square(projected.reshape(-1, 2) - image).sum(axis=1).mean()))


def listed(tags: Sequence[int]) -> str:
    """The tags by name, for messages."""
    if not tags:
        return "no floor tag"
    return f"floor tag{'s' if len(tags) > 1 else ''} {', '.join(str(tag) for tag in tags)}"


def _points(seen: Mapping[int, Array], expected: Mapping[int, Array], tags: Iterable[int]) -> tuple[Array, Array]:
    """Corners on the floor (N, 3) and in the image (N, 2)."""
    tags = list(tags)
    floor = np.array(list(chain.from_iterable(expected[tag] for tag in tags)), dtype=np.float64)
    image = np.array(list(chain.from_iterable(seen[tag] for tag in tags)), dtype=np.float64)
    return np.column_stack([floor, np.zeros(len(floor))]), image


def _candidates(model: CameraModel, floor: Array, image: Array) -> list[SE3]:
    """Refined poses T_map_camera: both of IPPE's, and SQPnP's, which also solves what IPPE finds singular."""
    matrix, distortion = model.matrix(), model.distortion_array()
    found: list[SE3] = []
    for method in (cv2.SOLVEPNP_IPPE, cv2.SOLVEPNP_SQPNP):
        try:
            _, rvecs, tvecs, _ = cv2.solvePnPGeneric(floor, image, matrix, distortion, flags=method)
        except cv2.error:
            continue
        for rvec, tvec in zip(rvecs, tvecs, strict=True):
            try:
                refined = cv2.solvePnPRefineLM(floor, image, matrix, distortion, rvec, tvec)
                found.append(SE3.from_rotvec(_vector(refined[0]), _vector(refined[1])).inverse())
            except (cv2.error, ValueError):
                continue  # not finite
    return found


def _vector(value: Any) -> Array:
    return cast("Array", np.asarray(value, dtype=np.float64).reshape(3))
