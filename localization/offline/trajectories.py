"""Poses as files: one table of all, and one trajectory per vehicle in the format of the TUM RGB-D benchmark (Sturm et al. 2012:
`timestamp x y z qx qy qz qw`, seconds and metres), which evo and others read."""

import math
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import TextIO

from protocol.messages import TrackedPose

POSES_FILE = "poses.csv"
HEADER = "stamp_ns,vehicle,x_m,y_m,yaw_rad,covariance"


def trajectory_file(vehicle: str) -> str:
    """The name of a vehicle's trajectory."""
    return f"{vehicle}.tum"


class TrajectoryWriter:
    """Writes into an existing folder; a context manager. Poses are written as they come. OSError when the disk does not take
    them (`ResultsFolder` says so in a sentence)."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._table = (folder / POSES_FILE).open("x", encoding="utf-8", newline="\n")
        self._table.write(HEADER + "\n")
        self._trajectories: dict[str, TextIO] = {}

    def __enter__(self) -> "TrajectoryWriter":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Everything is in the files then; closing twice does nothing."""
        with ExitStack() as files:  # each of them, also when the disk refuses what one still had to write
            for file in (self._table, *self._trajectories.values()):
                files.callback(file.close)

    def write(self, poses: Iterable[TrackedPose]) -> None:
        for pose in poses:
            self._table.write(table_row(pose) + "\n")
            file = self._trajectories.get(pose.vehicle)
            if file is None:
                file = (self._folder / trajectory_file(pose.vehicle)).open("x", encoding="utf-8", newline="\n")
                self._trajectories[pose.vehicle] = file
            file.write(trajectory_row(pose) + "\n")


def table_row(pose: TrackedPose) -> str:
    """A line of the table: covariance xx xy xyaw yy yyaw yawyaw (m^2, m rad, rad^2), separated by spaces."""
    covariance = " ".join(f"{value:.6g}" for value in pose.covariance)
    return f"{pose.stamp_ns},{pose.vehicle},{pose.x:.6f},{pose.y:.6f},{pose.yaw:.7f},{covariance}"


def trajectory_row(pose: TrackedPose) -> str:
    """A line of a trajectory: the rotation centre on the floor (z = 0), turned about the vertical."""
    seconds, rest_ns = divmod(pose.stamp_ns, 1_000_000_000)
    z, w = math.sin(pose.yaw / 2), math.cos(pose.yaw / 2)
    return f"{seconds}.{rest_ns:09d} {pose.x:.6f} {pose.y:.6f} 0 0 0 {z:.9f} {w:.9f}"
