"""The pipeline on synthetic pictures: when it searches where, hand-over by tracks, what it refuses."""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import SE2
from localization.calibration import SelfCalibration
from localization.detection import FullSearch
from localization.pipeline import CameraPipeline, PipelineOptions
from localization.projection import extrinsics_pose
from localization.tracking import Tracker
from protocol.clock import SimulatedClock
from protocol.frames import Frame
from protocol.messages import CameraExtrinsics, FrameDetections, TrackedPose
from tests.localization.synthetic import MOUNTS, PlacedTag, draw, floor_tags, render, small_lab, vehicle_tag

LAB = small_lab()
MODEL = LAB.camera("left").model()
PERIOD_NS = 66_666_667
START_NS = 1_000_000_000_000


def truth(camera: str) -> CameraExtrinsics:
    T = MOUNTS[camera]
    rx, ry, rz = (float(v) for v in T.rotvec())
    x, y, z = (float(v) for v in T.translation)
    return CameraExtrinsics(camera, 0, (rx, ry, rz), (x, y, z), 0.05, (0, 1, 2, 3))


@cache
def floor(camera: str) -> NDArray[np.float32]:
    return draw(MODEL, MOUNTS[camera], floor_tags(LAB))


@cache
def pixels(camera: str, vehicles: tuple[tuple[str, SE2], ...]) -> NDArray[np.uint8]:
    tags = [vehicle_tag(LAB, name.replace("_", "-"), pose) for name, pose in vehicles]
    return render(MODEL, MOUNTS[camera], tags, background=floor(camera))


def picture(number: int, camera: str = "left", **vehicles: SE2) -> Frame:
    """The camera's frame of that number with robots at poses (robot_10=SE2(...))."""
    return Frame(number, START_NS + number * PERIOD_NS, pixels(camera, tuple(vehicles.items())))


def pipeline(camera: str = "left", every: int | None = None, *, stored: bool = True) -> CameraPipeline:
    options = PipelineOptions(full_search_every=every, calibration_frames=3)
    extrinsics = truth(camera) if stored else None
    return CameraPipeline(LAB, camera, clock=SimulatedClock(), options=options, extrinsics=extrinsics)


def settled(every: int) -> CameraPipeline:
    """A pipeline that checked its stored calibration and follows robot-10."""
    camera = pipeline(every=every)
    for number in range(3):
        camera.process(picture(number, robot_10=SE2(0.7, 0.5, 0.2)))
    return camera


def ids(detections: FrameDetections) -> set[int]:
    return {detection.tag_id for detection in detections.detections}


def track_of(vehicle: str, pose: SE2, stamp_ns: int, vx: float = 0.0) -> TrackedPose:
    covariance = (1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6)
    return TrackedPose(vehicle, stamp_ns, pose.x, pose.y, pose.yaw, vx, 0.0, 0.0, covariance, cameras=("right",))


def test_it_calibrates_itself_and_finds_the_vehicle_where_it_is() -> None:
    camera = pipeline(stored=False)
    pose = SE2(0.8, 0.6, 1.1)
    first = camera.process(picture(0, robot_10=pose))
    assert first.detections == ()
    assert camera.extrinsics is None
    for number in (1, 2):
        camera.process(picture(number, robot_10=pose))
    assert camera.extrinsics is not None
    assert camera.floor_tags_seen == (0, 1, 2, 3)
    off = extrinsics_pose(camera.extrinsics).translation - MOUNTS["left"].translation
    assert abs(off).max() < 0.002
    (found,) = camera.process(picture(3, robot_10=pose)).detections
    tag = vehicle_tag(LAB, "robot-10", pose).pose
    assert math.hypot(found.x - tag.x, found.y - tag.y) < 0.002
    assert abs(math.degrees(found.yaw - tag.yaw)) < 0.3
    (seen,) = [tag for tag in camera.tags if tag.tag_id == 10]
    assert np.array_equal(np.array(found.corners_px), seen.corners)
    assert {tag.tag_id for tag in camera.tags} == {0, 1, 2, 3, 10}


