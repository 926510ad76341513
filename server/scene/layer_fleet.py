"""Robots and cameras. A robot is a frame that moves, with a body, its tag, a heading and a label below it that change only
with its state; one that is no longer seen fades and says since when."""

import math
from collections.abc import Mapping

import numpy as np
import viser

from geometry import SE3
from protocol.channels import CAMERA_STATES, GUIDANCE, POSES
from protocol.lab import CameraSpec, Lab, VehicleSpec
from protocol.messages import CameraExtrinsics, CameraState, GuidanceState, ReasonCode, TrackedPose
from server.scene import colors, shapes
from server.scene.canvas import Canvas
from server.scene.world import World

_MOVED_M, _TURNED = 0.001, 0.002
_LONGEST_LOOK_S = 0.3
_CLEARANCE_M = 0.03
_FRUSTUM_M = 0.3


def draw_robots(canvas: Canvas, lab: Lab, world: World, now_ns: int) -> None:
    """Every vehicle of the lab that was ever seen."""
    for spec in lab.vehicles:
        pose = world.poses.get(spec.id)
        if pose is None:
            canvas.erase(f"/robots/{spec.id}")
        else:
            _draw_robot(canvas, spec, pose, world.guidance.get(spec.id), now_ns)


def draw_cameras(
    canvas: Canvas, lab: Lab, extrinsics: Mapping[str, CameraExtrinsics], states: Mapping[str, CameraState], now_ns: int
) -> None:
    """Calibrated cameras as frustums, red while they give nothing."""
    for spec in lab.cameras:
        found = extrinsics.get(spec.id)
        if found is None:
            canvas.erase(f"/cameras/{spec.id}")
        else:
            _draw_camera(canvas, spec, found, states.get(spec.id), now_ns)


