"""Where a camera hangs, from the floor tags that it sees: one pose from all their corners, robust and refined.

Spec localization, "Better than the reports". A tag that was measured or glued wrongly is left out when the others agree
without it; the error that remains is reported.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE3, CameraModel

Array = NDArray[np.float64]

MIN_TAGS = 2
"""One tag alone leaves the camera's tilt open by whole degrees, and sometimes flips it."""
_WORTH_A_LOOK_M = 0.002
_OUTLIER_M = 0.010
"""A floor tag further than this from where the others want it is wrong, not just measured by hand."""
_OUTLIER_GAIN = 0.5
"""Leaving an outlier out must at least halve the error of the rest."""


class ExtrinsicsError(Exception):
    """The floor tags seen do not give a pose; the text says why."""


@dataclass(frozen=True, slots=True)
class ExtrinsicsEstimate:
    """T_map_camera with the RMS distance in pixels between the corners seen and the corners expected, over the tags used."""

    T_map_camera: SE3
    reprojection_px: float
    used: tuple[int, ...]
    rejected: tuple[int, ...]


def estimate_extrinsics(
    model: CameraModel, seen: Mapping[int, Array], expected: Mapping[int, Array], size_m: float
) -> ExtrinsicsEstimate:
    """The camera's pose from corners `seen` (tag id -> (4, 2), pixels) of tags `expected` on the floor (tag id -> (4, 2),
    metres in the map frame). ExtrinsicsError when fewer than MIN_TAGS are seen or they do not give a pose."""
    used = sorted(set(seen) & set(expected))
    rejected: list[int] = []
    pose, error = _solve(model, seen, expected, used)
    px_per_m = float(np.mean([_side_px(seen[tag]) for tag in used])) / size_m
    while len(used) > MIN_TAGS and error > _WORTH_A_LOOK_M * px_per_m:
        without = _without_worst(model, seen, expected, used)
        if without is None:
            break
        best_pose, best_error, worst = without
        off_px = float(_residuals(model, best_pose, seen, expected, [worst]).mean())
        if off_px < _OUTLIER_M * px_per_m or best_error > _OUTLIER_GAIN * error:
            break
        used.remove(worst)
        rejected.append(worst)
        pose, error = best_pose, best_error
    return ExtrinsicsEstimate(pose, error, tuple(used), tuple(sorted(rejected)))


def reprojection_px(
    model: CameraModel, T_map_camera: SE3, seen: Mapping[int, Array], expected: Mapping[int, Array]
) -> dict[int, float]:
    """RMS distance in pixels per tag between its corners seen and where the pose wants them."""
    return {
        tag: float(np.sqrt(np.square(_residuals(model, T_map_camera, seen, expected, [tag])).mean()))
        for tag in sorted(set(seen) & set(expected))
    }


def _without_worst(
    model: CameraModel, seen: Mapping[int, Array], expected: Mapping[int, Array], used: list[int]
) -> tuple[SE3, float, int] | None:
    """Pose and error without the tag whose absence helps the most, and that tag."""
    candidates: list[tuple[SE3, float, int]] = []
    for tag in used:
        try:
            candidates.append((*_solve(model, seen, expected, [other for other in used if other != tag]), tag))
        except ExtrinsicsError:
            continue  # these alone give no pose
    return min(candidates, key=lambda candidate: candidate[1]) if candidates else None


def _side_px(corners: Array) -> float:
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).mean())


def _points(seen: Mapping[int, Array], expected: Mapping[int, Array], tags: Iterable[int]) -> tuple[Array, Array]:
    """Corners on the floor (N, 3) and in the image (N, 2)."""
    tags = list(tags)
    floor = np.array(list(chain.from_iterable(expected[tag] for tag in tags)), dtype=np.float64)
    image = np.array(list(chain.from_iterable(seen[tag] for tag in tags)), dtype=np.float64)
    return np.column_stack([floor, np.zeros(len(floor))]), image


def _solve(
    model: CameraModel, seen: Mapping[int, Array], expected: Mapping[int, Array], tags: list[int]
) -> tuple[SE3, float]:
    if len(tags) < MIN_TAGS:
        raise ExtrinsicsError(f"sees {_listed(tags)}, needs {MIN_TAGS} floor tags to find its own place")
    candidates = _candidates(model, *_points(seen, expected, tags))
    if not candidates:
        raise ExtrinsicsError(f"the corners of {_listed(tags)} do not give a pose")
    above = [pose for pose in candidates if pose.translation[2] > 0]
    if not above:
        raise ExtrinsicsError(f"{_listed(tags)} put the camera below the floor; are their ids and yaws right?")
    scored = [(pose, _rms(_residuals(model, pose, seen, expected, tags))) for pose in above]
    return min(scored, key=lambda item: item[1])


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


def _residuals(
    model: CameraModel, T_map_camera: SE3, seen: Mapping[int, Array], expected: Mapping[int, Array], tags: list[int]
) -> Array:
    """Distance in pixels of every corner, shape (N,)."""
    floor, image = _points(seen, expected, tags)
    T_camera_map = T_map_camera.inverse()
    projected, _ = cv2.projectPoints(
        floor, T_camera_map.rotvec(), np.array(T_camera_map.translation), model.matrix(), model.distortion_array()
    )
    return cast("Array", np.linalg.norm(projected.reshape(-1, 2) - image, axis=1))


def _rms(distances: Array) -> float:
    return float(np.sqrt(np.square(distances).mean()))


def _vector(value: Any) -> Array:
    return np.asarray(value, dtype=np.float64).reshape(3)


def _listed(tags: list[int]) -> str:
    if not tags:
        return "no floor tag"
    return f"floor tag{'s' if len(tags) > 1 else ''} {', '.join(str(tag) for tag in tags)}"
