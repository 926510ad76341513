"""What a stored calibration rests on, as digests: when the lab description says something else today, it is void."""

import hashlib

from pydantic import BaseModel

from protocol.lab.devices import CameraSpec, FloorTags


def camera_basis(camera: CameraSpec) -> str:
    """Digest of the image size and the intrinsics."""
    return _digest(f"{camera.width}x{camera.height}", camera.intrinsics)


def floor_basis(floor_tags: FloorTags) -> str:
    """Digest of the floor tags' family, size and measured poses."""
    return _digest("floor", floor_tags)


def _digest(text: str, model: BaseModel) -> str:
    return hashlib.sha256(f"{text} {model.model_dump_json()}".encode()).hexdigest()[:16]
