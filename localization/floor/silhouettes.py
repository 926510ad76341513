"""Which part of the floor the tagged robots cover or hide in a camera's view: they are not obstacles to themselves.

A robot's body lies between its footprint on the floor and the same footprint at the height of its tag. Seen from the camera,
the upper one falls on the floor farther away; the convex hull of both is what the body can cover. Nothing is known of it,
so it counts as not observed by this camera.
"""

import math
from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from localization.floor.view import FloorView
from localization.prediction import pose_at
from protocol.lab import VehicleSpec
from protocol.messages import TrackedPose

MARGIN_M = 0.06
"""Around the hull: errors of pose and calibration, wheels and cables that stick out, the shadow at the robot's foot."""
MAX_POSE_AGE_S = 1.0
"""A robot whose pose is older is an object like any other: nobody knows where it is."""
_AGE_DOUBT = 0.3
"""Share of the way travelled since its pose by which a robot may have ended elsewhere than extrapolated."""
_SUBPIXEL_BITS = 4
_STANDING_MPS = 0.05
_FEWEST_TAG_SAMPLES = 9
_SAME_SHARE = 0.85


def hull_on_floor(vehicle: VehicleSpec, pose: SE2, eye: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convex hull (N, 2), metres, map frame, of the floor that the vehicle's body covers or hides from a camera at `eye`
    (3,). A point at height h falls on the floor at eye + (point - eye) * z / (z - h), z the camera's height."""
    foot = pose.apply(np.array(vehicle.footprint))
    height = min(vehicle.tag.height_m, 0.9 * float(eye[2]))
    top = eye[:2] + (foot - eye[:2]) * float(eye[2]) / (float(eye[2]) - height)
    corners = np.vstack((foot, top)).astype(np.float32)
    return cv2.convexHull(corners).reshape(-1, 2).astype(np.float64)


def robot_mask(
    view: FloorView, robots: Iterable[tuple[VehicleSpec, TrackedPose]], stamp_ns: int, *, margin_m: float = MARGIN_M
) -> NDArray[np.bool_]:
    """The view's samples that a robot may cover or hide at the capture time, margin included; shape as `view.visible`."""
    mask = np.zeros(view.visible.shape, np.uint8)
    for vehicle, pose in robots:
        age_s = abs(stamp_ns - pose.stamp_ns) * 1e-9
        if age_s > MAX_POSE_AGE_S:
            continue
        hull = view.to_fine(hull_on_floor(vehicle, pose_at(pose, stamp_ns), view.eye))
        corners = np.rint(hull * 2**_SUBPIXEL_BITS).astype(np.int32).reshape(-1, 1, 2)
        cv2.fillConvexPoly(mask, corners, 1, cv2.LINE_8, _SUBPIXEL_BITS)
        margin = margin_m + _AGE_DOUBT * math.hypot(pose.vx, pose.vy) * age_s
        thickness = max(1, round(2 * margin / view.fine_m))
        if margin > 0:
            cv2.polylines(mask, [corners], True, 1, thickness, cv2.LINE_8, _SUBPIXEL_BITS)
    return mask.astype(np.bool_)


def looks_like(
    view: FloorView,
    vehicle: VehicleSpec,
    pose: TrackedPose,
    stamp_ns: int,
    known: NDArray[np.bool_],
    difference: NDArray[np.float32],
) -> bool:
    """Whether the place where a standing robot's tag is seen looks like the background does: then the robot was learned with
    it. A tag's black and white cannot match any other floor. `known` and `difference` as in Comparison."""
    if math.hypot(pose.vx, pose.vy) > _STANDING_MPS or abs(stamp_ns - pose.stamp_ns) * 1e-9 > MAX_POSE_AGE_S:
        return False
    half = vehicle.tag.size_m / 2
    square = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    corners = (pose_at(pose, stamp_ns) @ vehicle.tag.pose_on_vehicle()).apply(square)
    eye, height = view.eye, min(vehicle.tag.height_m, 0.9 * float(view.eye[2]))
    on_floor = eye[:2] + (corners - eye[:2]) * float(eye[2]) / (float(eye[2]) - height)
    mask = np.zeros(view.visible.shape, np.uint8)
    fine = np.rint(view.to_fine(on_floor) * 2**_SUBPIXEL_BITS).astype(np.int32).reshape(-1, 1, 2)
    cv2.fillConvexPoly(mask, fine, 1, cv2.LINE_8, _SUBPIXEL_BITS)
    tag = (mask > 0) & known & view.visible
    if np.count_nonzero(tag) < _FEWEST_TAG_SAMPLES:
        return False
    return float(np.mean(difference[tag] <= 1.0)) > _SAME_SHARE
