"""Pictures of single things, ready to be laid over the floor: body by parallax, picture on the roof, soft contact shadow.

A body's corners go through the projection one by one; its roof is looked up ray by ray, so that the lens's distortion holds
inside it too. The roof's picture is blurred beforehand by what one pixel and the sensor's blur gather at that distance, and
then needs one sample per pixel.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from lab.rendering.floor import sample
from lab.rendering.optics import Float64, Optics
from lab.rendering.shapes import Prism, Shape
from lab.rendering.textures import Texture, UInt8, tone

_BODY_SAMPLES = 2
_MARGIN_PX = 4
_PIXEL_VARIANCE = 1.0 / 12.0
"""Variance of a box one pixel wide."""
_SHADOW_DEPTH = 110
_SHADOW_STEP_PX = 4
_SUN = np.array([0.45, -0.89])
"""Where the room's windows are: sides that look there are brighter."""
_SIDE_LIGHT, _SIDE_CONTRAST = 0.62, 0.22
_SHUTTER_STEP_PX, _COARSE_SHUTTER_STEP_PX = 0.7, 1.5
"""How far a thing moves between two samples of its way while the shutter is open; people's edges are soft already."""
_SHUTTER_STEPS = 40
"""Enough for 5 m/s under a 4K camera with the shutter open for 4 ms, 17 px, without ghosts of the edges."""

Window = tuple[int, int, int, int]
"""x0, y0, x1, y1 in pixels, the last two exclusive."""


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """`light` (rows, columns, channels) to add in `window` after what is there was weakened by `passes` (255: not at all);
    and the shadow, which weakens only."""

    window: Window
    light: UInt8
    passes: UInt8
    shadow_window: Window | None
    shadow: UInt8 | None

    def darken(self, canvas: UInt8) -> None:
        """Casts the shadow."""
        if self.shadow_window is not None and self.shadow is not None:
            part = _part(canvas, self.shadow_window)
            cv2.multiply(part, self.shadow, dst=part, scale=1.0 / 255.0)

    def draw(self, canvas: UInt8) -> None:
        part = _part(canvas, self.window)
        cv2.multiply(part, self.passes, dst=part, scale=1.0 / 255.0)
        cv2.add(part, self.light, dst=part)

    def windows(self) -> tuple[Window, ...]:
        return (self.window,) if self.shadow_window is None else (self.window, self.shadow_window)


def _part(canvas: UInt8, window: Window) -> UInt8:
    x0, y0, x1, y1 = window
    return canvas[y0:y1, x0:x1]


