"""The operator's plan and what guidance makes of it: waypoints, routes, paths ahead, obstacle boxes, obstacles."""

import math
from collections.abc import Mapping

import numpy as np
import viser
from numpy.typing import NDArray

from mapping.grid import FloorGrid
from protocol.channels import GUIDANCE, OBSTACLES
from protocol.errors import DecodeError
from protocol.messages import FloorRaster, GuidanceState, Route, Waypoint
from server.scene import colors, shapes
from server.scene.canvas import Canvas

_OBSTACLE_HEIGHT_M = 0.12
_UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def draw_waypoints(canvas: Canvas, waypoints: Mapping[str, Waypoint]) -> None:
    """Discs of the waypoints' radii with a rim and, where a heading matters, its direction; all in one mesh and one set of
    lines. A label per waypoint."""
    shown = sorted(waypoints.values(), key=lambda waypoint: waypoint.id)
    if not shown:
        canvas.keep_only("/waypoints", ())
        return
    scales = np.array([(w.radius_m, w.radius_m, 1.0) for w in shown], dtype=np.float32)
    upright = np.tile(np.array(_UPRIGHT, dtype=np.float32), (len(shown), 1))
    for name, inner, opacity, height in (("discs", 0.0, 0.35, 0.008), ("rims", 0.88, 1.0, 0.016)):
        vertices, faces = shapes.disc(inner=inner)
        positions = np.array([(w.x, w.y, height) for w in shown], dtype=np.float32)

        def make(
            scene: viser.SceneApi,
            name: str,
            mesh: shapes.Mesh = (vertices, faces),
            opacity: float = opacity,
            positions: NDArray[np.float32] = positions,
        ) -> viser.SceneNodeHandle:
            return scene.add_batched_meshes_simple(
                name,
                *mesh,
                batched_wxyzs=upright,
                batched_positions=positions,
                batched_scales=scales,
                batched_colors=colors.WAYPOINT,
                opacity=opacity,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
                lod="off",
            )

        canvas.draw(f"/waypoints/{name}", (positions.tobytes(), scales.tobytes()), make)
    _draw_headings(canvas, shown)
    for waypoint in shown:
        place = (waypoint.x, waypoint.y, 0.22)

        def label(
            scene: viser.SceneApi, name: str, text: str = waypoint.id, at: tuple[float, float, float] = place
        ) -> viser.SceneNodeHandle:
            return scene.add_label(name, text, position=at, font_screen_scale=0.8, anchor="bottom-center")

        canvas.draw(f"/waypoints/name-{waypoint.id}", place, label)
    kept = {"discs", "rims", *(f"name-{w.id}" for w in shown)}
    canvas.keep_only("/waypoints", kept | ({"headings"} if any(w.yaw is not None for w in shown) else set()))


def draw_routes(canvas: Canvas, routes: Mapping[str, Route], waypoints: Mapping[str, Waypoint]) -> None:
    """All routes as one set of lines, closed where they loop."""
    segments: list[NDArray[np.float32]] = []
    for _, route in sorted(routes.items()):
        points = [
            (waypoints[leg.waypoint].x, waypoints[leg.waypoint].y) for leg in route.legs if leg.waypoint in waypoints
        ]
        if route.loop and len(points) > 2:
            points.append(points[0])
        if len(points) > 1:
            segments.append(shapes.line(points, 0.018))
    _draw_lines(canvas, "/plan/routes", segments, colors.ROUTE, 0.012)


def draw_guidance(canvas: Canvas, states: Mapping[str, GuidanceState], now_ns: int) -> None:
    """Paths ahead, temporary waypoints and obstacle boxes (blue, red when something is in them) of what is fresh."""
    fresh = [s for _, s in sorted(states.items()) if abs(now_ns - s.stamp_ns) <= GUIDANCE.stale_after_s * 1e9]
    _draw_lines(
        canvas, "/plan/paths", [shapes.line(s.path, 0.022) for s in fresh if len(s.path) > 1], colors.PATH, 0.02
    )
    for name, color, blocked in (("clear", colors.BOX_CLEAR, False), ("taken", colors.BOX_TAKEN, True)):
        boxes = [s.box for s in fresh if s.blocked is blocked and len(s.box) >= 3]
        _draw_lines(canvas, f"/plan/box-borders-{name}", [shapes.border(box, 0.03) for box in boxes], color, 0.022)
        _draw_areas(canvas, f"/plan/boxes-{name}", boxes, color)
    carrots = tuple(s.carrot for s in fresh if s.carrot is not None)
    _draw_carrots(canvas, carrots)


