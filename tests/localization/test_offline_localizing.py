"""From pictures to poses, over a scene drawn by the tests' own renderer: rates and stamps as they come, cameras that move."""

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import SE2, SE3
from localization.offline import (
    CalibrationFileError,
    Localization,
    calibrated,
    calibration_text,
    look_at_floors,
    open_recording,
    read_calibration,
)
from localization.tags import KnownTags
from protocol.lab import Lab, parse_lab
from protocol.messages import Calibration, TrackedPose
from tests.localization.synthetic import MOUNTS, SMALL_LAB, draw, floor_tags, render, vehicle_tag

STANDING = SE2(0.75, 0.5, 1.0)
LAB_TEXT = SMALL_LAB[: SMALL_LAB.index("simulation:")]
Truth = dict[tuple[int, str], SE2]


@pytest.fixture
def lab() -> Lab:
    return parse_lab(LAB_TEXT, recorded=True)


def driving(seconds: float) -> SE2:
    """Along the floor, in and out of both views, at 0.8 m/s."""
    return SE2(0.3 + 0.8 * seconds, 0.5 + 0.2 * math.sin(1.5 * seconds), math.atan2(0.3 * math.cos(1.5 * seconds), 0.8))


def no_bump(_camera: str, _seconds: float) -> SE3:
    return SE3.identity()


def written(
    path: Path,
    lab: Lab,
    *,
    rate_hz: float,
    seconds: float,
    start_ns: int = 0,
    apart: float = 0.0,
    bump: Callable[[str, float], SE3] = no_bump,
) -> Truth:
    """Pictures of both cameras, the second one's `apart` periods later; returns where the vehicles were."""
    truth: Truth = {}
    floors: dict[tuple[str, bytes], NDArray[np.float32]] = {}
    for index, camera in enumerate(MOUNTS):
        (path / camera).mkdir(parents=True)
        model = lab.camera(camera).model()
        for number in range(round(seconds * rate_hz)):
            t = (number + index * apart) / rate_hz
            stamp_ns = start_ns + round(t * 1e9)
            mount = MOUNTS[camera] @ bump(camera, t)
            key = camera, mount.as_matrix().tobytes()
            if key not in floors:
                floors[key] = draw(model, mount, floor_tags(lab))
            places = {"robot-10": driving(t), "robot-11": STANDING}
            tags = [vehicle_tag(lab, vehicle, pose) for vehicle, pose in places.items()]
            picture = render(model, mount, tags, seed=2 * number + index, background=floors[key])
            cv2.imwrite(str(path / camera / f"{stamp_ns}.jpg"), picture, [cv2.IMWRITE_JPEG_QUALITY, 85])
            truth |= {(stamp_ns, vehicle): pose for vehicle, pose in places.items()}
    return truth


def localized(path: Path, lab: Lab, threads: int = 2) -> tuple[list[TrackedPose], list[str], Calibration]:
    recording = open_recording(path, lab)
    with ThreadPoolExecutor(threads) as executor:
        calibration, problems = calibrated(lab, look_at_floors(recording.cameras, KnownTags.of(lab), executor))
        run = Localization(lab, recording, calibration, executor)
        poses = [pose for instant in run.poses() for pose in instant]
    return poses, [*recording.warnings, *problems, *run.statistics.warnings.values()], calibration


def errors_mm(poses: list[TrackedPose], truth: Truth) -> list[float]:
    exact = [truth[pose.stamp_ns, pose.vehicle] for pose in poses]
    return [1e3 * math.hypot(p.x - e.x, p.y - e.y) for p, e in zip(poses, exact, strict=True)]


@pytest.mark.parametrize(
    ("rate_hz", "seconds", "start_ns", "apart"),
    [(12.0, 2.0, 1_700_000_000_123_456_789, 0.3), (5.0, 3.5, 0, 0.0), (1.0, 4.0, 17, 0.5)],
)
def test_any_rate_and_any_beginning(
    tmp_path: Path, lab: Lab, rate_hz: float, seconds: float, start_ns: int, apart: float
) -> None:
    truth = written(tmp_path, lab, rate_hz=rate_hz, seconds=seconds, start_ns=start_ns, apart=apart)
    poses, warnings, _ = localized(tmp_path, lab)
    assert warnings == []
    assert len({(pose.stamp_ns, pose.vehicle) for pose in poses}) == len(poses)
    standing = [pose for pose in poses if pose.vehicle == "robot-11"]
    assert len(standing) == round(rate_hz * seconds), "seen by one camera, in each of its frames"
    moving = [pose for pose in poses if pose.vehicle == "robot-10"]
    assert len(moving) >= round(rate_hz * seconds) * 0.9
    assert float(np.median(errors_mm(poses, truth))) <= 0.3
    assert max(errors_mm(poses, truth)) <= 2.0


