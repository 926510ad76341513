"""Memory stays flat over some minutes of small frames; the benchmark's own arithmetic."""

import pytest

from launcher.paths import DEFAULT_LAB
from protocol.lab import Lab, load_lab
from tests.bench.memory import Memory, measure


def small(lab: Lab) -> Lab:
    """Two cameras of the room at a third of the resolution."""
    cameras: list[dict[str, object]] = []
    for camera in lab.cameras[:2]:
        lens = camera.intrinsics.model_copy(update={"fx": 381.7, "fy": 381.7, "cx": 319.67, "cy": 179.67})
        cameras.append(camera.model_copy(update={"width": 640, "height": 360, "intrinsics": lens}).model_dump())
    mounts = {camera.id: lab.simulation.mounts[camera.id] for camera in lab.cameras[:2]}
    simulation = {**lab.simulation.model_dump(), "mounts": mounts}
    return Lab.model_validate({**lab.model_dump(), "cameras": cameras, "simulation": simulation})


def test_growth_is_told_from_breathing() -> None:
    breathing = Memory(tuple(100.0 + number % 7 for number in range(200)), 27.0, 1)
    assert abs(breathing.growth_mb) < 2.0
    leaking = Memory(tuple(100.0 + 0.5 * number + number % 7 for number in range(200)), 27.0, 1)
    assert leaking.growth_mb == pytest.approx(80.0, abs=3.0)
    assert leaking.growth_mb_per_minute == pytest.approx(100.0 / 27.0, rel=0.1)


def test_memory_is_flat_over_minutes_of_frames() -> None:
    frames = 1000
    memory = measure(small(load_lab(DEFAULT_LAB)), frames)
    assert memory.poses > frames, "vehicles are followed all the time"
    assert memory.minutes == pytest.approx(1.0)
    assert memory.growth_mb < 4.0, memory.resident_mb