def draw_obstacles(canvas: Canvas, raster: FloorRaster | None, now_ns: int) -> None:
    """The taken cells as low red blocks, all in one mesh; none when the raster is stale or contradicts itself."""
    name = "/obstacles"
    centres = _taken(raster, now_ns)
    if raster is None or len(centres) == 0:
        canvas.erase(name)
        return
    side, count = raster.cell_m, len(centres)

    def make(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
        return scene.add_batched_meshes_simple(
            name,
            *shapes.box(),
            batched_wxyzs=np.tile(np.array(_UPRIGHT, dtype=np.float32), (count, 1)),
            batched_positions=np.column_stack((centres, np.zeros(count))).astype(np.float32),
            batched_scales=np.tile(np.array((side, side, _OBSTACLE_HEIGHT_M), dtype=np.float32), (count, 1)),
            batched_colors=colors.OBSTACLE,
            flat_shading=True,
            opacity=0.9,
            lod="off",
        )

    canvas.draw(name, (centres.tobytes(), side), make)


def _taken(raster: FloorRaster | None, now_ns: int) -> NDArray[np.float64]:
    if raster is not None and abs(now_ns - raster.stamp_ns) <= OBSTACLES.stale_after_s * 1e9:
        try:
            return FloorGrid.from_raster(raster).occupied_centres()
        except DecodeError:
            pass  # guidance tells people about it
    return np.zeros((0, 2))


def _draw_headings(canvas: Canvas, waypoints: list[Waypoint]) -> None:
    segments: list[NDArray[np.float32]] = []
    for w in waypoints:
        if w.yaw is not None:
            length = max(0.2, w.radius_m)
            tip = (w.x + length * math.cos(w.yaw), w.y + length * math.sin(w.yaw))
            segments.append(shapes.line([(w.x, w.y), tip], 0.02))
            for side in (2.6, -2.6):
                end = (tip[0] + 0.07 * math.cos(w.yaw + side), tip[1] + 0.07 * math.sin(w.yaw + side))
                segments.append(shapes.line([tip, end], 0.02))
    _draw_lines(canvas, "/waypoints/headings", segments, colors.WAYPOINT, 0.015)


def _draw_carrots(canvas: Canvas, carrots: tuple[tuple[float, float], ...]) -> None:
    if not carrots:
        canvas.erase("/plan/carrots")
        return
    count = len(carrots)

    def make(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
        return scene.add_batched_meshes_simple(
            name,
            *shapes.disc(),
            batched_wxyzs=np.tile(np.array(_UPRIGHT, dtype=np.float32), (count, 1)),
            batched_positions=np.array([(x, y, 0.035) for x, y in carrots], dtype=np.float32),
            batched_scales=np.full(count, 0.045, dtype=np.float32),
            batched_colors=colors.PATH,
            side="double",
            cast_shadow=False,
            lod="off",
        )

    canvas.draw("/plan/carrots", carrots, make)


def _draw_areas(canvas: Canvas, name: str, outlines: list[tuple[shapes.Point, ...]], color: shapes.Color) -> None:
    if not outlines:
        canvas.erase(name)
        return

    def make(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
        mesh = shapes.joined(shapes.flat(outline, 0.026) for outline in outlines)
        return scene.add_mesh_simple(
            name, *mesh, color=color, opacity=0.25, side="double", cast_shadow=False, receive_shadow=False
        )

    canvas.draw(name, tuple(outlines), make)


def _draw_lines(
    canvas: Canvas, name: str, segments: list[NDArray[np.float32]], color: shapes.Color, thickness_m: float
) -> None:
    if not segments:
        canvas.erase(name)
        return
    together = np.concatenate(segments)

    def make(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
        return scene.add_line_segments(name, together, shapes.colors(color, len(together)), thickness=thickness_m)

    canvas.draw(name, together.tobytes(), make)
