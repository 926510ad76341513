"""Where tags are looked for: no vehicle that a camera shows whole is left out, however the camera hangs."""

import math
from pathlib import Path

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from geometry import SE2, SE3
from localization.projection import CameraView, PointsAtInfinityError, undistort
from localization.tags import KnownTags, tag_corners
from localization.windows import guesses_from_tracks
from protocol.lab import load_lab
from protocol.messages import TrackedPose

GULLIVER = load_lab(Path("labs/gulliver.yaml"))
KNOWN = KnownTags.of(GULLIVER)
MODEL = GULLIVER.cameras[0].model()
STAMP_NS = 10**9


@given(
    across=st.floats(0.0, 1.0),
    down=st.floats(0.0, 1.0),
    yaw=st.floats(-math.pi, math.pi),
    tilt=st.floats(0.0, 1.3),
    turn=st.floats(-0.5, 0.5),
)
@example(across=0.02, down=0.5, yaw=0.0, tilt=0.0, turn=0.0)
@example(across=0.98, down=0.5, yaw=0.0, tilt=0.0, turn=0.0)
@example(across=0.5, down=0.035, yaw=0.0, tilt=0.0, turn=0.0)
@example(across=0.5, down=0.965, yaw=0.0, tilt=0.0, turn=0.0)
def test_a_tag_that_the_picture_shows_whole_has_a_window(
    across: float, down: float, yaw: float, tilt: float, turn: float
) -> None:
    view = CameraView(MODEL, SE3.from_rotvec((math.pi - tilt, turn, 0.0), (0.0, 0.0, 3.0)))
    (key, vehicle), *_ = KNOWN.vehicles.items()
    pixel = np.array([[across * (MODEL.width - 1), down * (MODEL.height - 1)]])
    try:
        x, y = view.hits(undistort(MODEL, pixel), vehicle.tag.height_m).points[0].tolist()
    except PointsAtInfinityError:
        return  # above the horizon
    tag = SE2(x, y, yaw)
    corners = np.column_stack([tag.apply(tag_corners(vehicle.tag.size_m)), np.full(4, vehicle.tag.height_m)])
    pixels, meant = view.project(corners)
    whole = meant.all() and ((pixels >= 0.0) & (pixels <= (MODEL.width - 1, MODEL.height - 1))).all()
    centre = tag @ vehicle.tag.pose_on_vehicle().inverse()
    pose = TrackedPose(
        vehicle.id, STAMP_NS, centre.x, centre.y, centre.yaw, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), ()
    )
    guesses = guesses_from_tracks(view, KNOWN, {vehicle.id: pose}, STAMP_NS)
    assert not whole or [guess.key for guess in guesses] == [key]
