"""Cameras calibrated together from what each saw of the floor tags (spec localization, "Better than the reports").

Floor tags that several cameras see tie them together, and every tag's measured place counts as much as it was measured well:
where hand-measured tags disagree, they are moved to where the cameras want them. Cameras that share no tag, directly or by way of
others, are independent groups. One camera alone is a group too.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import SE2, SE3, CameraModel
from localization.calibration.adjustment import SeenTags
from localization.calibration.consensus import Consensus, agree
from localization.calibration.extrinsics import MIN_TAGS, ExtrinsicsError, listed, rms_px
from localization.calibration.nominal import nominal_pose
from localization.calibration.sighting import FloorSighting
from localization.tags import KnownTags, tag_corners
from protocol.lab import Accuracy, Lab
from protocol.messages import CameraExtrinsics

Array = NDArray[np.float64]

_CORNER_BIAS_PX = 0.03
"""What averaging does not take off a corner: the detector's own, measured on rendered tags against the truth (0.026 px)."""
_MOST_SHIFT_M = 0.015
"""Floor tags that had to be moved further than this, and further than their accuracy explains, are not just measured by hand."""
_MOST_SIGMAS = 6.0
_MOST_MISFIT_PX = 1.0
"""No place of the floor tags explains what the cameras see: an id, a size or the intrinsics are wrong."""


@dataclass(frozen=True, slots=True, eq=False)
class JointCalibration:
    """The result, by camera and by floor tag. `floor_tags` are T_map_tag, `floor_tag_shift_m` how far each lies from the
    description; `reprojection_px` the RMS distance of a camera's corners from where it expects them; `left_out` names by
    camera the floor tags that were not believed (their entry in `floor_tags` is where the cameras see them)."""

    extrinsics: dict[str, CameraExtrinsics]
    floor_tags: dict[int, SE2]
    floor_tag_shift_m: dict[int, float]
    reprojection_px: dict[str, float]
    left_out: dict[str, tuple[int, ...]]


def refine_jointly(lab: Lab, sightings: Sequence[FloorSighting]) -> JointCalibration:
    """The calibration of all cameras with a sighting; of two of one camera the newer counts. Floor tags that no camera saw stay
    where the description has them. ExtrinsicsError says what stands in the way, KeyError names a camera the lab lacks."""
    known = KnownTags.of(lab)
    measured = {tag: pose for (_, tag), pose in known.floor.items()}
    models = {sighting.camera: lab.camera(sighting.camera).model() for sighting in sightings}
    return calibrate(models, sightings, measured, known.floor_size_m, lab.accuracy, plane_heights_m(known))


def calibrate(
    models: Mapping[str, CameraModel],
    sightings: Sequence[FloorSighting],
    measured: Mapping[int, SE2],
    size_m: float,
    accuracy: Accuracy,
    heights_m: Sequence[float],
) -> JointCalibration:
    """`refine_jointly` for cameras and floor tags that need not be a lab's: lens by camera, T_map_tag as measured, the tags'
    side (m), and the heights (m) that matter beside the floor."""
    newest: dict[str, FloorSighting] = {}
    for sighting in sightings:
        old = newest.get(sighting.camera)
        if old is None or sighting.stamp_ns >= old.stamp_ns:
            newest[sighting.camera] = sighting
    if not newest:
        raise ExtrinsicsError("no camera has seen its floor tags yet")
    seen = [_seen(models[camera], newest[camera], measured) for camera in sorted(newest)]
    result = JointCalibration({}, dict(measured), dict.fromkeys(measured, 0.0), {}, {})
    for group in _groups(seen):
        consensus = agree(group, measured, size_m, accuracy)
        _refuse_misfits(consensus, measured, size_m, accuracy)
        _take_over(result, consensus, newest, measured, size_m, accuracy, heights_m)
    return result


def plane_heights_m(known: KnownTags) -> tuple[float, ...]:
    """The heights (m) at which poses are computed: the floor's and the vehicles' tags'."""
    return (0.0, *sorted({vehicle.tag.height_m for vehicle in known.vehicles.values()}))


