"""Meshes and lines of the scene: prisms over floor outlines, flat areas, borders. Metres; pure."""

import math
from collections.abc import Iterable, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

Point = tuple[float, float]
Color = tuple[int, int, int]
Mesh = tuple[NDArray[np.float32], NDArray[np.uint32]]


def flat(outline: Sequence[Point], z: float) -> Mesh:
    """The area within an outline at height `z`, facing up: vertices (V, 3) and faces (F, 3)."""
    polygon = Polygon(outline)
    if not polygon.is_valid:
        polygon = polygon.buffer(0)
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    corners = [shapely.get_coordinates(shapely.normalize(triangle))[:3] for triangle in triangles]
    if not corners:
        return np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32)
    points = np.array([_counter_clockwise(corner) for corner in corners]).reshape(-1, 2)
    vertices = np.column_stack((points, np.full(len(points), z))).astype(np.float32)
    return vertices, np.arange(len(points), dtype=np.uint32).reshape(-1, 3)


def prism(outline: Sequence[Point], low: float, high: float) -> Mesh:
    """The body over an outline from height `low` to `high`, without its underside."""
    top, faces = flat(outline, high)
    ring = list(Polygon(outline).exterior.coords[:-1])
    if not Polygon(outline).exterior.is_ccw:
        ring.reverse()
    walls: list[tuple[float, float, float]] = []
    for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1], strict=True):
        walls += [(ax, ay, low), (bx, by, low), (bx, by, high), (ax, ay, low), (bx, by, high), (ax, ay, high)]
    vertices = np.concatenate((top, np.array(walls, dtype=np.float32)))
    wall_faces = np.arange(len(top), len(vertices), dtype=np.uint32).reshape(-1, 3)
    return vertices, np.concatenate((faces, wall_faces))


def joined(meshes: Iterable[Mesh]) -> Mesh:
    """Several meshes as one."""
    vertices: list[NDArray[np.float32]] = [np.zeros((0, 3), np.float32)]
    faces: list[NDArray[np.uint32]] = [np.zeros((0, 3), np.uint32)]
    count = 0
    for mesh_vertices, mesh_faces in meshes:
        vertices.append(mesh_vertices)
        faces.append(mesh_faces + np.uint32(count))
        count += len(mesh_vertices)
    return np.concatenate(vertices), np.concatenate(faces)


def border(outline: Sequence[Point], z: float) -> NDArray[np.float32]:
    """The closed border of an outline at height `z` as segments, shape (N, 2, 3)."""
    return line([*outline, outline[0]], z)


def line(points: Sequence[Point], z: float) -> NDArray[np.float32]:
    """A polyline at height `z` as segments, shape (N - 1, 2, 3)."""
    corners = np.array([(x, y, z) for x, y in points], dtype=np.float32).reshape(-1, 3)
    return np.stack((corners[:-1], corners[1:]), axis=1)


def dashed(outline: Sequence[Point], z: float, dash_m: float = 0.08) -> NDArray[np.float32]:
    """The closed border as dashes with gaps of the same length, shape (N, 2, 3)."""
    ring = Polygon(outline).exterior
    count = max(2, round(ring.length / (2 * dash_m)))
    step = ring.length / count
    starts = shapely.line_interpolate_point(ring, np.arange(count) * step)
    ends = shapely.line_interpolate_point(ring, np.arange(count) * step + step / 2)
    a, b = shapely.get_coordinates(starts), shapely.get_coordinates(ends)
    heights = np.full((count, 1), z)
    return np.stack((np.hstack((a, heights)), np.hstack((b, heights))), axis=1).astype(np.float32)


def disc(sides: int = 40, inner: float = 0.0) -> Mesh:
    """A flat disc (a ring when `inner` > 0) of radius 1 at height 0."""
    angles = np.linspace(0.0, math.tau, sides, endpoint=False)
    circle = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(sides)))
    vertices = np.concatenate((circle, circle * inner)).astype(np.float32)
    here = np.arange(sides)
    following = (here + 1) % sides
    outward = np.column_stack((here, following, here + sides))
    inward = np.column_stack((following, following + sides, here + sides))
    return vertices, np.concatenate((outward, inward)).astype(np.uint32)


def box() -> Mesh:
    """The unit cube over the floor: x and y from -0.5 to 0.5, z from 0 to 1."""
    return prism([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)], 0.0, 1.0)


def colors(color: Color, segments: int) -> NDArray[np.uint8]:
    """One colour for every end of `segments` segments, shape (N, 2, 3)."""
    return np.tile(np.array(color, dtype=np.uint8), (segments, 2, 1))


def _counter_clockwise(triangle: NDArray[np.float64]) -> NDArray[np.float64]:
    (ax, ay), (bx, by), (cx, cy) = triangle
    return triangle if (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > 0 else triangle[::-1]
