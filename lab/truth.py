"""What truly stands in the simulated room: the lab description, put off by the errors with which people measure.

Estimators are told what the description says; the simulated cameras show what is made here. Every part draws from a stream
of its own, so one camera's lens does not depend on how many others there are.
"""

import zlib
from dataclasses import replace

import numpy as np

from geometry import SE2, CameraModel
from protocol.lab import CameraSpec, Lab, VehicleSpec


def true_floor_tags(lab: Lab, seed: int) -> dict[int, SE2]:
    """Where the floor tags truly lie (map frame): x and y put off by `survey.floor_tag_m`, yaw by `survey.floor_tag_rad`."""
    rng, turns = _stream(seed, "floor tags"), _stream(seed, "floor tags' headings")
    survey = lab.simulation.survey
    poses: dict[int, SE2] = {}
    for tag_id in sorted(lab.floor_tags.poses):
        x, y, yaw = lab.floor_tags.poses[tag_id]
        dx, dy = rng.standard_normal(2) * survey.floor_tag_m
        turn = survey.floor_tag_rad * float(turns.standard_normal())
        poses[tag_id] = SE2(x + float(dx), y + float(dy), yaw + turn)
    return poses


def true_camera_model(lab: Lab, camera: CameraSpec, seed: int) -> CameraModel:
    """The lens as it is: focal lengths off by the relative `survey.focal`, the principal point by `survey.center_px`."""
    rng, survey = _stream(seed, f"lens of {camera.id}"), lab.simulation.survey
    model = camera.model()
    scale = 1.0 + survey.focal * float(rng.standard_normal())
    dx, dy = rng.standard_normal(2) * survey.center_px
    return replace(model, fx=model.fx * scale, fy=model.fy * scale, cx=model.cx + float(dx), cy=model.cy + float(dy))


def true_vehicle(lab: Lab, vehicle: VehicleSpec, seed: int) -> VehicleSpec:
    """The vehicle with its tag at its true height, off by `survey.tag_height_m`, never below the floor."""
    error_m = lab.simulation.survey.tag_height_m * float(_stream(seed, f"tag of {vehicle.id}").standard_normal())
    height_m = max(0.0, vehicle.tag.height_m + error_m)
    return vehicle.model_copy(update={"tag": vehicle.tag.model_copy(update={"height_m": height_m})})


def _stream(seed: int, name: str) -> np.random.Generator:
    return np.random.default_rng([seed, zlib.crc32(name.encode())])
