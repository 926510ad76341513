"""Keeps a camera's learned floor across restarts: without it, a pallet in view at the start would be learned as floor.

A file holds for one mounting of the camera and one grid. What does not fit (or is damaged) is left aside with a line in the
log, and the floor is learned anew.
"""

import logging
import zipfile
from pathlib import Path

import numpy as np

from localization.floor.background import Background
from localization.floor.view import FloorView, moved
from protocol.messages import CameraExtrinsics

_logger = logging.getLogger(__name__)
_VERSION = 1


def background_path(state: Path, camera_id: str) -> Path:
    """Where a camera's background is kept; deleting the file while the camera is down makes it learn the floor anew."""
    return state / "floor" / f"{camera_id}.npz"


def save_background(path: Path, background: Background, view: FloorView, extrinsics: CameraExtrinsics) -> None:
    """Writes the file as a whole or not at all; OSError when the disk does not take it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f"{path.name}.new")
    with draft.open("wb") as file:
        np.savez(
            file,
            version=np.array(_VERSION),
            mean=background.mean,
            variance=background.variance,
            count=background.count,
            grid=np.array([view.grid.origin_x, view.grid.origin_y, view.grid.cell_m]),
            rotvec=np.array(extrinsics.rotvec),
            translation=np.array(extrinsics.translation),
        )
    draft.replace(path)


def load_background(
    path: Path, view: FloorView, extrinsics: CameraExtrinsics, shape: tuple[int, ...]
) -> Background | None:
    """The background kept for this view, None when there is none that fits it. `shape` is that of the sampled floor."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as kept:
            arrays = {name: np.asarray(kept[name]) for name in kept.files}
    except FileNotFoundError:
        return None
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile) as error:
        _logger.warning("%s cannot be read, learning the floor anew: %s", path, error)
        return None
    reason = _misfit(arrays, view, extrinsics, shape)
    if reason:
        _logger.warning("%s does not fit (%s), learning the floor anew", path, reason)
        return None
    background = Background(shape)
    background.mean[...] = arrays["mean"]
    background.variance[...] = arrays["variance"]
    background.count[...] = arrays["count"]
    return background


def _misfit(
    arrays: dict[str, np.ndarray], view: FloorView, extrinsics: CameraExtrinsics, shape: tuple[int, ...]
) -> str | None:
    expected = {"mean": shape, "variance": shape, "count": shape[:2], "grid": (3,), "rotvec": (3,), "translation": (3,)}
    if "version" not in arrays or arrays["version"].shape != () or int(arrays["version"]) != _VERSION:
        return "another version"
    for name, wanted in expected.items():
        if name not in arrays or arrays[name].shape != wanted:
            return f"{name} is missing or has another shape"
        if arrays[name].dtype.kind not in "fi" or not np.isfinite(arrays[name]).all():
            return f"{name} has values that are no numbers"
    if not np.allclose(arrays["grid"], (view.grid.origin_x, view.grid.origin_y, view.grid.cell_m), atol=1e-6):
        return "another part of the floor"
    rotvec, translation = (arrays[name].astype(np.float64).tolist() for name in ("rotvec", "translation"))
    before = CameraExtrinsics(extrinsics.camera, 0, tuple(rotvec), tuple(translation), 0.0, ())
    if moved(before, extrinsics):
        return "the camera hangs elsewhere"
    # Above 255 is in order: what was learned at another exposure, or saturates, is kept as it would be without the limit.
    if (arrays["mean"] < 0).any() or (arrays["variance"] < 0).any():
        return "grey levels out of range"
    return None
