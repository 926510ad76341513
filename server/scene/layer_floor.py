"""What stays where it is: the floor and its picture, areas, floor tags, zones."""

import io
import math
from functools import partial

import numpy as np
import viser
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from protocol.lab import Lab
from server.scene import colors, shapes
from server.scene.canvas import Canvas
from server.scene.world import FloorPicture

_LONGEST_PX = 1600
_JPEG_QUALITY = 85
_APRON_M = 0.6


def draw_lab(canvas: Canvas, lab: Lab) -> None:
    """Everything that the lab description says; nothing is sent the second time."""
    _draw_ground(canvas, lab)
    for area in lab.areas:
        segments = shapes.border(area.outline, 0.004)
        canvas.draw(f"/areas/{area.id}", segments.tobytes(), partial(_lines, segments, colors.AREA, 0.02))
    _draw_tags(canvas, lab)
    for zone in lab.zones:
        segments = np.concatenate([shapes.dashed(outline, 0.012) for outline in zone.subareas.values()])
        canvas.draw(f"/zones/{zone.id}", segments.tobytes(), partial(_lines, segments, colors.ZONE, 0.018))
        points = np.array([point for outline in zone.subareas.values() for point in outline])
        x, y = (points.min(axis=0) + points.max(axis=0)) / 2
        _label(canvas, f"/zones/{zone.id}/name", zone.id, (float(x), float(y), 0.05))


def decoded(picture: FloorPicture) -> NDArray[np.uint8] | None:
    """The picture's pixels (rows, columns, 3), at most 1600 on a side; None when it is none. Slow: not for the event loop."""
    try:
        image = Image.open(io.BytesIO(picture.jpeg))
        image.draft("RGB", (_LONGEST_PX, _LONGEST_PX))
        image.thumbnail((_LONGEST_PX, _LONGEST_PX))
        return np.asarray(image.convert("RGB"))
    except (UnidentifiedImageError, OSError, ValueError, Image.DecompressionBombError):
        return None


def add_picture(scene: viser.SceneApi, picture: FloorPicture, pixels: NDArray[np.uint8]) -> viser.ImageHandle:
    """Lays the stitched floor just above the plain one, in place of the one before. Slow: not for the event loop."""
    min_x, min_y, max_x, max_y = picture.bounds
    return scene.add_image(
        "/floor/picture",
        pixels,
        max_x - min_x,
        max_y - min_y,
        format="jpeg",
        jpeg_quality=_JPEG_QUALITY,
        cast_shadow=False,
        receive_shadow=0.35,
        # viser's images look down -z with y downwards: half a turn about x lays them face up.
        wxyz=(0.0, 1.0, 0.0, 0.0),
        position=((min_x + max_x) / 2, (min_y + max_y) / 2, 0.002),
    )


def _draw_ground(canvas: Canvas, lab: Lab) -> None:
    min_x, min_y, max_x, max_y = lab.bounds()
    low_x, low_y, high_x, high_y = min_x - _APRON_M, min_y - _APRON_M, max_x + _APRON_M, max_y + _APRON_M
    corners = [(low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y)]
    vertices, faces = shapes.flat(corners, -0.004)

    def ground(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
        return scene.add_mesh_simple(name, vertices, faces, color=colors.FLOOR, side="double", cast_shadow=False)

    def grid(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
        # Whole metres, so that the grid's lines are the map's.
        left, bottom = math.floor(low_x), math.floor(low_y)
        width, height = math.ceil(high_x) - left, math.ceil(high_y) - bottom
        return scene.add_grid(
            name,
            width,
            height,
            cell_size=0.5,
            section_size=1.0,
            cell_color=colors.GRID,
            section_color=colors.GRID_SECTION,
            position=(left + width / 2, bottom + height / 2, -0.002),
            shadow_opacity=0.0,
        )

    canvas.draw("/floor/ground", lab.bounds(), ground)
    canvas.draw("/floor/grid", lab.bounds(), grid)


def _draw_tags(canvas: Canvas, lab: Lab) -> None:
    half = lab.floor_tags.size_m / 2
    square = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    segments: list[NDArray[np.float32]] = []
    for tag_id, (x, y, yaw) in sorted(lab.floor_tags.poses.items()):
        turn = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
        outline = [(float(px), float(py)) for px, py in square @ turn + (x, y)]
        segments.append(shapes.border(outline, 0.01))
        _label(canvas, f"/tags/{tag_id}", f"tag {tag_id}", (x, y - 1.3 * lab.floor_tags.size_m, 0.02))
    if segments:
        together = np.concatenate(segments)
        canvas.draw("/tags/outlines", together.tobytes(), partial(_lines, together, colors.TAG, 0.012))


def _label(canvas: Canvas, name: str, text: str, position: tuple[float, float, float]) -> None:
    def make(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
        return scene.add_label(
            name,
            text,
            position=position,
            font_size_mode="scene",
            font_scene_height=0.085,
            anchor="center-center",
            depth_test=True,
        )

    canvas.draw(name, (text, position), make)


def _lines(
    segments: NDArray[np.float32], color: shapes.Color, thickness_m: float, scene: viser.SceneApi, name: str
) -> viser.SceneNodeHandle:
    return scene.add_line_segments(name, segments, shapes.colors(color, len(segments)), thickness=thickness_m)
