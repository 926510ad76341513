"""A lens calibrated from a recording of a board that was carried through the picture (Zhang, "A Flexible New Technique for
Camera Calibration", 2000; OpenCV's implementation).

Of the frames those count that show the board sharply and from a place of its own: a video holds the same view many times, and
counting it many times would only make the result look surer than it is.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE3, CameraModel
from localization.calibration.boards import BoardFinder, BoardSpec

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
Progress = Callable[[int, int], None]
"""Called after every frame with the number of frames seen and of views kept."""

PARAMETERS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
MIN_VIEWS = 8
_MOST_VIEWS = 80
_LEAST_CORNERS = 8
_BLURRED_PX = 5.0
"""Edges that take longer to rise are smeared by motion or out of focus."""
_ALIKE = 0.02
"""Views whose corners lie within this share of the image's diagonal of another view's are the same view."""
_OUTLIER = 3.0
_OPEN_FOCAL = 0.01
_TILTED_RAD = 0.17
_LEAST_TILTED = 3
"""Views straight from the front do not tell a longer lens from a greater distance; numerically they seem to."""
_SIGNIFICANT = 3.0
_CELLS = (8, 6)


class IntrinsicsError(Exception):
    """The recording does not give a calibration; the text says why and what to do."""


@dataclass(frozen=True, slots=True, eq=False)
class IntrinsicsEstimate:
    """The lens, with what it rests on. `std` are standard deviations by parameter (PARAMETERS; pixels for the first four),
    `rms_px` the RMS distance of the corners from where the lens wants them, `coverage` the share of the image's cells (8 x 6) in
    which a corner was seen. Of `frames`, `views` were used; `without_board`, `blurred`, `alike` and `outliers` were not."""

    model: CameraModel
    std: dict[str, float]
    rms_px: float
    coverage: float
    frames: int
    views: int
    without_board: int
    blurred: int
    alike: int
    outliers: int


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    ids: NDArray[np.int_]
    pixels: Array


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """RMS, the parameters (9,) and their standard deviations (9,), and by view its RMS and the board's tilt against the image."""

    rms_px: float
    values: Array
    std: Array
    errors_px: Array
    tilts_rad: Array


def calibrate_intrinsics(
    frames: Iterable[NDArray[np.uint8]], board: BoardSpec, progress: Progress | None = None
) -> IntrinsicsEstimate:
    """The lens from frames (grey of shape (height, width), or BGR) that show the board. IntrinsicsError when they do not tell."""
    collection = _Collection(board)
    for number, frame in enumerate(frames, start=1):
        collection.add(frame)
        if progress is not None:
            progress(number, len(collection.views))
    return collection.solved()


