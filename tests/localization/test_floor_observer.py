"""Floor obstacles on rendered frames: they appear, lie where they are, go away; robots and light leave nothing."""

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import SE2
from lab.objects import PALLET_LENGTH_M, PALLET_WIDTH_M, PERSON_RADIUS_M
from localization.floor import FloorObserver
from mapping.fusion import ObstacleMap
from mapping.grid import FloorGrid
from protocol.frames import Frame
from protocol.messages import SimulatedObject, TrackedPose
from tests.localization.floor_scene import LAB, Scene, distances, empty_world, pallet, true_extrinsics


@pytest.fixture
def scene() -> Scene:
    return Scene(FloorObserver(LAB, "cam0"))


@pytest.fixture
def learned(scene: Scene) -> Scene:
    """The floor is learned, nothing is on it."""
    grid = scene.run(1.2)
    assert not grid.occupied.any()
    assert grid.observed.mean() > 0.85
    return scene


def footprint(item: SimulatedObject, step_m: float = 0.02) -> NDArray[np.float64]:
    """Points all over a pallet's footprint (N, 2)."""
    along = np.arange(-PALLET_LENGTH_M / 2, PALLET_LENGTH_M / 2 + 1e-9, step_m)
    across = np.arange(-PALLET_WIDTH_M / 2, PALLET_WIDTH_M / 2 + 1e-9, step_m)
    x, y = np.meshgrid(along, across)
    return SE2(item.x, item.y, item.yaw).apply(np.column_stack((x.ravel(), y.ravel())))


def test_nothing_is_observed_before_the_floor_is_known(scene: Scene) -> None:
    first = next(scene.rasters(0.2))
    assert not first.observed.any()
    assert not first.occupied.any()


@pytest.mark.parametrize(("x", "y", "yaw"), [(1.0, 2.15, 0.0), (0.6, 3.9, 0.7), (1.7, 0.4, 1.57), (0.2, 1.6, -0.4)])
def test_a_pallet_appears_in_its_place_and_goes_away(learned: Scene, x: float, y: float, yaw: float) -> None:
    item = pallet(x, y, yaw)
    learned.world.put(item)
    appeared = list(learned.rasters(0.3))
    assert appeared[-1].occupied.any()
    body = footprint(item)
    for grid in [appeared[-1], *learned.rasters(1.0)]:
        cells = grid.occupied_centres()
        assert distances(body, cells).max() < 0.10, "part of the pallet is not marked"
        assert distances(cells, body).max() < 0.15, (
            "floor is marked that is free"
        )  # 14 cm high: its top falls farther out
    learned.world.remove("pallet")
    assert not list(learned.rasters(0.5))[-1].occupied.any()


DRIVES = {"wifibot-14": (0.5, 0.5), "wifibot-15": (0.6, -0.7), "turtlebot-16": (0.4, 0.8), "turtlebot-17": (0.1, -1.6)}


def test_driving_robots_are_no_obstacles(learned: Scene) -> None:
    for name, (x, y) in zip(DRIVES, [(0.6, 0.5), (1.2, 3.7), (1.2, 1.8), (0.4, 2.6)], strict=True):
        learned.world.place(name, SE2(x, y, 0.3))
    learned.run(0.1)  # the tracker's poses follow where they were put down
    learned.drives = DRIVES
    rasters = list(learned.rasters(12.0))
    assert sum(int(grid.occupied.sum()) for grid in rasters) == 0
    # They did hide floor, and drove: the hidden cells differ between the first and the last raster.
    assert (rasters[0].observed != rasters[-1].observed).any()


