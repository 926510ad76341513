"""All cameras of a lab calibrated together from what each saw of the floor tags."""

from collections.abc import Sequence
from dataclasses import dataclass

from geometry import SE2
from localization.calibration.extrinsics import ExtrinsicsError, estimate_extrinsics
from localization.calibration.sighting import FloorSighting
from localization.tags import KnownTags
from protocol.lab import Lab
from protocol.messages import CameraExtrinsics


@dataclass(frozen=True, slots=True, eq=False)
class JointCalibration:
    """The result, by camera and by floor tag. `floor_tags` are T_map_tag, `floor_tag_shift_m` how far each came to lie from
    the description; `left_out` names by camera the floor tags that were not believed."""

    extrinsics: dict[str, CameraExtrinsics]
    floor_tags: dict[int, SE2]
    floor_tag_shift_m: dict[int, float]
    reprojection_px: dict[str, float]
    left_out: dict[str, tuple[int, ...]]


def refine_jointly(lab: Lab, sightings: Sequence[FloorSighting]) -> JointCalibration:
    """Every camera's extrinsics. ExtrinsicsError says what stands in the way."""
    known = KnownTags.of(lab)
    expected = {key[1]: known.floor_corners(key) for key in known.floor}
    extrinsics: dict[str, CameraExtrinsics] = {}
    left_out: dict[str, tuple[int, ...]] = {}
    for sighting in sightings:
        try:
            found = estimate_extrinsics(
                lab.camera(sighting.camera).model(), sighting.corners, expected, known.floor_size_m
            )
        except ExtrinsicsError as error:
            raise ExtrinsicsError(f"camera {sighting.camera}: {error}") from None
        rx, ry, rz = (float(v) for v in found.T_map_camera.rotvec())
        x, y, z = (float(v) for v in found.T_map_camera.translation)
        extrinsics[sighting.camera] = CameraExtrinsics(
            sighting.camera, sighting.stamp_ns, (rx, ry, rz), (x, y, z), found.reprojection_px, found.used
        )
        left_out[sighting.camera] = found.rejected
    return JointCalibration(
        extrinsics=extrinsics,
        floor_tags={key[1]: pose for key, pose in known.floor.items()},
        floor_tag_shift_m={key[1]: 0.0 for key in known.floor},
        reprojection_px={camera: found.reprojection_px for camera, found in extrinsics.items()},
        left_out=left_out,
    )
