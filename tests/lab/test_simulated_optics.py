"""The renderer's own projection against OpenCV's, and rays against the projection."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from geometry import CameraModel
from lab.rendering.optics import Optics
from protocol.lab import SimulatedMount
from tests.lab.oracle import projected
from tests.lab.rooms import gulliver

CAMERAS = ["cam0", "cam1", "cam2", "cam3"]


def small(distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)) -> CameraModel:
    return CameraModel(320, 240, 200.0, 205.0, 163.0, 118.0, distortion)


@pytest.mark.parametrize("camera_id", CAMERAS)
def test_projection_agrees_with_opencv(camera_id: str) -> None:
    lab = gulliver()
    optics = Optics(lab.camera(camera_id).model(), lab.simulation.mounts[camera_id])
    rng = np.random.default_rng(3)
    x, y, _ = lab.simulation.mounts[camera_id].position
    points = np.column_stack(
        (rng.uniform(x - 1.5, x + 1.5, 300), rng.uniform(y - 2.2, y + 2.2, 300), rng.uniform(0, 0.6, 300))
    )
    pixels = optics.project(points)
    assert pixels is not None
    assert pixels == pytest.approx(projected(lab, camera_id, points), abs=1e-8)


@settings(max_examples=12)
@given(
    distortion=st.tuples(
        st.floats(-0.15, 0.1), st.floats(-0.02, 0.04), st.floats(-2e-3, 2e-3), st.floats(-2e-3, 2e-3), st.just(0.0)
    ),
    tilt=st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2)),
    yaw=st.floats(-3.2, 3.2),
    height=st.floats(0.0, 1.5),
)
def test_every_ray_leads_back_to_its_pixel(
    distortion: tuple[float, float, float, float, float], tilt: tuple[float, float], yaw: float, height: float
) -> None:
    mount = SimulatedMount(position=(1.0, -2.0, 3.0), yaw=yaw, tilt_x=tilt[0], tilt_y=tilt[1])
    try:
        optics = Optics(small(distortion), mount)
    except ValueError:
        assume(False)
        return
    rays = optics.window(0, 0, 320, 240)[::37, ::41].reshape(-1, 2).astype(np.float64)
    points = np.column_stack((optics.position[:2] + (3.0 - height) * rays, np.full(len(rays), height)))
    us, vs = np.meshgrid(np.arange(0, 320, 41), np.arange(0, 240, 37))
    pixels = optics.project(points)
    assert pixels is not None
    assert pixels == pytest.approx(np.column_stack((us.ravel(), vs.ravel())), abs=1e-3)


def test_an_untilted_camera_looks_straight_down_with_x_along_its_yaw() -> None:
    optics = Optics(small(), SimulatedMount(position=(2.0, 1.0, 3.0), yaw=0.0))
    pixels = optics.project([[2.0, 1.0, 0.0], [2.3, 1.0, 0.0], [2.0, 1.3, 0.0]])
    assert pixels == pytest.approx(np.array([[163.0, 118.0], [183.0, 118.0], [163.0, 118.0 - 20.5]]))


def test_what_is_far_outside_the_image_stays_outside() -> None:
    """Behind a strong barrel distortion the lens's polynomial would fold distant points back into the picture."""
    optics = Optics(small((-0.1, 0.0, 0.0, 0.0, 0.0)), SimulatedMount(position=(0.0, 0.0, 3.0)))
    pixels = optics.project([[distance, 0.0, 0.0] for distance in (4.0, 8.0, 20.0, 60.0)])
    assert pixels is not None
    assert (np.diff(pixels[:, 0]) > 0).all()
    assert pixels[0, 0] > 320


def test_points_behind_the_camera_have_no_pixels() -> None:
    assert Optics(small(), SimulatedMount(position=(0.0, 0.0, 3.0))).project([[0.0, 0.0, 1.0], [0.0, 0.0, 3.5]]) is None


def test_a_lens_that_folds_the_image_over_itself_is_refused() -> None:
    with pytest.raises(ValueError, match="distortion"):
        Optics(small((-0.9, 0.0, 0.0, 0.0, 0.0)), SimulatedMount(position=(0.0, 0.0, 3.0)))


def test_a_camera_that_sees_the_horizon_is_refused() -> None:
    with pytest.raises(ValueError, match="horizon"):
        Optics(small(), SimulatedMount(position=(0.0, 0.0, 3.0), tilt_x=1.2))