def test_what_a_robot_covers_is_not_observed(learned: Scene) -> None:
    before = learned.run(0.2)
    learned.world.place("wifibot-14", SE2(1.0, 3.4, 0.0))
    for _ in learned.rasters(0.2):
        pass
    grid = learned.run(0.3)
    body = [(0.85, 3.24), (1.15, 3.24), (1.15, 3.56), (0.85, 3.56)]
    assert grid.look(body).observed_share == 0.0
    # Its 35 cm hide floor behind it as seen from the camera over (1.00, 2.15), not before it.
    assert grid.look([(0.95, 3.57), (1.05, 3.57), (1.05, 3.7), (0.95, 3.7)]).observed_share == 0.0
    assert grid.look([(0.9, 2.9), (1.1, 2.9), (1.1, 3.1), (0.9, 3.1)]).observed_share == 1.0
    assert 0.01 < before.observed.mean() - grid.observed.mean() < 0.1


def test_a_robot_that_nobody_tracks_is_an_obstacle(learned: Scene) -> None:
    learned.world.place("wifibot-14", SE2(1.0, 3.4, 0.0))
    learned.with_poses = False
    grid = learned.run(0.3)
    assert len(grid.look([(0.85, 3.24), (1.15, 3.24), (1.15, 3.56), (0.85, 3.56)]).occupied) > 25


def test_a_pose_grows_old(learned: Scene) -> None:
    world = learned.world
    world.place("wifibot-14", SE2(1.0, 3.4, 0.0))
    pose = TrackedPose(
        "wifibot-14", world.stamp_ns, 1.0, 3.4, 0.0, 0.0, 0.0, 0.0, (1e-5, 0, 0, 1e-5, 0, 1e-4), ("cam0",)
    )
    occupied: list[tuple[float, bool]] = []
    for _ in range(24):
        frame = learned.frame()
        raster = learned.observer.observe(frame, learned.extrinsics, {"wifibot-14": pose})
        if raster is not None:
            age_s = (frame.stamp_ns - pose.stamp_ns) * 1e-9
            occupied.append((age_s, bool(FloorGrid.from_raster(raster).occupied.any())))
    assert not any(seen for age_s, seen in occupied if age_s <= 1.0)
    assert all(seen for age_s, seen in occupied if age_s > 1.0)


def test_a_robot_learned_with_the_floor_leaves_no_ghost(scene: Scene) -> None:
    scene.world.place("wifibot-14", SE2(1.0, 2.8, 0.4))
    scene.with_poses = False  # the tracker is not up yet
    assert not scene.run(1.2).occupied.any()
    scene.with_poses = True
    scene.run(0.3)
    scene.drives = {"wifibot-14": (0.5, -0.9)}
    grid = scene.run(3.5)
    robot = scene.world.truth().vehicles["wifibot-14"]
    assert SE2(robot.x, robot.y, 0.0).distance_to(SE2(1.0, 2.8, 0.0)) > 0.6
    assert not grid.occupied.any()
    assert grid.look([(0.85, 2.64), (1.15, 2.64), (1.15, 2.96), (0.85, 2.96)]).observed_share == 1.0


def test_no_floor_is_learned_under_a_robot_that_is_yet_to_be_tracked(scene: Scene) -> None:
    scene.world.place("wifibot-14", SE2(1.0, 2.8, 0.4))
    for _ in range(20):
        frame = scene.frame()
        raster = scene.observer.observe(frame, scene.extrinsics, {}, robots_are_known=False)
        assert raster is None or not FloorGrid.from_raster(raster).observed.any()
    scene.world.place("wifibot-14", SE2(-5.0, -5.0, 0.0))
    grid = scene.run(1.5)
    assert not grid.occupied.any()
    assert grid.look([(0.85, 2.64), (1.15, 2.64), (1.15, 2.96), (0.85, 2.96)]).observed_share == 1.0


