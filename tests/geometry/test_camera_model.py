"""The camera data type refuses what no camera has."""

import numpy as np
import pytest

from geometry import CameraModel


def test_matrix_and_distortion_have_opencvs_layout() -> None:
    model = CameraModel(1920, 1080, 1145.0, 1146.0, 960.0, 540.0, (0.1, -0.2, 0.001, 0.002, 0.05))
    assert np.array_equal(model.matrix(), [[1145.0, 0.0, 960.0], [0.0, 1146.0, 540.0], [0.0, 0.0, 1.0]])
    assert model.distortion_array().tolist() == [0.1, -0.2, 0.001, 0.002, 0.05]


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"width": 0}, "does not exist"),
        ({"fx": -1.0}, "positive"),
        ({"cx": float("nan")}, "finite"),
        ({"distortion": (0.0, float("inf"), 0.0, 0.0, 0.0)}, "finite"),
    ],
)
def test_impossible_cameras_are_refused(kwargs: dict[str, object], message: str) -> None:
    good: dict[str, object] = {"width": 640, "height": 480, "fx": 500.0, "fy": 500.0, "cx": 320.0, "cy": 240.0}
    with pytest.raises(ValueError, match=message):
        CameraModel(**(good | kwargs))  # pyright: ignore[reportArgumentType]  # deliberately loose keyword arguments
