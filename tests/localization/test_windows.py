"""Where tags are looked for: no vehicle that a camera shows whole is left out, however the camera hangs."""

import math
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geometry import SE2, SE3
from localization.projection import CameraView
from localization.tags import KnownTags, tag_corners
from localization.windows import guesses_from_tracks
from protocol.lab import load_lab
from protocol.messages import TrackedPose

GULLIVER = load_lab(Path("labs/gulliver.yaml"))
KNOWN = KnownTags.of(GULLIVER)
MODEL = GULLIVER.cameras[0].model()
STAMP_NS = 10**9


@given(
    x=st.floats(-6.0, 6.0),
    y=st.floats(-6.0, 6.0),
    yaw=st.floats(-math.pi, math.pi),
    tilt=st.floats(0.0, 1.3),
    turn=st.floats(-0.5, 0.5),
)
def test_a_tag_that_the_picture_shows_whole_has_a_window(
    x: float, y: float, yaw: float, tilt: float, turn: float
) -> None:
    view = CameraView(MODEL, SE3.from_rotvec((math.pi - tilt, turn, 0.1), (0.0, 0.0, 3.0)))
    (key, vehicle), *_ = KNOWN.vehicles.items()
    pose = TrackedPose(vehicle.id, STAMP_NS, x, y, yaw, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), ())
    flat = (SE2(x, y, yaw) @ vehicle.tag.pose_on_vehicle()).apply(tag_corners(vehicle.tag.size_m))
    corners = np.column_stack([flat, np.full(4, vehicle.tag.height_m)])
    pixels, meant = view.project(corners)
    inside = (pixels >= 0.0) & (pixels <= (MODEL.width - 1, MODEL.height - 1))
    guessed = {guess.key for guess in guesses_from_tracks(view, KNOWN, {vehicle.id: pose}, STAMP_NS)}
    if meant.all() and inside.all():
        assert guessed == {key}
    elif not meant.any():
        assert not guessed