@pytest.mark.parametrize("gain", [0.9, 1.1])
def test_another_exposure_is_no_obstacle_and_hides_none(learned: Scene, gain: float) -> None:
    learned.gain = gain
    for grid in learned.rasters(1.0):
        assert not grid.occupied.any()
        assert grid.observed.mean() > 0.85
    learned.world.put(pallet(1.0, 3.0))
    assert learned.run(0.3).look([(0.8, 2.9), (1.2, 2.9), (1.2, 3.1), (0.8, 3.1)]).blocked
    learned.world.remove("pallet")
    learned.gain = 1.0
    assert not learned.run(0.5).occupied.any()


def test_light_that_fades_slowly_is_no_obstacle(learned: Scene) -> None:
    for _ in range(20):
        learned.gain *= 0.975
        assert not learned.run(0.4).occupied.any()
    assert learned.gain < 0.65
    learned.world.put(pallet(1.0, 3.0))
    assert learned.run(0.3).look([(0.8, 2.9), (1.2, 2.9), (1.2, 3.1), (0.8, 3.1)]).blocked


def test_in_the_dark_nothing_is_observed(learned: Scene) -> None:
    learned.gain = 0.02
    for grid in learned.rasters(0.6):
        assert not grid.observed.any()
    learned.gain = 1.0
    grid = learned.run(0.3)
    assert grid.observed.mean() > 0.85
    assert not grid.occupied.any()


def test_a_walking_person_is_followed(learned: Scene) -> None:
    person = SimulatedObject(id="anna", kind="person", x=1.5, y=0.4, path=((0.6, 2.1), (1.4, 3.9)), speed_mps=1.3)
    learned.world.put(person)
    learned.run(0.2)
    walked: list[float] = []
    for grid in learned.rasters(2.5):
        truth = next(item for item in learned.world.snapshot().objects if item.id == "anna")
        cells = grid.occupied_centres()
        foot = np.array([[truth.x, truth.y]])
        assert len(cells) > 0
        assert distances(foot, cells)[0] < PERSON_RADIUS_M, "nothing is marked where the person stands"
        # All that is marked lies within the person's shape: from the foot away from the camera, at most to its head's place.
        eye = np.array([1.0, 2.15])
        head = eye + (foot[0] - eye) * 3.0 / (3.0 - 1.72)
        along = foot + np.linspace(0, 1, 60)[:, None] * (head - foot)
        assert distances(cells, along).max() < 0.7
        walked.append(truth.y)
    assert max(walked) - min(walked) > 2.0
    learned.world.remove("anna")
    assert not learned.run(0.5).occupied.any()


def test_a_standing_person_is_never_learned(learned: Scene) -> None:
    learned.world.put(SimulatedObject(id="anna", kind="person", x=0.8, y=1.5))
    first = learned.run(0.3)
    last = learned.run(20.0)
    assert np.count_nonzero(first.occupied ^ last.occupied) <= 0.1 * np.count_nonzero(first.occupied)


@pytest.mark.parametrize(("rate_hz", "rasters"), [(60, 7.5), (30, 7.5), (15, 7.5), (10, 5.0), (5, 5.0)])
def test_frames_are_sampled(scene: Scene, rate_hz: float, rasters: float) -> None:
    frame = scene.frame()
    stamps = [frame.stamp_ns + round(index * 1e9 / rate_hz) for index in range(round(4 * rate_hz))]
    seen = [scene.observer.observe(Frame(1, stamp, frame.pixels), scene.extrinsics, {}) for stamp in stamps]
    taken = [raster.stamp_ns for raster in seen if raster is not None]
    assert len(taken) == pytest.approx(4 * rasters, abs=1)
    assert set(taken) <= set(stamps)


def test_a_recording_that_starts_over_goes_on(learned: Scene) -> None:
    frame = learned.frame()
    back = Frame(1, frame.stamp_ns - 3_600_000_000_000, frame.pixels)
    raster = learned.observer.observe(back, learned.extrinsics, {})
    assert raster is not None
    assert raster.stamp_ns == back.stamp_ns
    assert FloorGrid.from_raster(raster).observed.any()