def _seen(model: CameraModel, sighting: FloorSighting, measured: Mapping[int, SE2]) -> SeenTags:
    tags = tuple(sorted(set(sighting.corners) & set(measured)))
    if len(tags) < MIN_TAGS:
        raise ExtrinsicsError(
            f"camera {sighting.camera} sees {listed(tags)}, needs {MIN_TAGS} floor tags to find its own place"
        )
    flicker_px = sighting.corner_noise_px / np.sqrt(max(1, sighting.frames))
    image = np.concatenate([sighting.corners[tag] for tag in tags])
    return SeenTags(sighting.camera, model, tags, image, float(np.hypot(flicker_px, _CORNER_BIAS_PX)))


def _groups(cameras: Sequence[SeenTags]) -> Iterator[list[SeenTags]]:
    """Cameras that hang together by shared tags."""
    left = list(cameras)
    while left:
        group, tags = [left.pop(0)], set[int]()
        while True:
            tags = {tag for camera in group for tag in camera.tags}
            more = [camera for camera in left if tags & set(camera.tags)]
            if not more:
                break
            group += more
            left = [camera for camera in left if camera not in more]
        yield group


def _refuse_misfits(consensus: Consensus, measured: Mapping[int, SE2], size_m: float, accuracy: Accuracy) -> None:
    room, square = consensus.adjusted.room, tag_corners(size_m)
    places = {tag: pose.apply(square) for tag, pose in room.tags.items()}
    for camera in consensus.cameras:
        lens, pose = room.lenses[camera.camera], room.poses[camera.camera]
        off_px = rms_px(lens, pose, camera.corners, places, camera.tags)
        if off_px > _MOST_MISFIT_PX:
            raise ExtrinsicsError(
                f"camera {camera.camera}: no pose explains {listed(camera.tags)} ({off_px:.1f} px off);"
                " check their ids, yaws and size and the camera's intrinsics"
            )
    most_m = max(_MOST_SHIFT_M, _MOST_SIGMAS * accuracy.floor_tag_m)
    shifts = {tag: place.distance_to(measured[tag]) for tag, place in room.tags.items() if tag not in consensus.free}
    wrong = [tag for tag, shift_m in shifts.items() if shift_m > most_m]
    if wrong:
        raise ExtrinsicsError(
            f"{listed(wrong)} {'are' if len(wrong) > 1 else 'is'} {' and '.join(f'{shifts[tag] * 1e3:.0f}' for tag in wrong)}"
            " mm off where the lab description has them; check their ids, poses and size and the cameras' intrinsics"
        )


def _take_over(
    result: JointCalibration,
    consensus: Consensus,
    sightings: Mapping[str, FloorSighting],
    measured: Mapping[int, SE2],
    size_m: float,
    accuracy: Accuracy,
    heights_m: Sequence[float],
) -> None:
    adjusted, square = consensus.adjusted, tag_corners(size_m)
    for tag, place in adjusted.room.tags.items():
        result.floor_tags[tag] = place
        result.floor_tag_shift_m[tag] = place.distance_to(measured[tag])
    places = {tag: pose.apply(square) for tag, pose in adjusted.room.tags.items()}
    for camera in consensus.cameras:
        name = camera.camera
        pose, covariance = nominal_pose(
            adjusted.room.poses[name],
            adjusted.room.lenses[name],
            adjusted.covariances[name],
            camera.model,
            accuracy,
            heights_m,
        )
        outside = {tag for other, tag in consensus.dropped if other == name}
        left_out = outside | {tag for tag in camera.tags if tag in consensus.free}
        used = tuple(tag for tag in camera.tags if tag not in left_out)
        off_px = rms_px(camera.model, pose, camera.corners, places, used or camera.tags)
        result.extrinsics[name] = extrinsics_message(name, sightings[name].stamp_ns, pose, covariance, off_px, used)
        result.reprojection_px[name] = off_px
        result.left_out[name] = tuple(sorted(left_out))


def extrinsics_message(
    camera: str, stamp_ns: int, pose: SE3, covariance: Array, off_px: float, tags: tuple[int, ...]
) -> CameraExtrinsics:
    """The message of T_map_camera with its covariance (10, 10)."""
    rx, ry, rz = (float(v) for v in pose.rotvec())
    x, y, z = (float(v) for v in pose.translation)
    return CameraExtrinsics(
        camera,
        stamp_ns,
        (rx, ry, rz),
        (x, y, z),
        off_px,
        tags,
        tuple(float(v) for v in covariance[np.triu_indices(10)]),
    )
