"""Renders a recording of the simulated lab, faster or slower than real time: the vehicles drive the courses of the tracking
experiment, cameras take turns within a period as free-running ones do, and the truth is written beside the pictures."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future

from lab.rendering import CameraRenderer
from lab.snapshot import Snapshot
from lab.world import World
from launcher.experiments.tracking import start_vehicles
from launcher.recorder.folder import RecordingFolder
from protocol.lab import Lab

TruthRow = tuple[int, str, float, float, float, float, float]


class _Camera:
    """Renders and writes one frame at a time, while the world goes on."""

    def __init__(self, lab: Lab, index: int, camera: str, rate_hz: float | None, seed: int | None) -> None:
        self.id = camera
        self._renderer = CameraRenderer(lab, camera, seed)
        self._period_s = 1.0 / (rate_hz or self._renderer.spec.rate_hz)
        self._phase_s = index / len(lab.cameras) * self._period_s
        self._number = 0
        self._pending: Future[None] | None = None

    def is_due(self, elapsed_s: float) -> bool:
        return elapsed_s >= self._phase_s + self._number * self._period_s - 1e-9

    def shoot(self, snapshot: Snapshot, folder: RecordingFolder, executor: Executor) -> None:
        self.finish()
        self._number += 1
        self._pending = executor.submit(self._write, snapshot, self._number, folder)

    def finish(self) -> None:
        if self._pending is not None:
            self._pending.result()
            self._pending = None

    def _write(self, snapshot: Snapshot, number: int, folder: RecordingFolder) -> None:
        folder.add_picture(self.id, snapshot.stamp_ns, self._renderer.render(snapshot, number))


def record_simulated(
    lab: Lab,
    cameras: Sequence[str],
    folder: RecordingFolder,
    executor: Executor,
    *,
    seconds: float,
    rate_hz: float | None = None,
    seed: int | None = None,
    on_progress: Callable[[float], None] = lambda _: None,
) -> list[TruthRow]:
    """Drives for `seconds` and writes the pictures; returns the truth at every capture time. `rate_hz` None: each camera's
    own. Capture times are whole steps of the world."""
    world = World(lab, seed)
    followers = start_vehicles(lab, world)
    order = [camera.id for camera in lab.cameras]
    shooting = [_Camera(lab, order.index(camera), camera, rate_hz, seed) for camera in cameras]
    truth: list[TruthRow] = []
    for step in range(round(seconds / world.step_s)):
        now = world.truth()
        due = [camera for camera in shooting if camera.is_due(step * world.step_s)]
        for camera in due:
            camera.shoot(world.snapshot(), folder, executor)
        if due:
            truth += [
                (now.stamp_ns, name, v.x, v.y, v.yaw, v.linear_mps, v.angular_radps) for name, v in now.vehicles.items()
            ]
        for vehicle, follower in followers.items():
            world.set_drive(vehicle, *follower.twist(now.vehicles[vehicle]))
        world.step()
        on_progress(step * world.step_s / seconds)
    for camera in shooting:
        camera.finish()
    return truth
