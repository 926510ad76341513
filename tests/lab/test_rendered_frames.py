"""Rendered frames: reproducible, complete, with the sensor's faults, and nothing left behind by what moved away."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lab.rendering import CameraRenderer
from lab.snapshot import ObjectSnapshot, Snapshot, VehicleSnapshot
from lab.world import World
from protocol.lab import Lab, SimulatedMount
from protocol.messages import SimulatedObject
from tests.lab.oracle import detected
from tests.lab.rooms import gulliver, standing

EMPTY = standing()


def small_lab(*, color: bool = False, **knobs: float) -> Lab:
    """One camera of 480 x 270 pixels at the shipped room's first place."""
    lab = gulliver(image=knobs)
    model = lab.cameras[0].intrinsics.model_copy(update={"fx": 286.0, "fy": 286.0, "cx": 240.0, "cy": 135.0})
    camera = lab.cameras[0].model_copy(update={"width": 480, "height": 270, "color": color, "intrinsics": model})
    return lab.model_copy(update={"cameras": (camera,)})


def person(x: float, y: float) -> ObjectSnapshot:
    return ObjectSnapshot("ann", "person", x, y, 0.0, 0.0)


def differing(a: NDArray[np.uint8], b: NDArray[np.uint8]) -> int:
    """How many pixels differ."""
    return int((a != b).sum())


def test_the_same_story_gives_the_same_pixels() -> None:
    def story(seed: int) -> list[bytes]:
        lab = small_lab()
        world, renderer = World(lab, seed), CameraRenderer(lab, "cam0", seed)
        world.put(SimulatedObject(id="ann", kind="person", x=0.5, y=2.0, path=((1.5, 2.0),), speed_mps=1.0))
        frames: list[bytes] = []
        for number in range(4):
            world.set_drive("wifibot-14", 0.4, 0.3)
            world.run(0.1)
            frames.append(renderer.render(world.snapshot(), number).tobytes())
        return frames

    first = story(3)
    assert story(3) == first
    assert story(4) != first


def test_a_frame_depends_on_nothing_but_its_number_and_instant() -> None:
    lab = small_lab()
    instant = standing(("wifibot-14", 1.0, 1.0, 0.4))
    busy = CameraRenderer(lab, "cam0")
    for number in range(3):
        busy.render(standing(("wifibot-14", 0.5 + number * 0.3, 2.0, 1.0), ("turtlebot-16", 1.2, 1.5, 0.0)), number)
    assert differing(busy.render(instant, 9), CameraRenderer(lab, "cam0").render(instant, 9)) == 0


def test_nothing_stays_behind() -> None:
    renderer = CameraRenderer(small_lab(noise_std=0.0), "cam0")
    empty = renderer.render(EMPTY, 0)
    full = renderer.render(Snapshot(0, (), (person(1.0, 2.0), ObjectSnapshot("p", "pallet", 0.5, 1.0, 0.3, 0.0))), 1)
    assert differing(empty, full) > 1000
    assert differing(empty, renderer.render(EMPTY, 2)) == 0


def test_noise_is_as_strong_as_described_and_new_in_each_frame() -> None:
    noisy, clean = CameraRenderer(small_lab(noise_std=3.0), "cam0"), CameraRenderer(small_lab(noise_std=0.0), "cam0")
    floor = clean.render(EMPTY, 1).astype(float)
    first, second = noisy.render(EMPTY, 1) - floor, noisy.render(EMPTY, 2) - floor
    assert first.std() == pytest.approx(3.0, rel=0.05)
    assert abs(first.mean()) < 0.05
    assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.02


def test_exposure_and_the_fall_of_the_light() -> None:
    even = CameraRenderer(small_lab(noise_std=0.0, lighting_gradient=0.0), "cam0").render(EMPTY, 0).astype(float)
    dim = CameraRenderer(small_lab(noise_std=0.0, lighting_gradient=0.0, exposure=0.5), "cam0").render(EMPTY, 0)
    assert dim.mean() == pytest.approx(0.5 * even.mean(), rel=0.02)
    falling = CameraRenderer(small_lab(noise_std=0.0, lighting_gradient=0.6), "cam0").render(EMPTY, 0)
    # The image's y axis points against the room's length, from light (small x) to dark.
    ratio = falling.mean(axis=1) / even.mean(axis=1)
    assert abs(ratio[0] - ratio[-1]) > 0.1


