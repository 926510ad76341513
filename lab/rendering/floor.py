"""What never moves, rendered once per camera: rubber mat, concrete around it, paint, floor tags.

Every edge is the average over sub-samples of each pixel, with the lens's distortion at every sub-sample, then blurred as the
sensor does: a tag's corners lie where the projection puts them within hundredths of a pixel.
"""

import zlib

import cv2
import numpy as np
from numpy.typing import NDArray
from shapely import Polygon, segmentize

from geometry import SE2
from lab.rendering.markings import painted_outlines
from lab.rendering.optics import Float32, Optics
from lab.rendering.textures import PLATE_BITS, TAG_BITS, Colour, Texture, UInt8, tag_texture, tone
from lab.truth import true_floor_tags
from protocol.lab import Lab

_MAT: Colour = (40, 39, 38)
_CONCRETE: Colour = (122, 124, 126)
_PAINT: Colour = (196, 202, 204)
_TAG_SAMPLES = 8
"""Sub-samples per pixel in x and in y where a floor tag lies."""
_SHAPE_SAMPLES = 4
_GRAIN_TEXELS = 512
_GRAIN_TEXEL_M = 0.004


def light_at(lab: Lab, x: NDArray[np.floating] | float) -> NDArray[np.floating] | float:
    """Brightness of the light times the exposure: falls from one end of the room's areas to the other."""
    image = lab.simulation.image
    min_x, _, max_x, _ = lab.bounds()
    along = np.clip((np.asarray(x) - min_x) / max(1e-6, max_x - min_x), 0.0, 1.0)
    return image.exposure * (1.0 - image.lighting_gradient * along)


def render_floor(lab: Lab, optics: Optics, seed: int, channels: int) -> UInt8:
    """The empty floor as the camera sees it without noise, shape (height, width, channels)."""
    slopes = optics.slopes
    floor_x = slopes[..., 0] * np.float32(optics.position[2]) + np.float32(optics.position[0])
    floor_y = slopes[..., 1] * np.float32(optics.position[2]) + np.float32(optics.position[1])
    fine, coarse = _texture(seed, floor_x, floor_y)
    mat = _coverage(optics, [segmentize(Polygon(area.outline), 0.1) for area in lab.areas])
    paint = _coverage(optics, painted_outlines(lab))
    image = np.empty((*floor_x.shape, channels), dtype=np.float32)
    for channel in range(channels):
        rubber, concrete, white = (tone(colour, channels)[channel] for colour in (_MAT, _CONCRETE, _PAINT))
        plane = concrete * (1.0 + 0.05 * fine + 0.07 * coarse)
        plane += mat * (rubber * (1.0 + 0.09 * fine + 0.08 * coarse) - plane)
        plane += paint * (white * (1.0 + 0.02 * fine + 0.05 * coarse) - plane)
        image[..., channel] = plane
    for tag_id, pose in true_floor_tags(lab, seed).items():
        _glue(image, optics, tag_texture(lab.floor_tags.family, tag_id, lab.floor_tags.size_m, channels), pose, lab)
    image *= np.asarray(light_at(lab, floor_x), dtype=np.float32)[..., None]
    if lab.simulation.image.blur_sigma_px > 0:
        image = np.asarray(cv2.GaussianBlur(image, (0, 0), lab.simulation.image.blur_sigma_px)).reshape(image.shape)
    b = optics.border
    return np.rint(image[b:-b, b:-b]).clip(0, 255).astype(np.uint8)


def _texture(seed: int, x: Float32, y: Float32) -> tuple[Float32, Float32]:
    """Fine and coarse grain of the floor, of mean 0 and deviation about 1, the same for all cameras."""
    rng = np.random.default_rng([seed, zlib.crc32(b"floor texture")])
    planes: list[Float32] = []
    for texels_per_cycle, texel_m in ((1.2, _GRAIN_TEXEL_M), (10.0, 6 * _GRAIN_TEXEL_M)):
        noise = rng.standard_normal((_GRAIN_TEXELS, _GRAIN_TEXELS)).astype(np.float32)
        tiled = np.pad(noise, 64, mode="wrap")
        smooth = np.asarray(cv2.GaussianBlur(tiled, (0, 0), texels_per_cycle), dtype=np.float32)[64:-64, 64:-64]
        smooth = np.ascontiguousarray(smooth / smooth.std())
        u, v = np.mod(x / texel_m, _GRAIN_TEXELS), np.mod(y / texel_m, _GRAIN_TEXELS)
        sampled = cv2.remap(
            smooth, u.astype(np.float32), v.astype(np.float32), cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP
        )
        planes.append(np.asarray(sampled, dtype=np.float32))
    return planes[0], planes[1]


