"""Recorded cameras turned into poses (spec localization; design, "Recordings"): the same pipeline and tracker as live, with
the calibration that the whole recording gives.

    recording = open_recording(path, lab)
    with ThreadPoolExecutor() as executor:
        calibration, problems = calibrated(lab, look_at_floors(recording.cameras, KnownTags.of(lab), executor))
        for poses in Localization(lab, recording, calibration, executor).poses():
            ...
"""

from localization.offline.calibrating import calibrated, calibration_text, read_calibration
from localization.offline.errors import (
    CalibrationFileError,
    NotCalibratedError,
    OfflineError,
    OutputFolderError,
    RecordingError,
)
from localization.offline.floor_look import FloorLook, look_at_floors
from localization.offline.localizing import Localization, Statistics
from localization.offline.recording import LAB_FILE, Recording, open_recording
from localization.offline.results_folder import ResultsFolder
from localization.offline.trajectories import POSES_FILE, TrajectoryWriter, trajectory_file

__all__ = [
    "LAB_FILE",
    "POSES_FILE",
    "CalibrationFileError",
    "FloorLook",
    "Localization",
    "NotCalibratedError",
    "OfflineError",
    "OutputFolderError",
    "Recording",
    "RecordingError",
    "ResultsFolder",
    "Statistics",
    "TrajectoryWriter",
    "calibrated",
    "calibration_text",
    "look_at_floors",
    "open_recording",
    "read_calibration",
    "trajectory_file",
]
