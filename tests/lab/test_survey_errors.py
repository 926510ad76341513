"""What is true differs from the description as much as the survey's errors say, and the cameras show what is true."""

import numpy as np
import pytest

from geometry import SE2
from lab.rendering import CameraRenderer
from lab.truth import true_camera_model, true_floor_tags, true_vehicle
from protocol.lab import SimulatedSurvey
from tests.lab.oracle import detected, rms
from tests.lab.rooms import gulliver, standing

SURVEY = SimulatedSurvey(floor_tag_m=0.002, floor_tag_rad=0.006, focal=0.002, center_px=1.5, tag_height_m=0.01)


def test_without_survey_errors_the_description_is_the_truth() -> None:
    lab = gulliver()
    assert true_camera_model(lab, lab.cameras[0], 5) == lab.cameras[0].model()
    assert true_vehicle(lab, lab.vehicles[0], 5) == lab.vehicles[0]
    described = {tag_id: SE2(*pose) for tag_id, pose in lab.floor_tags.poses.items()}
    assert true_floor_tags(lab, 5) == described


def test_errors_have_the_spread_that_the_survey_says() -> None:
    lab = gulliver(survey=SURVEY)
    camera, vehicle = lab.cameras[1], lab.vehicles[0]
    models = [true_camera_model(lab, camera, seed) for seed in range(200)]
    assert np.std([model.fx / camera.intrinsics.fx for model in models]) == pytest.approx(0.002, rel=0.2)
    assert np.std([model.cx for model in models]) == pytest.approx(1.5, rel=0.2)
    heights = [true_vehicle(lab, vehicle, seed).tag.height_m for seed in range(200)]
    assert np.std(heights) == pytest.approx(0.01, rel=0.2)
    described = lab.floor_tags.poses[3]
    tags = [true_floor_tags(lab, seed)[3] for seed in range(200)]
    assert np.std([tag.x - described[0] for tag in tags]) == pytest.approx(0.002, rel=0.2)
    assert np.std([tag.yaw - described[2] for tag in tags]) == pytest.approx(0.006, rel=0.2)


def test_the_cameras_show_the_truth_and_each_has_a_lens_of_its_own() -> None:
    surveyed = gulliver(survey=SimulatedSurvey(center_px=1.5))
    offsets: list[tuple[float, float]] = []
    for camera_id in ("cam0", "cam1"):
        camera = surveyed.camera(camera_id)
        described = detected(CameraRenderer(gulliver(), camera_id, 3).render(standing(), 1))
        shown = detected(CameraRenderer(surveyed, camera_id, 3).render(standing(), 1))
        model = true_camera_model(surveyed, camera, 3)
        offset = (model.cx - camera.intrinsics.cx, model.cy - camera.intrinsics.cy)
        for tag_id in described.keys() & shown.keys():
            assert rms(shown[tag_id] - described[tag_id] - np.array(offset)) < 0.1
        offsets.append(offset)
    assert offsets[0] != offsets[1]