class LayerPainter:
    """Draws shapes as one camera sees them. `blur_sigma_px` is the sensor's."""

    def __init__(self, optics: Optics, channels: int, blur_sigma_px: float) -> None:
        self._optics = optics
        self._channels = channels
        self._blur_px = blur_sigma_px
        self._canvas_size = (optics.model.width, optics.model.height)
        self._roofs: dict[int, tuple[Shape, Texture]] = {}

    def paint(self, shape: Shape, poses: Sequence[SE2], light: float) -> Layer | None:
        """The shape, smeared over its poses while the shutter is open; None where it cannot be seen."""
        outlines = [self._projected(shape, pose) for pose in poses]
        present = [pixels for pixels in outlines if pixels is not None]
        if len(present) < len(poses):
            return None  # reaches up to the camera
        window = self._clipped(np.vstack(present))
        if window is None:
            return None
        total: NDArray[np.float32] | UInt8 | None = None
        for pose, pixels in zip(poses, present, strict=True):
            image = self._body(shape, pose, pixels, window)
            if shape.roof is not None:
                image = self._with_roof(shape, shape.roof, pose, image, window)
            if len(poses) == 1:
                total = image
            elif total is None:
                total = image.astype(np.float32)
            else:
                total = total + image.astype(np.float32)
        assert total is not None
        mean = total.astype(np.float32) / len(poses)
        colour = (mean[..., :-1] * light + 0.5).clip(0, 255).astype(np.uint8)
        passes = 255 - np.rint(mean[..., -1:]).astype(np.uint8)
        shadow_window, shadow = self._shadow(shape, poses[len(poses) // 2])
        whole = np.ascontiguousarray(np.broadcast_to(passes, colour.shape))
        return Layer(window, colour, whole, shadow_window, shadow)

    def shutter_poses(
        self, shape: Shape, pose: SE2, linear_mps: float, angular_radps: float, exposure_s: float
    ) -> list[SE2]:
        """The poses on the way while the shutter is open, centred on `pose`; one when it hardly moves."""
        metres = (abs(linear_mps) + abs(angular_radps) * shape.radius_m) * exposure_s
        pixels = metres * self._optics.pixels_per_metre(shape.height_m)
        step_px = _COARSE_SHUTTER_STEP_PX if shape.roof is None else _SHUTTER_STEP_PX
        count = min(_SHUTTER_STEPS, max(1, math.ceil(pixels / step_px)))
        times = [((index + 0.5) / count - 0.5) * exposure_s for index in range(count)]
        return [pose @ SE2.exp(linear_mps * t, 0.0, angular_radps * t) for t in times]

    def _projected(self, shape: Shape, pose: SE2) -> Float64 | None:
        """Pixels of all the shape's corners; None when one is not in front of the camera."""
        corners = shape.corners.copy()
        corners[:, :2] = pose.apply(corners[:, :2])
        return self._optics.project(corners)

    def _clipped(self, pixels: Float64) -> Window | None:
        width, height = self._canvas_size
        low, high = np.floor(pixels.min(axis=0)) - _MARGIN_PX, np.ceil(pixels.max(axis=0)) + _MARGIN_PX + 1
        x0, y0 = max(0, int(low[0])), max(0, int(low[1]))
        x1, y1 = min(width, int(high[0])), min(height, int(high[1]))
        return (x0, y0, x1, y1) if x1 > x0 and y1 > y0 else None

    def _body(self, shape: Shape, pose: SE2, pixels: Float64, window: Window) -> UInt8:
        """Colour times coverage, and coverage, of the prisms."""
        x0, y0, x1, y1 = window
        s = _BODY_SAMPLES
        canvas = np.zeros(((y1 - y0) * s, (x1 - x0) * s, self._channels), dtype=np.uint8)
        fine = np.rint((((pixels - (x0, y0)) + 0.5) * s - 0.5).clip(-1e6, 1e6) * 16.0).astype(np.int32)
        to_thing = pose.inverse()
        camera = to_thing.apply(self._optics.position[:2])
        sun = SE2(0.0, 0.0, to_thing.yaw).apply(_SUN)
        first = 0
        for prism in shape.prisms:
            count = len(prism.bottom)
            below, above = fine[first : first + count], fine[first + count : first + 2 * count]
            first += 2 * count
            if prism.smooth:
                both = np.concatenate((below, above))
                cv2.fillConvexPoly(canvas, cv2.convexHull(both), self._paint_value(prism, _SIDE_LIGHT), shift=4)
            else:
                self._sides(canvas, prism, below, above, camera, sun)
            cv2.fillPoly(canvas, [above], self._paint_value(prism, 1.0), shift=4)
        size = (x1 - x0, y1 - y0)
        # Everything painted is at least 1 bright, so what is not black is covered.
        covered = cv2.threshold(canvas[..., 0], 0, 255, cv2.THRESH_BINARY)[1]
        planes = [cv2.resize(plane, size, interpolation=cv2.INTER_AREA) for plane in (canvas, covered)]
        small = cv2.merge([*cv2.split(planes[0]), planes[1]])
        if self._blur_px > 0:
            small = cv2.GaussianBlur(small, (0, 0), self._blur_px)
        return np.asarray(small, dtype=np.uint8)

    def _paint_value(self, prism: Prism, shade: float) -> tuple[int, ...]:
        return tuple(min(255, max(1, round(part * shade))) for part in tone(prism.colour, self._channels))

    def _sides(
        self,
        canvas: UInt8,
        prism: Prism,
        below: NDArray[np.int32],
        above: NDArray[np.int32],
        camera: Float64,
        sun: Float64,
    ) -> None:
        """The sides that look towards the camera, the farthest first."""
        towards = camera - prism.middles
        facing = np.flatnonzero((prism.normals * towards).sum(axis=1) > 0.0)
        distances = np.hypot(towards[:, 0], towards[:, 1])
        for index in facing[np.argsort(-distances[facing])].tolist():
            start = index * prism.pieces
            stop = start + prism.pieces
            low, high = below[start : stop + 1], above[start : stop + 1]
            if stop == len(below):  # the last side ends at the first corner
                low, high = np.concatenate((low, below[:1])), np.concatenate((high, above[:1]))
            shade = _SIDE_LIGHT + _SIDE_CONTRAST * float(prism.normals[index] @ sun)
            cv2.fillPoly(canvas, [np.concatenate((low, high[::-1]))], self._paint_value(prism, shade), shift=4)

    def _with_roof(self, shape: Shape, roof: Texture, pose: SE2, image: UInt8, window: Window) -> UInt8:
        filtered = self._filtered(shape, roof)
        laid = sample(filtered, self._optics, self._optics.window(*window), pose, shape.height_m)
        passes = np.ascontiguousarray(np.broadcast_to(255 - laid[..., -1:], image.shape))
        return np.asarray(cv2.add(cv2.multiply(image, passes, scale=1.0 / 255.0), laid), dtype=np.uint8)

    def _filtered(self, shape: Shape, roof: Texture) -> Texture:
        known = self._roofs.get(id(shape))
        if known is None:
            sigma_px = math.sqrt(self._blur_px**2 + _PIXEL_VARIANCE)
            known = (shape, roof.prefiltered(sigma_px / self._optics.pixels_per_metre(shape.height_m)))
            self._roofs[id(shape)] = known
        return known[1]

    def _shadow(self, shape: Shape, pose: SE2) -> tuple[Window | None, UInt8 | None]:
        """Soft darkness around where the thing stands, drawn small and enlarged."""
        ground = np.column_stack((pose.apply(shape.shadow), np.zeros(len(shape.shadow))))
        pixels = self._optics.project(ground)
        if pixels is None:
            return None, None
        step, reach = _SHADOW_STEP_PX, 24
        low, high = np.floor(pixels.min(axis=0)) - reach, np.ceil(pixels.max(axis=0)) + reach
        columns, rows = (int(-(-(high[i] - low[i]) // step)) for i in (0, 1))
        width, height = self._canvas_size
        x0, y0 = int(low[0]), int(low[1])
        x1, y1 = x0 + columns * step, y0 + rows * step
        window = (max(0, x0), max(0, y0), min(width, x1), min(height, y1))
        if window[0] >= window[2] or window[1] >= window[3] or columns * rows > 250_000:
            return None, None
        small = np.zeros((rows, columns), dtype=np.uint8)
        cv2.fillPoly(small, [np.rint((pixels - (x0, y0)) / step * 16.0).astype(np.int32)], _SHADOW_DEPTH, shift=4)
        soft = cv2.GaussianBlur(small, (0, 0), 2.0)
        large = np.asarray(
            cv2.resize(soft, (columns * step, rows * step), interpolation=cv2.INTER_LINEAR), dtype=np.uint8
        )
        part = 255 - large[window[1] - y0 : window[3] - y0, window[0] - x0 : window[2] - x0]
        return window, np.ascontiguousarray(np.repeat(part[..., None], self._channels, axis=2))