def test_more_blur_makes_softer_edges() -> None:
    sharp, soft = (
        CameraRenderer(small_lab(noise_std=0.0, blur_sigma_px=s), "cam0").render(EMPTY, 0) for s in (0.0, 2.0)
    )
    steepest = [int(np.abs(np.diff(frame.astype(int), axis=1)).max()) for frame in (sharp, soft)]
    assert steepest[1] < 0.5 * steepest[0]


def test_colour_frames_show_the_same_scene() -> None:
    snapshot = Snapshot(0, standing(("wifibot-14", 1.0, 1.0, 0.4)).vehicles, (person(1.2, 2.5),))
    grey = CameraRenderer(small_lab(noise_std=0.0), "cam0").render(snapshot, 0)
    colour = CameraRenderer(small_lab(color=True, noise_std=0.0), "cam0").render(snapshot, 0)
    assert grey.shape == (270, 480)
    assert colour.shape == (270, 480, 3)
    assert np.abs(colour @ np.array([0.114, 0.587, 0.299]) - grey).max() < 6.0
    assert int(colour.max(axis=2).astype(int).max() - colour.min(axis=2).astype(int).min()) > 30


def test_a_person_hides_the_vehicle_behind() -> None:
    lab = gulliver()
    renderer = CameraRenderer(lab, "cam0")
    robot = VehicleSnapshot("wifibot-14", 1.0, 3.6, 0.0, 0.0, 0.0)
    assert 14 in detected(renderer.render(Snapshot(0, (robot,), ()), 1))
    assert 14 not in detected(renderer.render(Snapshot(0, (robot,), (person(1.0, 3.1),)), 2)), "in between"
    assert 14 in detected(renderer.render(Snapshot(0, (robot,), (person(1.0, 4.2),)), 3)), "behind"


@pytest.mark.parametrize("x", [-1.6, -1.0, -0.6, -0.3, 1.0, 2.3, 2.6, 3.0, 3.6])
def test_things_at_and_beyond_the_border_are_cut(x: float) -> None:
    renderer = CameraRenderer(small_lab(noise_std=0.0), "cam0")
    vehicle = VehicleSnapshot("wifibot-14", x, 2.0, 0.3, 0.3, 0.2)
    objects = (person(x, 2.7), ObjectSnapshot("p", "pallet", x, 1.2, 0.3, 0.0))
    frame = renderer.render(Snapshot(0, (vehicle,), objects), 1)
    changed = differing(frame, renderer.render(EMPTY, 2))
    assert (changed > 0) == (-0.7 < x < 2.7)


def test_what_reaches_up_to_the_camera_is_left_out() -> None:
    lab = small_lab(noise_std=0.0)
    low = lab.simulation.model_copy(update={"mounts": {"cam0": SimulatedMount(position=(1.0, 2.0, 1.5))}})
    renderer = CameraRenderer(lab.model_copy(update={"simulation": low}), "cam0")
    empty = renderer.render(EMPTY, 0)
    assert differing(renderer.render(Snapshot(0, (), (person(1.0, 2.0),)), 1), empty) == 0


def test_a_covered_and_a_frozen_camera() -> None:
    renderer = CameraRenderer(small_lab(), "cam0")
    renderer.covered = (0, 0, 240, 270)
    covered = renderer.render(EMPTY, 1)
    assert covered[:, :240].mean() < 20 < covered[:, 240:].mean()
    renderer.covered = None
    assert renderer.render(EMPTY, 2)[:, :240].mean() > 30
    renderer.frozen = True
    frozen = renderer.render(EMPTY, 3)
    assert differing(renderer.render(standing(("wifibot-14", 1.0, 1.0, 0.0)), 4), frozen) == 0
    renderer.frozen = False
    assert differing(renderer.render(standing(("wifibot-14", 1.0, 1.0, 0.0)), 5), frozen) > 1000


def test_the_caller_may_bring_the_memory() -> None:
    renderer = CameraRenderer(small_lab(), "cam0")
    out = np.zeros(renderer.shape, dtype=np.uint8)
    assert renderer.render(EMPTY, 1, out) is out
    assert differing(out, renderer.render(EMPTY, 1)) == 0


def test_a_camera_that_is_not_simulated_is_named() -> None:
    with pytest.raises(KeyError, match="cam9"):
        CameraRenderer(gulliver(), "cam9")
    with pytest.raises(ValueError, match=r"cam1.*mounts"):
        CameraRenderer(gulliver(mounts={}), "cam1")