def test_every_kth_frame_is_searched_as_a_whole() -> None:
    camera = settled(every=4)
    pattern = [camera.process(picture(n, robot_10=SE2(0.7, 0.5, 0.2))).full_search for n in range(3, 15)]
    assert sum(pattern) == 3
    assert all(pattern[i] == pattern[i + 4] for i in range(8))


def test_cameras_take_turns_with_their_full_searches() -> None:
    left, right = pipeline("left", every=8), pipeline("right", every=8)
    for camera in (left, right):  # checks of stored calibrations come first
        for number in range(3):
            camera.process(picture(number, camera.spec.id, robot_10=SE2(1.5, 0.5, 0.0)))
    fresh = SE2(1.5, 0.5, 0.0)
    due = {
        camera.spec.id: [
            n for n in range(3, 19) if camera.process(picture(n, camera.spec.id, robot_10=fresh)).full_search
        ]
        for camera in (left, right)
    }
    assert all(b - a == 8 for a, b in due.values())
    assert abs(due["left"][0] - due["right"][0]) == 4


def test_a_newcomer_is_found_by_its_track_without_a_full_search() -> None:
    """Hand-over: the other camera's track says where it comes in."""
    camera = settled(every=1000)
    standing, arriving = SE2(0.7, 0.5, 0.2), SE2(1.5, 0.6, 3.0)
    without = camera.process(picture(3, robot_10=standing, robot_11=arriving))
    assert not without.full_search
    assert ids(without) == {10}
    tracks = {"robot-11": track_of("robot-11", SE2(1.56, 0.6, 3.0), START_NS + 3 * PERIOD_NS, vx=-0.9)}
    with_track = camera.process(picture(4, robot_10=standing, robot_11=arriving), tracks)
    assert not with_track.full_search
    assert ids(with_track) == {10, 11}


def test_stale_and_unknown_tracks_are_ignored() -> None:
    camera = settled(every=1000)
    stale = track_of("robot-11", SE2(1.2, 0.6, 3.0), START_NS - 10**9)
    unknown = track_of("stranger", SE2(1.2, 0.6, 3.0), START_NS + 3 * PERIOD_NS)
    tracks = {"robot-11": stale, "stranger": unknown}
    found = camera.process(picture(3, robot_10=SE2(0.7, 0.5, 0.2), robot_11=SE2(1.2, 0.6, 3.0)), tracks)
    assert ids(found) == {10}


def test_without_tracks_it_follows_by_what_it_saw_last() -> None:
    camera = settled(every=1000)
    for number in range(3, 12):
        pose = SE2(0.7 + 0.06 * (number - 2), 0.5, 0.2)
        found = camera.process(picture(number, robot_10=pose))
        assert not found.full_search
        assert ids(found) == {10}


def test_a_track_that_does_not_know_its_speed_yet_is_helped_by_memory() -> None:
    """Just found, at its full speed: the track says that it stands where it was seen."""
    camera = settled(every=1000)
    track = {"robot-10": track_of("robot-10", SE2(0.7, 0.5, 0.2), START_NS + 2 * PERIOD_NS)}
    found = camera.process(picture(4, robot_10=SE2(0.83, 0.5, 0.2)), track)
    assert not found.full_search
    assert ids(found) == {10}


def test_what_was_hidden_for_a_second_is_found_again_without_a_full_search() -> None:
    camera = settled(every=1000)
    for number in range(3, 18):
        assert (
            ids(camera.process(picture(number), {"robot-11": track_of("robot-11", SE2(3, 0.5, 0), START_NS)})) == set()
        )
    tracks = {"robot-11": track_of("robot-11", SE2(3.0, 0.5, 0.0), START_NS + 18 * PERIOD_NS)}
    found = camera.process(picture(18, robot_10=SE2(0.8, 0.5, 0.2)), tracks)
    assert not found.full_search
    assert ids(found) == {10}


def test_while_nothing_is_tracked_every_frame_is_searched_and_later_a_few() -> None:
    camera = pipeline(every=16)
    searched = [camera.process(picture(number)).full_search for number in range(60)]
    assert all(searched[:28])
    assert 4 <= sum(searched[35:]) <= 8, "four times as often as K says"


