"""A recording being written: one folder of pictures per camera, named by capture time, and the lab file beside them."""

import shutil
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from launcher.errors import LauncherError, UsageError
from localization.offline import LAB_FILE
from protocol.lab import Lab

PictureFormat = Literal["jpg", "png"]
_TRUTH_FILE = "truth.csv"
_TRUTH_HEADER = "stamp_ns,vehicle,x_m,y_m,yaw_rad,linear_mps,angular_radps\n"


class RecordingFolder:
    """A new folder; several threads may write pictures of different cameras. UsageError when `path` holds something."""

    def __init__(self, path: Path, cameras: Sequence[str], picture_format: PictureFormat, quality: int) -> None:
        if path.exists() and (not path.is_dir() or any(path.iterdir())):
            raise UsageError(f"{path} exists already and is not empty; choose another folder for the recording")
        self.path = path
        self.frames = Counter[str]()
        self._suffix = f".{picture_format}"
        self._parameters = [cv2.IMWRITE_JPEG_QUALITY, quality] if picture_format == "jpg" else []
        try:
            for camera in cameras:
                (path / camera).mkdir(parents=True)
        except OSError as error:
            raise UsageError(f"{path} cannot be made: {error.strerror}") from error

    def add_picture(self, camera: str, stamp_ns: int, pixels: NDArray[np.uint8]) -> None:
        """Grey (height, width) or BGR (height, width, 3). LauncherError when the disk does not take it."""
        ok, data = cv2.imencode(self._suffix, pixels, self._parameters)
        if not ok:
            raise LauncherError(f"a frame of {camera} could not be encoded as {self._suffix}")
        file = self.path / camera / f"{stamp_ns}{self._suffix}"
        try:
            file.write_bytes(data.tobytes())
        except OSError as error:
            raise _refused(file, error) from error
        self.frames[camera] += 1

    def discard(self) -> None:
        """Takes away what was begun and came to nothing."""
        shutil.rmtree(self.path)

    def write_lab(self, text: str) -> None:
        """The lab file as it is. LauncherError when the disk does not take it."""
        file = self.path / LAB_FILE
        try:
            file.write_text(text, encoding="utf-8")
        except OSError as error:
            raise _refused(file, error) from error

    def write_lab_without_simulation(self, lab: Lab) -> None:
        """What an estimator may know: everything but the section that only the simulated lab reads."""
        content: dict[str, Any] = lab.model_dump(mode="json", exclude={"simulation"})
        self.write_lab(yaml.safe_dump(content, sort_keys=False, width=120))

    def write_truth(self, rows: Sequence[tuple[int, str, float, float, float, float, float]]) -> None:
        """Where vehicles truly were: ns, id, m, m, rad, m/s, rad/s. LauncherError when the disk does not take it."""
        lines = [
            f"{stamp_ns},{vehicle},{x:.7f},{y:.7f},{yaw:.8f},{linear:.6f},{angular:.6f}\n"
            for stamp_ns, vehicle, x, y, yaw, linear, angular in rows
        ]
        path = self.path / _TRUTH_FILE
        try:
            path.write_text("".join([_TRUTH_HEADER, *lines]), encoding="utf-8", newline="\n")
        except OSError as error:
            raise _refused(path, error) from error


def _refused(path: Path, error: OSError) -> LauncherError:
    return LauncherError(f"{path} cannot be written: {error.strerror}")
