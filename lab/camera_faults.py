"""What a fault does to a simulated camera: its mount, what hangs in front of it, the frames that it sends."""

import numpy as np

from lab.rendering import CameraRenderer
from lab.rendering.layers import Window
from lab.rendering.textures import UInt8
from protocol.lab import Lab
from protocol.messages import CameraFault, FaultKind


def bumped(lab: Lab, camera_id: str, fault: CameraFault) -> Lab:
    """The lab with the camera's mount where the bump left it."""
    mount = lab.simulation.mounts[camera_id]
    x, y, z = mount.position
    moved = mount.model_copy(
        update={
            "position": (x + fault.shift_x_m, y + fault.shift_y_m, z + fault.shift_z_m),
            "tilt_x": mount.tilt_x + fault.tilt_x,
            "tilt_y": mount.tilt_y + fault.tilt_y,
        }
    )
    mounts = {**lab.simulation.mounts, camera_id: moved}
    return lab.model_copy(update={"simulation": lab.simulation.model_copy(update={"mounts": mounts})})


def renderer_for(lab: Lab, camera_id: str, fault: CameraFault | None) -> CameraRenderer:
    """The camera where it hangs now, a second of work for Full HD. ValueError when the bump has it look above the horizon."""
    if fault is not None and fault.kind is FaultKind.BUMP:
        lab = bumped(lab, camera_id, fault)
    return CameraRenderer(lab, camera_id)


def covered_window(fault: CameraFault | None, width: int, height: int) -> Window | None:
    """The part of the image (x0, y0, x1, y1) that something hangs in front of."""
    if fault is None or fault.kind is not FaultKind.COVER:
        return None
    return 0, 0, max(1, round(fault.cover_share * width)), height


def random_pixels(shape: tuple[int, ...], camera_id: str, frame_number: int) -> UInt8:
    """Garbage: every pixel at random, the same for the same camera and frame."""
    return np.random.default_rng([frame_number, *camera_id.encode()]).integers(0, 256, shape, dtype=np.uint8)