def test_cameras_that_share_a_capture_time_share_a_pose(tmp_path: Path, lab: Lab) -> None:
    written(tmp_path, lab, rate_hz=10.0, seconds=2.5)
    poses, _, _ = localized(tmp_path, lab)
    assert ("left", "right") in {pose.cameras for pose in poses}


def test_the_result_does_not_depend_on_the_number_of_threads(tmp_path: Path, lab: Lab) -> None:
    written(tmp_path, lab, rate_hz=10.0, seconds=1.5, apart=0.4)
    assert localized(tmp_path, lab, threads=1)[0] == localized(tmp_path, lab, threads=4)[0]


def test_a_camera_that_is_moved_says_so_and_finds_its_place_again(tmp_path: Path, lab: Lab) -> None:
    def bump(camera: str, seconds: float) -> SE3:
        return (
            SE3.from_rotvec([0.0, 0.02, 0.01], [0.02, 0.0, 0.0])
            if camera == "left" and seconds >= 1.45
            else no_bump(camera, seconds)
        )

    truth = written(tmp_path, lab, rate_hz=15.0, seconds=4.0, bump=bump)
    poses, warnings, _ = localized(tmp_path, lab)
    assert any(warning.startswith("left was moved while recording, seen at ") for warning in warnings)
    before = [pose for pose in poses if pose.vehicle == "robot-11" and pose.stamp_ns < 1.4e9]
    after = [pose for pose in poses if pose.vehicle == "robot-11" and pose.stamp_ns > 3.4e9]
    assert len(before) >= 20 and len(after) >= 8
    assert max(errors_mm(before, truth)) <= 1.0
    assert max(errors_mm(after, truth)) <= 2.0


def test_a_camera_without_floor_tags_is_named_and_the_other_goes_on(tmp_path: Path, lab: Lab) -> None:
    truth = written(tmp_path, lab, rate_hz=5.0, seconds=1.0)
    for file in (tmp_path / "right").iterdir():
        cv2.imwrite(str(file), np.full((540, 960), 80, np.uint8))
    poses, warnings, calibration = localized(tmp_path, lab)
    assert warnings == ["right is not calibrated and gives no poses: it sees no floor tag"]
    assert list(calibration.cameras) == ["left"]
    assert {pose.cameras for pose in poses} == {("left",)}
    assert max(errors_mm(poses, truth)) <= 1.0


def test_a_calibration_is_kept_in_a_file_and_void_in_another_room(tmp_path: Path, lab: Lab) -> None:
    written(tmp_path / "recording", lab, rate_hz=5.0, seconds=1.0)
    _, _, calibration = localized(tmp_path / "recording", lab)
    file = tmp_path / "calibration.json"
    file.write_bytes(calibration_text(calibration))
    assert read_calibration(file, lab) == calibration
    elsewhere = parse_lab(LAB_TEXT.replace("1: [0.0, 1.0, 1.5708]", "1: [0.0, 1.1, 1.5708]"), recorded=True)
    with pytest.raises(CalibrationFileError, match="floor tags described otherwise"):
        read_calibration(file, elsewhere)
    other_lens = parse_lab(LAB_TEXT.replace("fx: 620.0", "fx: 640.0"), recorded=True)
    with pytest.raises(CalibrationFileError, match="left was calibrated with another size or other intrinsics"):
        read_calibration(file, other_lens)
    file.write_text("{}")
    with pytest.raises(CalibrationFileError, match=r"calibration\.json is not a Calibration"):
        read_calibration(file, lab)
    with pytest.raises(CalibrationFileError, match="cannot be read"):
        read_calibration(tmp_path / "none.json", lab)
