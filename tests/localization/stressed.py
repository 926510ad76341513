"""Pictures as bad as real rooms make them: seeded blur, noise, light, gamma, shadows and JPEG; and clutter without tags."""

import math
from dataclasses import dataclass
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

Grey = NDArray[np.uint8]


@dataclass(frozen=True)
class Stress:
    """What happens to a picture on its way: `gradient` is how much darker its far end is, `shadow` how much of the light is left
    behind a hard edge (1: there is none), `contrast` and `gamma` what the camera makes of it."""

    blur_px: float
    noise: float
    gradient: float
    shadow: float
    contrast: float
    gamma: float
    jpeg: int
    seed: int

    @classmethod
    def draw(cls, seed: int, *, shadow: bool = False) -> "Stress":
        """Any mixture of it all, by the seed."""
        rng = np.random.default_rng([seed, 11])
        return cls(
            blur_px=float(rng.uniform(0.4, 1.3)),
            noise=float(rng.uniform(1.0, 6.0)),
            gradient=float(rng.uniform(0.0, 0.6)),
            shadow=float(rng.uniform(0.35, 0.6)) if shadow else 1.0,
            contrast=float(rng.uniform(0.5, 1.1)),
            gamma=float(rng.uniform(0.6, 1.6)),
            jpeg=int(rng.integers(50, 96)),
            seed=seed,
        )

    def apply(self, image: NDArray[np.float32], through: tuple[float, float] | None = None) -> Grey:
        """The camera's picture of a clean one (height, width); the shadow's edge goes through that pixel."""
        rng = np.random.default_rng([self.seed, 12])
        height, width = image.shape
        u = np.linspace(-0.5, 0.5, width, dtype=np.float32)
        v = np.linspace(-0.5, 0.5, height, dtype=np.float32)[:, None]
        towards = rng.uniform(0, 2 * math.pi)
        along, across = math.cos(towards), math.sin(towards)
        light = 1.0 - self.gradient * np.clip(0.5 + u * along + v * across, 0, 1)
        if through is not None:
            x, y = through
            side = (u * width + width / 2 - x) * along + (v * height + height / 2 - y) * across
            light *= self.shadow + (1 - self.shadow) / (1 + cv2.exp(np.clip(side / -0.8, -60, 60)))
        light *= (0.06 + self.contrast / 255.0 * image).astype(np.float32)
        seen = 255.0 * cv2.pow(np.clip(light, 0.0, 1.0), self.gamma)
        seen = cv2.GaussianBlur(seen, (0, 0), self.blur_px)
        seen += self.noise * rng.standard_normal(seen.shape, dtype=np.float32)
        grey = np.clip(np.rint(seen), 0, 255).astype(np.uint8)
        _, data = cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, self.jpeg])
        return cast("Grey", cv2.imdecode(data, cv2.IMREAD_GRAYSCALE))


def clutter(seed: int, width: int, height: int) -> Grey:
    """A floor full of what is not a tag: boxes, frames, grids, chessboards, lines, text, markers of other families, and tags'
    black borders with noise in them."""
    rng = np.random.default_rng([seed, 13])
    image = np.full((height, width), int(rng.integers(40, 200)), np.uint8)
    for _ in range(int(rng.integers(25, 60))):
        _one(image, rng)
    return Stress.draw(seed).apply(image.astype(np.float32))


def _one(image: Grey, rng: np.random.Generator) -> None:
    height, width = image.shape
    x, y = int(rng.integers(0, width)), int(rng.integers(0, height))
    dark, bright = int(rng.integers(0, 90)), int(rng.integers(130, 256))
    kind = int(rng.integers(0, 7))
    if kind == 0:
        points = rng.integers(-60, 60, (int(rng.integers(3, 6)), 2)) + np.array([x, y])
        cv2.fillPoly(image, [points.astype(np.int32)], dark if rng.random() < 0.5 else bright)
    elif kind == 1:
        box = cv2.boxPoints(((x, y), tuple(rng.uniform(15, 150, 2).tolist()), float(rng.uniform(0, 90))))
        cv2.polylines(image, [box.astype(np.int32)], True, dark, int(rng.integers(2, 14)))
    elif kind == 2:
        cv2.line(image, (x, y), tuple(rng.integers(0, min(width, height), 2).tolist()), bright, int(rng.integers(1, 9)))
    elif kind == 3:
        text = "".join(chr(c) for c in rng.integers(33, 123, 6))
        cv2.putText(
            image, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, float(rng.uniform(0.5, 3)), dark, int(rng.integers(1, 6))
        )
    else:
        _paste(image, _patch(kind, rng, dark, bright), rng, x, y)


def _patch(kind: int, rng: np.random.Generator, dark: int, bright: int) -> Grey:
    """A square pattern of small cells: a chessboard, another family's marker, or a tag's border around random cells."""
    if kind == 4:
        n = int(rng.integers(3, 12))
        cells = (np.indices((n, n)).sum(axis=0) % 2).astype(np.uint8)
    elif kind == 5:
        families = (
            cv2.aruco.DICT_4X4_250,
            cv2.aruco.DICT_5X5_250,
            cv2.aruco.DICT_6X6_250,
            cv2.aruco.DICT_APRILTAG_25h9,
        )
        family = families[int(rng.integers(0, len(families)))]
        marker = cv2.aruco.generateImageMarker(cv2.aruco.getPredefinedDictionary(family), int(rng.integers(0, 35)), 72)
        cells = (cv2.copyMakeBorder(marker, 9, 9, 9, 9, cv2.BORDER_CONSTANT, value=255) > 127).astype(np.uint8)
    else:
        cells = np.ones((10, 10), np.uint8)
        cells[1:9, 1:9] = 0
        cells[2:8, 2:8] = rng.integers(0, 2, (6, 6))
    shades = np.array([dark, bright], np.uint8)[cells]
    finer = max(2, 160 // len(cells))  # its largest side on a picture, in pixels: finer would not be seen
    return cast("Grey", cv2.resize(shades, None, fx=finer, fy=finer, interpolation=cv2.INTER_NEAREST))


def _paste(image: Grey, patch: Grey, rng: np.random.Generator, x: int, y: int) -> None:
    """Turned and in perspective, as a print lies on the floor, with its centre at x, y."""
    size, (height, width) = patch.shape[0], image.shape
    side, angle = float(rng.uniform(20, 160)), float(rng.uniform(0, 2 * math.pi))
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) + rng.uniform(-0.08, 0.08, (4, 2))
    reach = math.ceil(side)
    left, top = max(0, x - reach), max(0, y - reach)
    right, bottom = min(width, x + reach), min(height, y + reach)
    corners = side * square @ turn.T + np.array([x - left, y - top])
    source = np.array([[0, 0], [size, 0], [size, size], [0, size]], np.float32) - 0.5
    warp = cv2.getPerspectiveTransform(source, corners.astype(np.float32))
    below = image[top:bottom, left:right].copy()
    image[top:bottom, left:right] = cv2.warpPerspective(
        patch, warp, below.shape[::-1], dst=below, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_TRANSPARENT
    )
