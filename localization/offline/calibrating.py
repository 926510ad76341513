"""The calibration of a recording: found from its own floor tags, or read from a file of an earlier one.

The file is the `Calibration` message in JSON, which is also what the running system keeps.
"""

from collections.abc import Sequence
from pathlib import Path

from localization.calibration import ExtrinsicsError, FloorSighting, refine_jointly
from localization.calibrator import as_calibration
from localization.offline.errors import CalibrationFileError, NotCalibratedError
from localization.offline.floor_look import FloorLook
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.lab import Lab, camera_basis, floor_basis
from protocol.messages import Calibration

_BY = "localize"
_LARGEST_ID = 2**53 - 1


def calibrated(lab: Lab, looks: Sequence[FloorLook]) -> tuple[Calibration, list[str]]:
    """The joint calibration of all cameras that can be calibrated, and a sentence for each that cannot and for each that moved.
    NotCalibratedError when none can."""
    problems: list[str] = []
    usable: list[FloorSighting] = []
    for look in looks:
        problem = _problem_alone(lab, look)
        if problem is not None:
            problems.append(f"{look.camera} is not calibrated and gives no poses: {problem}")
        elif look.sighting is not None:
            usable.append(look.sighting)
            if look.moved_ns is not None:
                problems.append(
                    f"{look.camera} was moved while recording, seen at {look.moved_ns} ns: calibrated from what it saw"
                    " before, and from then on by itself, as while running"
                )
    if not usable:
        raise NotCalibratedError(f"no camera finds its place: {'; '.join(problems)}")
    try:
        joint = refine_jointly(lab, usable)
    except ExtrinsicsError as error:
        raise NotCalibratedError(f"the cameras do not fit together: {error}") from error
    stamp_ns = max(sighting.stamp_ns for sighting in usable)
    run_id = min(max(1, stamp_ns // 1_000_000), _LARGEST_ID)
    return as_calibration(lab, joint, run_id, stamp_ns, _BY), problems


def read_calibration(path: Path, lab: Lab) -> Calibration:
    """A file that `calibration_text` gave. CalibrationFileError when it is none, or of a room or cameras described otherwise."""
    try:
        calibration = decode(Calibration, path.read_bytes())
    except OSError as error:
        raise CalibrationFileError(f"{path} cannot be read: {error.strerror}") from error
    except DecodeError as error:
        raise CalibrationFileError(f"{path} is {error}") from error
    if calibration.floor_basis != floor_basis(lab.floor_tags):
        raise CalibrationFileError(f"{path} was computed for floor tags described otherwise; calibrate again")
    for camera in lab.cameras:
        mine = calibration.cameras.get(camera.id)
        if mine is not None and mine.basis != camera_basis(camera):
            raise CalibrationFileError(f"{path}: {camera.id} was calibrated with another size or other intrinsics")
    return calibration


def calibration_text(calibration: Calibration) -> bytes:
    """What `read_calibration` reads."""
    return encode(calibration)


def _problem_alone(lab: Lab, look: FloorLook) -> str | None:
    """Why this camera would fail by itself: one bad camera must not spoil the others' calibration."""
    if look.sighting is None:
        return "it sees no floor tag"
    try:
        refine_jointly(lab, [look.sighting])
    except ExtrinsicsError as error:
        return str(error)
    return None
