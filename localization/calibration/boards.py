"""Calibration boards: what they look like, and where their inner corners are in a picture."""

from dataclasses import dataclass
from typing import Any, Literal, Self, cast

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

_LEAST_SQUARES, _MOST_SQUARES = 3, 100


class BoardError(ValueError):
    """A board that does not exist, or a text that does not describe one; it says what is wrong."""


@dataclass(frozen=True, slots=True)
class BoardSpec:
    """A printed board of `columns` x `rows` squares (not inner corners) with a side of `square_m`. A ChArUco board has markers
    with a side of `marker_m` of OpenCV's `dictionary` in its white squares. BoardError for one that cannot be."""

    kind: Literal["chessboard", "charuco"]
    columns: int
    rows: int
    square_m: float
    marker_m: float = 0.0
    dictionary: str = "DICT_4X4_50"

    def __post_init__(self) -> None:
        if not all(_LEAST_SQUARES <= count <= _MOST_SQUARES for count in (self.columns, self.rows)):
            raise BoardError(f"a board has {_LEAST_SQUARES} to {_MOST_SQUARES} squares a side, not {self.size}")
        if not 0.0 < self.square_m < 10.0:
            raise BoardError(f"a board's squares have a side in metres, {self.square_m:g} is none")
        if self.kind == "charuco":
            if not 0.0 < self.marker_m < self.square_m:
                raise BoardError(f"markers of {self.marker_m:g} m do not fit into squares of {self.square_m:g} m")
            markers = self.columns * self.rows // 2
            if len(self._dictionary().bytesList) < markers:
                raise BoardError(f"{self.dictionary} has fewer markers than the {markers} of a board of {self.size}")

    @classmethod
    def parse(cls, text: str) -> Self:
        """`chessboard:COLUMNSxROWS:SQUARE` or `charuco:COLUMNSxROWS:SQUARE:MARKER[:DICTIONARY]`, lengths in metres."""
        parts = text.split(":")
        kind, wanted = parts[0], {"chessboard": (3,), "charuco": (4, 5)}
        if kind not in wanted or len(parts) not in wanted[kind]:
            raise BoardError(
                f"{text!r} is no board: chessboard:COLUMNSxROWS:SQUARE or charuco:COLUMNSxROWS:SQUARE:MARKER[:DICTIONARY],"
                " counted in squares, lengths in metres"
            )
        try:
            columns, rows = (int(count) for count in parts[1].split("x"))
            square_m = float(parts[2])
            if kind == "chessboard":
                return cls("chessboard", columns, rows, square_m)
            return cls("charuco", columns, rows, square_m, float(parts[3]), *parts[4:])
        except BoardError:
            raise
        except ValueError:
            raise BoardError(f"{text!r}: squares are counted as 7x5 and lengths are metres") from None

    @property
    def size(self) -> str:
        """As people write it."""
        return f"{self.columns} x {self.rows} squares"

    def charuco(self) -> Any:
        """OpenCV's board. BoardError for a chessboard."""
        if self.kind != "charuco":
            raise BoardError("a chessboard has no markers")
        return cv2.aruco.CharucoBoard((self.columns, self.rows), self.square_m, self.marker_m, self._dictionary())

    def corners(self) -> Array:
        """The inner corners on the board, row by row, shape (N, 3), metres."""
        columns, rows = self.columns - 1, self.rows - 1
        grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2).astype(np.float64)
        return np.column_stack([(grid + 1.0) * self.square_m, np.zeros(len(grid))])

    def _dictionary(self) -> Any:
        number = getattr(cv2.aruco, self.dictionary, None) if self.dictionary.startswith("DICT_") else None
        if number is None:
            raise BoardError(f"OpenCV has no dictionary {self.dictionary!r}; DICT_4X4_50 is one")
        return cv2.aruco.getPredefinedDictionary(number)


class BoardFinder:
    """Finds one kind of board in pictures."""

    def __init__(self, board: BoardSpec) -> None:
        self._board = board
        self._charuco: Any = cv2.aruco.CharucoDetector(board.charuco()) if board.kind == "charuco" else None

    def find(self, image: Image) -> tuple[NDArray[np.int_], Array] | None:
        """Numbers (N,) of the inner corners seen, in the order of `BoardSpec.corners`, and their pixels (N, 2); of a chessboard
        all or none, of a ChArUco board those in sight. None when there are none."""
        if self._charuco is not None:
            corners, ids, _, _ = self._charuco.detectBoard(image)
            if corners is None or ids is None:
                return None
            return np.asarray(ids, dtype=np.int_).reshape(-1), np.asarray(corners, dtype=np.float64).reshape(-1, 2)
        pattern = (self._board.columns - 1, self._board.rows - 1)
        found, corners = cv2.findChessboardCornersSB(image, pattern, flags=cv2.CALIB_CB_ACCURACY)
        if not found:
            return None
        pixels = cast("Array", np.asarray(corners, dtype=np.float64).reshape(-1, 2))
        return np.arange(len(pixels)), pixels
