"""Labs for the tests here: the shipped room, with other knobs."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from lab.snapshot import Snapshot, VehicleSnapshot
from protocol.lab import Lab, SimulatedDrive, SimulatedSurvey, load_lab

GULLIVER = Path(__file__).parents[2] / "labs" / "gulliver.yaml"
PERFECT = SimulatedDrive(noise=0.0, slip=0.0, delay_s=0.0)


def gulliver(*, image: dict[str, Any] | None = None, **simulation: Any) -> Lab:
    """The shipped room, exactly as described; keywords replace parts of its simulation, `image` knobs of its image."""
    lab = load_lab(GULLIVER)
    simulation.setdefault("survey", SimulatedSurvey())
    if image is not None:
        simulation["image"] = lab.simulation.image.model_copy(update=image)
    return lab.model_copy(update={"simulation": lab.simulation.model_copy(update=simulation)})


def standing(*vehicles: tuple[str, float, float, float]) -> Snapshot:
    """An instant with these vehicles (id, x, y, yaw) at rest and nothing else."""
    return Snapshot(0, tuple(VehicleSnapshot(name, x, y, yaw, 0.0, 0.0) for name, x, y, yaw in vehicles), ())


def tag_corners(pose: SE2, size_m: float, height_m: float = 0.0) -> NDArray[np.float64]:
    """Left-bottom, right-bottom, right-top and left-top corner (4, 3) of a tag whose x axis points along `pose`."""
    half = size_m / 2
    plane = pose.apply([[-half, -half], [half, -half], [half, half], [-half, half]])
    return np.column_stack((plane, np.full(4, height_m)))