def _coverage(optics: Optics, outlines: list[Polygon]) -> Float32:
    """Share of each pixel, border included, that lies in any of the outlines on the floor."""
    b, samples = optics.border, _SHAPE_SAMPLES
    height, width = optics.model.height + 2 * b, optics.model.width + 2 * b
    canvas = np.zeros((height * samples, width * samples), dtype=np.uint8)
    for outline in outlines:
        ground = np.array(outline.exterior.coords)
        pixels = optics.project(np.column_stack((ground, np.zeros(len(ground)))))
        if pixels is not None:
            fine = ((pixels + b + 0.5) * samples - 0.5) * 16.0
            cv2.fillPoly(canvas, [np.rint(fine.clip(-1e7, 1e7)).astype(np.int32)], 255, shift=4)
    share = cv2.resize(canvas, (width, height), interpolation=cv2.INTER_AREA)
    return np.asarray(share, dtype=np.float32) / np.float32(255.0)


def _glue(image: Float32, optics: Optics, tag: Texture, pose: SE2, lab: Lab) -> None:
    """Draws a tag at its pose into the image, whose border is the optics'."""
    half = lab.floor_tags.size_m * PLATE_BITS / TAG_BITS / 2.0
    rim = np.linspace(-half, half, 5)
    edge = np.full_like(rim, half)
    outline = np.vstack([np.column_stack(side) for side in ((rim, edge), (rim, -edge), (edge, rim), (-edge, rim))])
    pixels = optics.project(np.column_stack((pose.apply(outline), np.zeros(len(outline)))))
    if pixels is None:
        return
    b, samples = optics.border, _TAG_SAMPLES
    # One pixel of the border stays free, for the interpolation of rays.
    low = np.maximum(np.floor(pixels.min(axis=0)) - 1, 1 - b).astype(int)
    high = np.minimum(
        np.ceil(pixels.max(axis=0)) + 2, (optics.model.width + b - 1, optics.model.height + b - 1)
    ).astype(int)
    if (high <= low).any():
        return
    (x0, y0), (x1, y1) = low, high
    around = optics.window(x0 - 1, y0 - 1, x1 + 1, y1 + 1)
    size = ((x1 - x0 + 2) * samples, (y1 - y0 + 2) * samples)
    rays = np.asarray(cv2.resize(around, size, interpolation=cv2.INTER_LINEAR), dtype=np.float32)
    sampled = sample(tag, optics, rays[samples:-samples, samples:-samples], pose, 0.0)
    mean = cv2.resize(sampled.astype(np.float32), (x1 - x0, y1 - y0), interpolation=cv2.INTER_AREA)
    part = image[y0 + b : y1 + b, x0 + b : x1 + b]
    part *= 1.0 - mean[..., -1:] / 255.0
    part += mean[..., :-1]


def sample(texture: Texture, optics: Optics, rays: Float32, pose: SE2, height_m: float) -> UInt8:
    """The texture, lying at `pose` at that height, where the rays (rows, columns, 2) meet it; transparent elsewhere."""
    c, s = np.cos(pose.yaw), np.sin(pose.yaw)
    drop = (optics.position[2] - height_m) / texture.texel_m
    dx, dy = optics.position[0] - pose.x, optics.position[1] - pose.y
    matrix = np.array(
        [
            [c * drop, s * drop, (c * dx + s * dy - texture.x0) / texture.texel_m],
            [-s * drop, c * drop, (-s * dx + c * dy - texture.y0) / texture.texel_m],
        ]
    )
    # OpenCV 5.0 reads two coordinates per element of one map wrongly when the image has four channels.
    columns, rows = cv2.split(cv2.transform(rays, matrix))
    return np.asarray(cv2.remap(texture.pixels, columns, rows, cv2.INTER_LINEAR), dtype=np.uint8)