@pytest.mark.parametrize("yaw", [-0.4, 0.35])
def test_a_tag_at_the_edge_is_right_or_not_given(yaw: float) -> None:
    """The detector also reads what is cut off a little, with a corner in the wrong place."""
    camera = settled(every=1)
    edge_x = float(MOUNTS["left"].translation[0]) + 1.9 * 478 / 620
    given = 0
    for step in range(30):
        pose = SE2(edge_x - 0.16 + 0.003 * step, 0.5, yaw)
        for found in camera.process(picture(3 + step, robot_10=pose)).detections:
            tag = vehicle_tag(LAB, "robot-10", pose).pose
            assert math.hypot(found.x - tag.x, found.y - tag.y) < 0.0005, f"step {step}"
            given += 1
    assert 2 <= given <= 20, "from wholly visible to hardly at all"


def test_two_prints_of_one_id_are_both_given() -> None:
    camera = settled(every=1)
    tags = [PlacedTag(10, SE2(x, 0.5, 0.1), 0.3, 0.16) for x in (0.4, 1.1)]
    frame = Frame(3, START_NS + 3 * PERIOD_NS, render(MODEL, MOUNTS["left"], tags))
    found = camera.process(frame).detections
    assert sorted(round(detection.x, 2) for detection in found) == [0.4, 1.1]


def test_a_tag_of_another_size_than_the_vehicle_s_is_no_vehicle() -> None:
    camera = settled(every=1)
    frame = Frame(3, START_NS, render(MODEL, MOUNTS["left"], [PlacedTag(10, SE2(0.7, 0.5, 0.1), 0.3, 0.24)]))
    assert camera.process(frame).detections == ()


def test_a_frame_of_another_size_is_refused() -> None:
    camera = pipeline()
    frame = picture(0)
    with pytest.raises(ValueError, match="a frame is 480 x 270, the lab description says 960 x 540"):
        camera.process(Frame(0, 0, frame.pixels[::2, ::2].copy()))


def test_stages_are_timed_and_the_capture_time_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SimulatedClock(start_ns=START_NS + 12_000_000)
    camera = CameraPipeline(LAB, "left", clock=clock, extrinsics=truth("left"))
    slow_find, slow_watch = FullSearch.find, SelfCalibration.observe

    def takes(seconds: float, function: Callable[..., object]) -> Callable[..., object]:
        def slow(*arguments: object) -> object:
            clock.wait(seconds)
            return function(*arguments)

        return slow

    monkeypatch.setattr(FullSearch, "find", takes(0.020, slow_find))
    monkeypatch.setattr(SelfCalibration, "observe", takes(0.001, slow_watch))
    result = camera.process(picture(0, robot_10=SE2(0.7, 0.5, 0.2)))
    assert result.timings_ms == pytest.approx(
        {"wait": 12.0, "window": 0.0, "full": 21.0, "undistort": 0.0, "pose": 0.0}
    )
    assert (result.stamp_ns, result.sent_ns) == (START_NS, START_NS + 33_000_000)


def test_a_drive_across_both_cameras_is_followed_within_millimetres() -> None:
    cameras = {name: pipeline(name) for name in MOUNTS}
    tracker = Tracker(LAB)
    poses: dict[str, TrackedPose] = {}
    errors: list[float] = []
    seen_by: set[tuple[str, ...]] = set()
    previous: tuple[float, float] | None = None
    for number in range(26):
        pose = SE2(0.3 + 0.09 * number, 0.5 + 0.1 * math.sin(number / 5), 0.3 * math.sin(number / 5))
        error = None
        for name, camera in cameras.items():
            found = camera.process(picture(number, name, robot_10=pose), poses)
            for tracked in tracker.update(found):
                poses[tracked.vehicle] = tracked
                seen_by.add(tracked.cameras)
                error = (tracked.x - pose.x, tracked.y - pose.y)
        assert error is not None, f"lost at frame {number}"
        errors.append(math.hypot(*error))
        if previous is not None:
            assert math.dist(error, previous) < 0.005
        previous = error
    assert {("left",), ("right",), ("left", "right")} <= seen_by
    assert sorted(errors)[len(errors) // 2] < 0.001
    assert max(errors) < 0.004