def _draw_robot(canvas: Canvas, spec: VehicleSpec, pose: TrackedPose, state: GuidanceState | None, now_ns: int) -> None:
    age_s = abs(now_ns - pose.stamp_ns) / 1e9
    seen = age_s <= POSES.stale_after_s
    guided = state is not None and abs(now_ns - state.stamp_ns) <= GUIDANCE.stale_after_s * 1e9
    code = state.reason.code if state is not None and guided else None
    color, opacity = (colors.of_reason(code), None) if seen else (colors.LOST, 0.35)
    root = f"/robots/{spec.id}"
    frame = canvas.draw(root, spec.id, lambda scene, name: scene.add_frame(name, show_axes=False))
    _move(frame, pose, min(age_s, _LONGEST_LOOK_S) if seen else 0.0)
    _draw_body(canvas, root, spec, color, opacity)
    text = spec.id if not seen or code in (None, ReasonCode.IDLE) else f"{spec.id} · {_words(code)}"
    if not seen:
        text = f"{spec.id} · not seen for {_age(age_s)}"
    height = spec.tag.height_m + 0.14

    def label(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
        return scene.add_label(name, text, position=(0.0, 0.0, height), anchor="bottom-center", font_screen_scale=0.9)

    canvas.draw(f"{root}/label", text, label)


def _draw_body(canvas: Canvas, root: str, spec: VehicleSpec, color: shapes.Color, opacity: float | None) -> None:
    """A dark chassis, a deck in the colour of the state, and the tag's plate at its height on a post."""
    top = max(0.1, spec.tag.height_m)
    deck = max(0.08, top * 0.55)
    x, y, yaw = spec.tag.offset
    half = spec.tag.size_m * 0.6
    plate = _square(x, y, yaw, half)
    parts: tuple[tuple[str, shapes.Mesh, shapes.Color], ...] = (
        ("chassis", shapes.prism(spec.footprint, _CLEARANCE_M, deck - 0.03), colors.BODY),
        ("deck", shapes.prism(spec.footprint, deck - 0.03, deck), color),
        ("post", shapes.prism(_square(x, y, yaw, 0.025), deck, top - 0.01), colors.BODY),
        ("plate", shapes.prism(plate, top - 0.01, top), colors.TAG_PLATE),
        ("tag", shapes.flat(_square(x, y, yaw, half * 0.72), top + 0.002), colors.TAG_INK),
        ("heading", shapes.prism(_arrow(spec), 0.012, 0.03), color),
    )
    for name, mesh, own in parts:

        def make(
            scene: viser.SceneApi, name: str, mesh: shapes.Mesh = mesh, own: shapes.Color = own
        ) -> viser.SceneNodeHandle:
            return scene.add_mesh_simple(name, *mesh, color=own, opacity=opacity, flat_shading=True, side="double")

        canvas.draw(f"{root}/{name}", (own, opacity), make)


def _draw_camera(
    canvas: Canvas, spec: CameraSpec, extrinsics: CameraExtrinsics, state: CameraState | None, now_ns: int
) -> None:
    live = state is not None and state.connected and abs(now_ns - state.stamp_ns) <= CAMERA_STATES.stale_after_s * 1e9
    color = colors.CAMERA if live else colors.CAMERA_LOST
    pose = SE3.from_rotvec(extrinsics.rotvec, extrinsics.translation)
    wxyz = _quaternion(pose)
    root = f"/cameras/{spec.id}"

    def frustum(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
        return scene.add_camera_frustum(
            name,
            fov=2 * math.atan(spec.height / 2 / spec.intrinsics.fy),
            aspect=spec.width / spec.height,
            scale=_FRUSTUM_M,
            thickness=0.012,
            color=color,
            wxyz=wxyz,
            position=extrinsics.translation,
            cast_shadow=False,
        )

    def label(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
        text = spec.id if live else f"{spec.id} · no picture"
        return scene.add_label(name, text, position=(0.0, 0.0, -0.1), anchor="bottom-center", font_screen_scale=0.8)

    place = (extrinsics.rotvec, extrinsics.translation)
    canvas.draw(root, (place, live), frustum)
    canvas.draw(f"{root}/label", (place, live), label)


def _move(frame: viser.SceneNodeHandle, pose: TrackedPose, look_s: float) -> None:
    """To where the robot is now if it kept its velocity; nothing is sent for less than can be seen."""
    x, y = pose.x + pose.vx * look_s, pose.y + pose.vy * look_s
    half = (pose.yaw + pose.yaw_rate * look_s) / 2
    position, wxyz = np.array((x, y, 0.0)), np.array((math.cos(half), 0.0, 0.0, math.sin(half)))
    if float(np.abs(frame.position - position).max()) > _MOVED_M:
        frame.position = position
    if float(np.abs(frame.wxyz - wxyz).max()) > _TURNED:
        frame.wxyz = wxyz


def _square(x: float, y: float, yaw: float, half: float) -> list[shapes.Point]:
    c, s = math.cos(yaw) * half, math.sin(yaw) * half
    return [(x - c + s, y - s - c), (x + c + s, y + s - c), (x + c - s, y + s + c), (x - c - s, y - s + c)]


def _arrow(spec: VehicleSpec) -> list[shapes.Point]:
    front = max(x for x, _ in spec.footprint)
    half = 0.4 * max(abs(y) for _, y in spec.footprint)
    return [(front + 0.03, -half), (front + 0.03 + 1.6 * half, 0.0), (front + 0.03, half)]


def _quaternion(pose: SE3) -> tuple[float, float, float, float]:
    """w, x, y, z of the rotation, from its rotation vector."""
    vector = pose.rotvec()
    angle = float(np.linalg.norm(vector))
    scale = 0.5 if angle < 1e-9 else math.sin(angle / 2) / angle
    return math.cos(angle / 2), float(vector[0]) * scale, float(vector[1]) * scale, float(vector[2]) * scale


def _words(code: ReasonCode | None) -> str:
    return "driving" if code is ReasonCode.ROUTE else str(code).replace("_", " ")


def _age(seconds: float) -> str:
    """Whole units, so that a label changes once a second at most."""
    if seconds < 60:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 3600 else f"{seconds / 3600:.0f} h"
