"""`./lilliput calibrate intrinsics`: a camera's lens from a recording of a board (docs/calibrate.md)."""

import argparse
import time
from pathlib import Path
from typing import Any

from geometry import CameraModel
from launcher.board_pictures import BoardPictures, of_camera
from launcher.errors import UsageError
from launcher.output import Result, print_result, progress
from localization.calibration.boards import BoardError, BoardSpec
from localization.calibration.intrinsics import IntrinsicsError, IntrinsicsEstimate, calibrate_intrinsics

_IN_PIXELS = frozenset({"fx", "fy", "cx", "cy"})
_SPARSE = 0.6
"""Distortion is a polynomial: where no corner was seen it is extrapolated, and the picture's corners are the first to suffer."""
_SHOW_EVERY_S = 2.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="video, or folder of pictures, of the board")
    parser.add_argument(
        "--board",
        required=True,
        metavar="BOARD",
        help="charuco:COLUMNSxROWS:SQUARE:MARKER[:DICTIONARY] or chessboard:COLUMNSxROWS:SQUARE, counted in squares, in metres",
    )
    parser.add_argument("--camera", metavar="ID", help="of a recording with a folder or video per camera, this one")
    parser.add_argument(
        "--every", type=int, default=1, metavar="N", help="look at every Nth frame only (default: %(default)s)"
    )


def calibrate_lens(arguments: argparse.Namespace) -> None:
    """Prints the line for the lab file and what it rests on; UsageError for a recording that does not tell."""
    if arguments.every < 1:
        raise UsageError(f"--every {arguments.every}: frames are counted from 1")
    try:
        board = BoardSpec.parse(arguments.board)
        path = arguments.recording if arguments.camera is None else of_camera(arguments.recording, arguments.camera)
        pictures = BoardPictures(path, arguments.every)
        progress(f"looking for a {board.kind} of {board.size} in {path}")
        found = calibrate_intrinsics(pictures, board, _Shown(pictures))
    except (BoardError, IntrinsicsError) as error:
        raise UsageError(str(error)) from error
    if found.coverage < _SPARSE:
        progress(
            f"warning: the board was seen in {found.coverage:.0%} of the image only; carry it into the corners too, the"
            " distortion there is a guess"
        )
    line = lab_file_line(found.model)
    figures = lens_figures(found, pictures.unreadable)
    settings = {"recording": str(path), "board": arguments.board, "every": arguments.every}
    if arguments.json:
        figures["lab_file_line"] = line
    else:
        print(line)
    print_result(Result("intrinsics", figures, settings=settings), as_json=arguments.json)


def lab_file_line(lens: CameraModel) -> str:
    """The camera's `intrinsics` as YAML in a lab file. Never in exponent notation, in which YAML 1.1 sees texts."""
    pixels = ", ".join(f"{name}: {getattr(lens, name):.3f}" for name in ("fx", "fy", "cx", "cy"))
    return f"intrinsics: {{{pixels}, distortion: [{', '.join(f'{value:.6f}' for value in lens.distortion)}]}}"


def lens_figures(found: IntrinsicsEstimate, unreadable: int) -> dict[str, Any]:
    """Flat, with units: the lens, its standard deviations, and which of the frames it rests on."""
    values = (found.model.fx, found.model.fy, found.model.cx, found.model.cy, *found.model.distortion)
    figures: dict[str, Any] = {"width_px": found.model.width, "height_px": found.model.height}
    for (name, std), value in zip(found.std.items(), values, strict=True):
        unit = "_px" if name in _IN_PIXELS else ""
        figures[f"{name}{unit}"], figures[f"{name}_std{unit}"] = value, std
    return figures | {
        "rms_px": found.rms_px,
        "coverage_share": found.coverage,
        "frames": found.frames + unreadable,
        "frames_used": found.views,
        "frames_unreadable": unreadable,
        "frames_without_board": found.without_board,
        "frames_blurred": found.blurred,
        "frames_alike": found.alike,
        "frames_outliers": found.outliers,
    }


class _Shown:
    """Says now and then on stderr how far the search has come: how many views there will be is not known, but it should grow."""

    def __init__(self, pictures: BoardPictures) -> None:
        self._pictures, self._shown_s = pictures, time.monotonic()

    def __call__(self, _: int, kept: int) -> None:
        taken, total = self._pictures.taken, self._pictures.total
        if time.monotonic() - self._shown_s < _SHOW_EVERY_S:
            return
        self._shown_s = time.monotonic()
        of = "" if total is None else f" of {total}"
        progress(f"{taken}{of} frames, {kept} views kept")
