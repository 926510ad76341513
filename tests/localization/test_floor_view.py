"""Where the floor is in the image, and what robots hide of it, against geometry that shares no code with it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely.geometry import Point, Polygon

from geometry import SE2, CameraModel
from lab.rendering.optics import Optics
from localization.floor.silhouettes import hull_on_floor, robot_mask
from localization.floor.view import FloorView, floor_view, moved
from localization.prediction import pose_at
from mapping.grid import FloorGrid
from protocol.messages import CameraExtrinsics, TrackedPose
from tests.localization.floor_scene import LAB, true_extrinsics

AREA = FloorGrid.covering(LAB.bounds())


def view_of(camera: str) -> FloorView:
    view = floor_view(LAB.camera(camera).model(), true_extrinsics(camera), AREA, fine_m=0.025, pixel_m=0.0125)
    assert view is not None
    return view


@pytest.mark.parametrize("camera", ["cam0", "cam1", "cam2", "cam3"])
def test_samples_are_where_the_lens_puts_them(camera: str) -> None:
    view, spec = view_of(camera), LAB.camera(camera)
    rows, columns = np.nonzero(view.visible)
    x = view.grid.origin_x + (columns + 0.5) * view.fine_m
    y = view.grid.origin_y + (rows + 0.5) * view.fine_m
    pixels = Optics(spec.model(), LAB.simulation.mounts[camera]).project(np.column_stack((x, y, np.zeros(len(x)))))
    assert pixels is not None
    scale = np.array([spec.width / view.shrunk[0], spec.height / view.shrunk[1]])
    sampled = np.column_stack((view.map_x[view.visible], view.map_y[view.visible]))
    assert np.abs((sampled + 0.5) * scale - 0.5 - pixels).max() < 0.02
    assert view.to_fine(np.column_stack((x, y)).astype(np.float64)) == pytest.approx(
        np.column_stack((columns, rows)), abs=1e-6
    )


def test_the_view_is_what_the_lens_sees_of_the_floor() -> None:
    view = view_of("cam1")
    rows, columns = np.nonzero(np.ones_like(view.visible))
    x = view.grid.origin_x + (columns + 0.5) * view.fine_m
    y = view.grid.origin_y + (rows + 0.5) * view.fine_m
    spec = LAB.camera("cam1")
    points = np.column_stack((x, y, np.zeros(len(x))))
    pixels = Optics(spec.model(), LAB.simulation.mounts["cam1"]).project(points)
    assert pixels is not None
    # Two shrunken pixels at the border are left out, no more.
    edge = 3 * spec.width / view.shrunk[0]
    well_inside = ((pixels > edge) & (pixels < np.array([spec.width, spec.height]) - 1 - edge)).all(axis=1)
    outside = ((pixels < 0) | (pixels > np.array([spec.width, spec.height]) - 1)).any(axis=1)
    assert view.visible.ravel()[well_inside].all()
    assert not view.visible.ravel()[outside].any()
    outline = Polygon(view.outline)
    assert outline.is_valid
    assert outline.area == pytest.approx(view.visible.sum() * view.fine_m**2, rel=0.03)


def test_a_strong_lens_does_not_fold_far_floor_into_the_image() -> None:
    """A barrel polynomial turns back beyond the image; floor out there must not be sampled from inside of it."""
    model = CameraModel(960, 540, 570.0, 570.0, 479.5, 269.5, (-0.3, 0.0, 0.0, 0.0, 0.0))
    hall = FloorGrid.covering((-20.0, -20.0, 20.0, 20.0))
    view = floor_view(model, true_extrinsics("cam0"), hall, fine_m=0.05, pixel_m=0.025)
    assert view is not None
    rows, columns = np.nonzero(view.visible)
    x = view.grid.origin_x + (columns + 0.5) * view.fine_m
    y = view.grid.origin_y + (rows + 0.5) * view.fine_m
    assert np.hypot(x - 1.0, y - 2.15).max() < 6.0


def test_a_camera_that_sees_none_of_the_lab_has_no_view() -> None:
    elsewhere = replace(true_extrinsics("cam0"), translation=(100.0, 100.0, 3.0))
    assert floor_view(LAB.camera("cam0").model(), elsewhere, AREA, fine_m=0.025, pixel_m=0.0125) is None
    upwards = replace(true_extrinsics("cam0"), rotvec=(0.0, 0.0, 0.0))
    assert floor_view(LAB.camera("cam0").model(), upwards, AREA, fine_m=0.025, pixel_m=0.0125) is None


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"translation": (1.003, 2.15, 3.0)}, False),
        ({"translation": (1.006, 2.15, 3.0)}, True),
        ({"rotvec": (math.pi - 0.012 + 0.002, 0.0, 0.0)}, False),
        ({"rotvec": (math.pi - 0.012 + 0.004, 0.0, 0.0)}, True),
    ],
)
def test_only_what_matters_on_the_floor_counts_as_moved(
    change: dict[str, tuple[float, float, float]], expected: bool
) -> None:
    extrinsics = CameraExtrinsics("cam0", 1, (math.pi - 0.012, 0.0, 0.0), (1.0, 2.15, 3.0), 0.1, ())
    assert moved(extrinsics, replace(extrinsics, **change)) is expected


def tracked(x: float, y: float, yaw: float, vx: float = 0.0, vy: float = 0.0, rate: float = 0.0) -> TrackedPose:
    return TrackedPose("wifibot-14", 10**18, x, y, yaw, vx, vy, rate, (1e-5, 0.0, 0.0, 1e-5, 0.0, 1e-4), ("cam0",))


@given(
    st.floats(-0.3, 2.3),
    st.floats(0.0, 4.2),
    st.floats(-3.1, 3.1),
    st.sampled_from(["wifibot-14", "turtlebot-16"]),
    st.floats(0, 1),
    st.floats(-0.99, 0.99),
    st.floats(-0.99, 0.99),
)
def test_every_point_of_a_robot_falls_within_its_silhouette(
    x: float, y: float, yaw: float, name: str, level: float, across: float, along: float
) -> None:
    vehicle = LAB.vehicle(name)
    eye = np.array(true_extrinsics("cam0").translation)
    pose = SE2(x, y, yaw)
    hull = Polygon(hull_on_floor(vehicle, pose, eye)).buffer(1e-5)
    body = Polygon(pose.apply(np.array(vehicle.footprint)))
    low_x, low_y, high_x, high_y = body.bounds
    point = np.array([low_x + (across + 1) / 2 * (high_x - low_x), low_y + (along + 1) / 2 * (high_y - low_y)])
    if not body.contains(Point(point)):
        return
    height = level * vehicle.tag.height_m
    ray = np.array([*point, height]) - eye
    fallen = eye + ray * (eye[2] / -ray[2])
    assert fallen[2] == pytest.approx(0.0, abs=1e-9)
    assert hull.contains(Point(fallen[:2]))


def test_the_mask_is_the_hull_and_its_margin() -> None:
    view, vehicle = view_of("cam0"), LAB.vehicle("wifibot-14")
    pose = tracked(0.8, 3.1, 0.4)
    mask = robot_mask(view, [(vehicle, pose)], pose.stamp_ns, margin_m=0.06)
    hull = Polygon(hull_on_floor(vehicle, pose_at(pose, pose.stamp_ns), view.eye))
    for row, column in zip(*np.nonzero(np.ones_like(mask)), strict=True):
        x = view.grid.origin_x + (column + 0.5) * view.fine_m
        y = view.grid.origin_y + (row + 0.5) * view.fine_m
        if abs(x - 0.8) > 0.6 or abs(y - 3.1) > 0.6:
            continue
        distance = hull.distance(Point(x, y))
        if distance < 0.04:
            assert mask[row, column]
        if distance > 0.1:
            assert not mask[row, column]


def test_a_pose_is_carried_on_to_the_capture_time() -> None:
    pose = tracked(1.0, 2.0, 0.5, vx=0.4, vy=-0.2, rate=1.0)
    later = pose_at(pose, pose.stamp_ns + 100_000_000)
    assert (later.x, later.y, later.yaw) == pytest.approx((1.04, 1.98, 0.6), abs=0.003)
    view = view_of("cam0")
    now, then = (robot_mask(view, [(LAB.vehicle("wifibot-14"), pose)], pose.stamp_ns + age) for age in (0, 500_000_000))
    assert np.argwhere(then)[:, 1].mean() > np.argwhere(now)[:, 1].mean() + 0.15 / view.fine_m
    assert then.sum() > now.sum(), "an old pose is doubted"


def test_robots_elsewhere_mask_nothing() -> None:
    view = view_of("cam0")
    assert not robot_mask(view, [(LAB.vehicle("wifibot-14"), tracked(7.0, 1.0, 0.0))], 10**18).any()
    assert not robot_mask(view, [(LAB.vehicle("wifibot-14"), tracked(-500.0, 1e6, 0.0))], 10**18).any()
