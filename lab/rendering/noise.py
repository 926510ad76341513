"""Sensor noise at the price of two passes over the image: a seeded strip of noise, begun somewhere else for every frame."""

import zlib

import cv2
import numpy as np

from lab.rendering.textures import UInt8

_SPARE = 1 << 20
"""How many beginnings there are."""


class SensorNoise:
    """Gaussian noise of `std` grey levels for images of `shape`; nothing when `std` is 0."""

    def __init__(self, shape: tuple[int, ...], std: float, seed: int, camera_id: str) -> None:
        self._shape = shape
        self._size = int(np.prod(shape))
        self._key = (seed, zlib.crc32(camera_id.encode()))
        self._brighter: UInt8 | None = None
        if std > 0:
            rng = np.random.default_rng([*self._key, 0])
            noise = np.rint(rng.standard_normal(self._size + _SPARE, dtype=np.float32) * np.float32(std))
            self._brighter = noise.clip(0, 255).astype(np.uint8)
            self._darker = (-noise).clip(0, 255).astype(np.uint8)

    def add(self, image: UInt8, frame_number: int, out: UInt8) -> None:
        """`image` with the noise of that frame into `out`; the same number gives the same noise."""
        if self._brighter is None:
            np.copyto(out, image)
            return
        start = int(np.random.default_rng([*self._key, 1, frame_number]).integers(_SPARE))
        stop = start + self._size
        cv2.subtract(image, self._darker[start:stop].reshape(self._shape), dst=out)
        cv2.add(out, self._brighter[start:stop].reshape(self._shape), dst=out)