@pytest.mark.parametrize("shape", [(1080, 1920), (540, 961), (540, 1)])
def test_a_frame_of_another_size_is_refused(learned: Scene, shape: tuple[int, int]) -> None:
    frame = Frame(1, learned.world.stamp_ns + 10**9, np.zeros(shape, np.uint8))
    with pytest.raises(ValueError, match=rf"cam0.*{shape[1]} x {shape[0]}.*960 x 540"):
        learned.observer.observe(frame, learned.extrinsics, {})
    assert learned.run(0.3).observed.any()


def test_a_colour_camera_sees_the_same(scene: Scene) -> None:
    def colour(frame: Frame) -> Frame:
        return Frame(frame.number, frame.stamp_ns, np.repeat(frame.pixels[..., None], 3, axis=2))

    grid = None
    for index in range(26):
        if index == 20:
            scene.world.put(pallet(1.0, 3.0))
        raster = scene.observer.observe(colour(scene.frame()), scene.extrinsics, {})
        grid = grid if raster is None else FloorGrid.from_raster(raster)
        if index == 19:
            assert grid is not None
            assert grid.observed.any()
            assert not grid.occupied.any()
    assert grid is not None
    assert grid.look([(0.8, 2.9), (1.2, 2.9), (1.2, 3.1), (0.8, 3.1)]).blocked


def test_a_camera_that_was_moved_learns_anew(learned: Scene) -> None:
    x, y, z = learned.extrinsics.translation
    learned.extrinsics = true_extrinsics("cam0")
    slightly = true_extrinsics("cam0").__class__("cam0", 2, learned.extrinsics.rotvec, (x + 0.002, y, z), 0.1, (0, 1))
    raster = None
    while raster is None:
        raster = learned.observer.observe(learned.frame(), slightly, {})
    assert FloorGrid.from_raster(raster).observed.any(), "a slightly better calibration must not cost the background"
    far = slightly.__class__("cam0", 3, slightly.rotvec, (x + 0.1, y, z), 0.1, (0, 1))
    raster = None
    while raster is None:
        raster = learned.observer.observe(learned.frame(), far, {})
    assert not FloorGrid.from_raster(raster).observed.any()


def test_two_cameras_agree_where_a_thing_stands() -> None:
    """Between two cameras a person smears away from each; together they keep the foot and cut the smears. A pallet loses
    nothing."""
    world = empty_world()
    left = Scene(FloorObserver(LAB, "cam0"), "cam0", world)
    right = Scene(FloorObserver(LAB, "cam1"), "cam1", world)
    obstacles = ObstacleMap(FloorGrid.covering(LAB.bounds()), ["cam0", "cam1"])
    for scene in (left, right):
        obstacles.place_camera(scene.camera, *scene.extrinsics.translation[:2])

    def look(seconds: float) -> tuple[FloorGrid, FloorGrid]:
        """The merged map, and all that either camera marks."""
        union = FloorGrid.covering(LAB.bounds())
        for _ in range(round(seconds * 7.5)):
            union = FloorGrid.covering(LAB.bounds())
            for scene in (left, right):
                raster = None
                while raster is None:
                    raster = scene.step()
                obstacles.add(raster)
                union = union.merged(FloorGrid.from_raster(raster))
        return obstacles.merged(world.stamp_ns), union

    assert not look(1.2)[0].occupied.any()
    item = pallet(2.0, 2.6, 0.3)
    world.put(item)
    merged, _ = look(0.4)
    assert distances(footprint(item), merged.occupied_centres()).max() < 0.1
    world.remove("pallet")
    world.put(SimulatedObject(id="anna", kind="person", x=2.0, y=2.3))
    merged, union = look(0.4)
    assert distances(np.array([[2.0, 2.3]]), merged.occupied_centres())[0] < 0.1
    assert np.count_nonzero(merged.occupied) < np.count_nonzero(union.occupied)
    world.remove("anna")
    assert not look(0.4)[0].occupied.any()
