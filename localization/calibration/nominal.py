"""From the most probable camera to the one that poses are computed with.

The adjustment estimates small corrections of the lens together with the pose. They are *considered*, not applied: everything
that works with a camera takes the lens from the lab description. So the pose is moved to where, with the lens as described, the
image falls on the floor and on the vehicles' tags as it does with the probable pose and lens; tilt and height make up for all but
hundredths of a millimetre of what the lens is off. Applying the corrections would gain no more than that.

What remains is in the covariance. With D the lens correction found (prior P, posterior Q), the pose moved by K D and the lens
left where it was, the error of (pose, lens) is the posterior's plus M D with M = [K; -I], and over rooms D varies with P - Q:
covariance = posterior + M (P - Q) M^T.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geometry import SE3, CameraModel
from localization.calibration.adjustment import perturbed
from localization.calibration_jacobians import calibration_jacobians
from localization.projection import CameraView, PointsAtInfinityError
from protocol.lab import Accuracy

Array = NDArray[np.float64]

_GRID = 7


def nominal_pose(
    pose: SE3,
    lens: CameraModel,
    covariance: Array,
    nominal: CameraModel,
    accuracy: Accuracy,
    heights_m: Sequence[float],
) -> tuple[SE3, Array]:
    """T_map_camera for the lens as described, and its covariance (10, 10) with the lens (the order of
    `CameraExtrinsics.covariance`), from the adjusted `pose`, `lens` and covariance (9, 9); `heights_m` (m) are the planes on
    which the two cameras are to agree."""
    view = CameraView(nominal, pose)
    grid = _grid(nominal)
    slopes: list[Array] = []
    for height_m in heights_m:
        try:
            slopes.append(calibration_jacobians(view, grid, height_m).reshape(-1, 10))
        except PointsAtInfinityError:
            continue  # a camera that looks to the horizon: its floor tags are what it has
    scales = np.zeros((4, 3))
    scales[0, 0], scales[1, 0], scales[2, 1], scales[3, 2] = nominal.fx, nominal.fy, 1.0, 1.0
    found = np.array([lens.fx - nominal.fx, lens.fy - nominal.fy, lens.cx - nominal.cx, lens.cy - nominal.cy])
    follow: Array = np.zeros((6, 4))
    if slopes:
        stacked = np.concatenate(slopes)
        follow = np.linalg.pinv(stacked[:, :6]).astype(np.float64) @ stacked[:, 6:]
    spread = np.zeros((10, 9))
    spread[:6, :6], spread[6:, 6:] = np.eye(6), scales
    prior = np.diag([accuracy.focal**2, accuracy.center_px**2, accuracy.center_px**2])
    learned = scales @ (prior - covariance[6:, 6:]) @ scales.T
    mixed = np.vstack([follow, -np.eye(4)])
    return perturbed(pose, follow @ found), spread @ covariance @ spread.T + mixed @ learned @ mixed.T


def _grid(model: CameraModel) -> Array:
    """Pixels all over the image, shape (N, 2)."""
    across = np.linspace(0.0, model.width - 1.0, _GRID)
    down = np.linspace(0.0, model.height - 1.0, _GRID)
    return np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)