class _Collection:
    """The views of a recording that tell something new."""

    def __init__(self, board: BoardSpec) -> None:
        self.views: list[_View] = []
        self._board, self._finder = board, BoardFinder(board)
        self._corners = board.corners()
        self._size: tuple[int, int] | None = None
        self._frames = self._without = self._blurred = self._alike = 0

    def add(self, frame: Image) -> None:
        grey = frame if frame.ndim == 2 else cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY).astype(np.uint8)
        size = (grey.shape[1], grey.shape[0])
        if self._size is None:
            self._size = size
        elif size != self._size:
            raise IntrinsicsError(
                f"frame {self._frames + 1} is {size[0]} x {size[1]}, the ones before {self._size[0]} x {self._size[1]}:"
                " a lens is calibrated at one resolution"
            )
        self._frames += 1
        found = self._finder.find(grey)
        if found is None or len(found[0]) < _LEAST_CORNERS or _on_a_line(self._corners[found[0]]):
            self._without += 1
            return
        view = _View(*found)
        if edge_rise_px(grey, view.pixels) > _BLURRED_PX:
            self._blurred += 1
        elif len(self.views) >= _MOST_VIEWS or any(self._are_alike(view, other) for other in self.views):
            self._alike += 1
        else:
            self.views.append(view)

    def solved(self) -> IntrinsicsEstimate:
        """The lens that explains the views, without those that do not fit the others."""
        self._refuse_too_few(self.views)
        assert self._size is not None
        first = self._fit(self.views, cv2.CALIB_FIX_K3)
        most_px = _OUTLIER * float(np.median(first.errors_px))
        kept = [view for view, error_px in zip(self.views, first.errors_px, strict=True) if error_px <= most_px]
        self._refuse_too_few(kept)
        fit = self._fit(kept, 0)
        if abs(fit.values[8]) < _SIGNIFICANT * fit.std[8]:
            fit = self._fit(kept, cv2.CALIB_FIX_K3)
        values, std = fit.values, fit.std
        if not np.isfinite(values).all() or values[0] <= 0 or values[1] <= 0:
            raise IntrinsicsError("the views contradict each other; is the board flat, and its size right?")
        off = float(max(std[0] / values[0], std[1] / values[1]))
        if off > _OPEN_FOCAL or int((fit.tilts_rad > _TILTED_RAD).sum()) < _LEAST_TILTED:
            raise IntrinsicsError(
                f"the focal length stays open ({int((fit.tilts_rad > _TILTED_RAD).sum())} of {len(kept)} views are tilted):"
                " tilt the board by some 30 degrees, this way and that, and bring it closer"
            )
        fx, fy, cx, cy, k1, k2, p1, p2, k3 = (float(v) for v in values)
        return IntrinsicsEstimate(
            model=CameraModel(*self._size, fx, fy, cx, cy, (k1, k2, p1, p2, k3)),
            std=dict(zip(PARAMETERS, (float(v) for v in std), strict=True)),
            rms_px=fit.rms_px,
            coverage=_coverage(kept, self._size),
            frames=self._frames,
            views=len(kept),
            without_board=self._without,
            blurred=self._blurred,
            alike=self._alike,
            outliers=len(self.views) - len(kept),
        )

    def _refuse_too_few(self, views: list[_View]) -> None:
        if self._frames == 0:
            raise IntrinsicsError("there are no frames")
        if self._without == self._frames:
            raise IntrinsicsError(
                f"none of {self._frames} frames shows a {self._board.kind} of {self._board.size}; its kind or size is another,"
                " or too little of it is in the picture"
            )
        if len(views) < MIN_VIEWS:
            raise IntrinsicsError(
                f"{len(views)} usable views of the board, {MIN_VIEWS} are needed: of {self._frames} frames {self._without} show"
                f" no board, {self._blurred} are blurred, {self._alike} are like others,"
                f" {len(self.views) - len(views)} do not fit; carry the board slowly through the whole picture, tilted"
            )

    def _fit(self, views: list[_View], flags: int) -> _Fit:
        points: Any = [self._corners[view.ids].astype(np.float32) for view in views]
        images: Any = [view.pixels.astype(np.float32) for view in views]
        nothing: Any = None
        assert self._size is not None
        try:
            rms, matrix, distortion, rvecs, _, std, _, errors = cv2.calibrateCameraExtended(
                points, images, self._size, nothing, nothing, flags=flags
            )
        except cv2.error as error:
            raise IntrinsicsError(f"the views give no lens: {error.err}") from None
        return _Fit(
            rms_px=float(rms),
            values=np.concatenate([matrix[(0, 1, 0, 1), (0, 1, 2, 2)], np.asarray(distortion).reshape(-1)[:5]]),
            std=np.asarray(std, dtype=np.float64).reshape(-1)[:9],
            errors_px=np.asarray(errors, dtype=np.float64).reshape(-1),
            tilts_rad=np.array([_tilt_rad(np.asarray(rvec, dtype=np.float64).reshape(3)) for rvec in rvecs]),
        )

    def _are_alike(self, view: _View, other: _View) -> bool:
        assert self._size is not None
        _, here, there = np.intersect1d(view.ids, other.ids, assume_unique=True, return_indices=True)
        if len(here) < min(len(view.ids), len(other.ids)) // 2:
            return False
        moved_px = float(np.linalg.norm(view.pixels[here] - other.pixels[there], axis=1).max())
        return moved_px < _ALIKE * float(np.hypot(*self._size))


def edge_rise_px(grey: Image, pixels: Array) -> float:
    """How many pixels edges near the corners (N, 2) take from black to white: contrast over the steepest slope, median."""
    reach = 7
    rises: list[float] = []
    for u, v in np.rint(pixels).astype(int):
        patch = grey[max(0, v - reach) : v + reach + 1, max(0, u - reach) : u + reach + 1].astype(np.float32)
        slope = np.hypot(cv2.Sobel(patch, cv2.CV_32F, 1, 0), cv2.Sobel(patch, cv2.CV_32F, 0, 1)) / 8.0
        contrast = float(np.percentile(patch, 95) - np.percentile(patch, 5))
        rises.append(contrast / max(1e-3, float(slope.max())))
    return float(np.median(rises))


def _tilt_rad(rotvec: Array) -> float:
    """Angle between the board's normal and the optical axis."""
    return math.acos(min(1.0, abs(float(SE3.from_rotvec(rotvec, np.zeros(3)).rotation[2, 2]))))


def _on_a_line(points: Array) -> bool:
    """Whether the board's corners (N, 3) lie in one row or column, or nearly: they give no pose."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] < 0.05 * spread[0])


def _coverage(views: list[_View], size: tuple[int, int]) -> float:
    pixels = np.concatenate([view.pixels for view in views])
    cells = np.clip((pixels / size * _CELLS).astype(int), 0, np.array(_CELLS) - 1)
    return len({(int(x), int(y)) for x, y in cells}) / (_CELLS[0] * _CELLS[1])
