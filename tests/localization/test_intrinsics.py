"""Lenses from recordings of boards: drawn ray by ray through a known lens."""

from collections.abc import Iterator
from functools import cache

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import SE3, CameraModel
from localization.calibration.boards import BoardError, BoardSpec
from localization.calibration.intrinsics import IntrinsicsError, calibrate_intrinsics, edge_rise_px

LENS = CameraModel(640, 480, 510.0, 508.0, 325.0, 236.0, (-0.12, 0.05, 0.0008, -0.0005, 0.0))
CHARUCO = BoardSpec("charuco", 9, 6, 0.04, 0.03)
CHESSBOARD = BoardSpec("chessboard", 9, 6, 0.04)
_TEXEL_M = 0.0005
_MARGIN_M = 0.04
_FINE = 2
"""Each pixel is the mean of so many by so many."""


@cache
def printed(board: BoardSpec) -> NDArray[np.float32]:
    """The board with a white margin, seen from its front, its edges a little soft; its first corner is at the picture's
    (margin, margin)."""
    cell = round(board.square_m / _TEXEL_M)
    if board.kind == "charuco":
        inner = board.charuco().generateImage((board.columns * cell, board.rows * cell), marginSize=0)
    else:
        squares = (np.add.outer(np.arange(board.rows), np.arange(board.columns)) % 2) * 255
        inner = np.kron(squares, np.ones((cell, cell))).astype(np.uint8)
    margin = round(_MARGIN_M / _TEXEL_M)
    return cv2.GaussianBlur(np.pad(inner, margin, constant_values=255).astype(np.float32), (0, 0), 1.0).astype(
        np.float32
    )


@cache
def rays() -> NDArray[np.float32]:
    """Where the image's finer pixels look, shape (3, N), z = 1."""
    u, v = ((np.arange(n * _FINE) + 0.5) / _FINE - 0.5 for n in (LENS.width, LENS.height))
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 1, 2)
    flat = cv2.undistortPoints(grid, LENS.matrix(), LENS.distortion_array()).reshape(-1, 2)
    return np.vstack([flat.T, np.ones(len(flat))]).astype(np.float32)


def picture(board: BoardSpec, T_camera_board: SE3, seed: int, blur_px: float = 0.7) -> NDArray[np.uint8]:
    """Grey, with noise; the board's frame has x along its columns, y along its rows, z away from the viewer."""
    homography = np.linalg.inv(
        np.column_stack([T_camera_board.rotation[:, 0], T_camera_board.rotation[:, 1], T_camera_board.translation])
    )
    x, y, w = homography.astype(np.float32) @ rays()
    shape = (LENS.height * _FINE, LENS.width * _FINE)
    u, v = (((along / w + _MARGIN_M) / _TEXEL_M - 0.5).reshape(shape) for along in (x, y))
    drawn = cv2.remap(printed(board), u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=90.0)
    small = cv2.resize(drawn, (LENS.width, LENS.height), interpolation=cv2.INTER_AREA)
    small = cv2.GaussianBlur(small, (0, 0), blur_px) * 0.8 + 20.0
    small += np.random.default_rng(seed).normal(0.0, 2.0, small.shape)
    return np.clip(np.rint(small), 0, 255).astype(np.uint8)


def views(count: int, seed: int = 0) -> Iterator[SE3]:
    """The board all over the picture, tilted."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        turn = SE3.from_rotvec(rng.uniform((-0.6, -0.6, -0.3), (0.6, 0.6, 0.3)), np.zeros(3))
        at = rng.uniform((-0.11, -0.08, 0.42), (0.11, 0.08, 0.6))
        yield SE3(turn.rotation, at - turn.rotation @ np.array([0.18, 0.12, 0.0]))


@pytest.mark.parametrize("board", [CHARUCO, CHESSBOARD], ids=["charuco", "chessboard"])
def test_the_lens_comes_back_within_what_it_says_of_its_accuracy(board: BoardSpec) -> None:
    told: list[tuple[int, int]] = []
    frames = [picture(board, T, k) for k, T in enumerate(views(18))]
    found = calibrate_intrinsics(frames, board, lambda frame, kept: told.append((frame, kept)))
    assert found.views >= 10
    assert found.rms_px < 0.2
    assert (found.model.width, found.model.height) == (640, 480)
    for name in ("fx", "fy", "cx", "cy"):
        off = abs(getattr(found.model, name) - getattr(LENS, name))
        assert off < 4 * found.std[name], name
        assert off < 1.5, name
    grid = np.array([[[u, v]] for u in (60.0, 320.0, 580.0) for v in (60.0, 240.0, 420.0)])
    here, there = (cv2.undistortPoints(grid, lens.matrix(), lens.distortion_array()) for lens in (LENS, found.model))
    assert float(np.abs(here - there).max()) * LENS.fx < 1.5
    assert 0.5 < found.coverage <= 1.0
    assert told[-1] == (18, found.views + found.outliers)
    assert found.frames == 18 == found.views + found.without_board + found.blurred + found.alike + found.outliers


def test_blurred_views_and_views_alike_do_not_count() -> None:
    poses = list(views(12))
    frames = [picture(CHARUCO, T, k) for k, T in enumerate(poses)]
    again = [picture(CHARUCO, poses[0], 100 + k) for k in range(5)]
    smeared = [cv2.GaussianBlur(frames[1], (0, 0), 4.0).astype(np.uint8)]
    blank = [np.full((480, 640), 90, np.uint8)] * 3
    found = calibrate_intrinsics([*frames, *again, *smeared, *blank], CHARUCO)
    assert found.alike >= 5
    assert found.blurred + found.without_board >= 4
    assert found.without_board >= 3
    assert found.views <= 12


def test_sharpness_is_measured_on_the_edges() -> None:
    T = next(views(1))
    corners = np.array([[320.0, 240.0]])
    sharp = edge_rise_px(picture(CHESSBOARD, T, 1), corners)
    assert sharp < 4.0
    assert edge_rise_px(picture(CHESSBOARD, T, 1, blur_px=4.0), corners) > 1.5 * sharp


def test_what_does_not_tell_is_refused_with_a_hint() -> None:
    blank = np.full((480, 640), 90, np.uint8)
    with pytest.raises(IntrinsicsError, match="there are no frames"):
        calibrate_intrinsics([], CHARUCO)
    with pytest.raises(IntrinsicsError, match="none of 2 frames shows a chessboard of 9 x 6 squares"):
        calibrate_intrinsics([blank, blank], CHESSBOARD)
    with pytest.raises(IntrinsicsError, match="frame 2 is 320 x 240, the ones before 640 x 480"):
        calibrate_intrinsics([blank, blank[::2, ::2]], CHARUCO)
    few = [picture(CHARUCO, T, k) for k, T in enumerate(views(3))]
    with pytest.raises(IntrinsicsError, match="3 usable views of the board, 8 are needed: of 3 frames"):
        calibrate_intrinsics(few, CHARUCO)
    with pytest.raises(IntrinsicsError, match="none of 3 frames shows a chessboard of 12 x 9"):
        calibrate_intrinsics(few, BoardSpec("chessboard", 12, 9, 0.04))


def test_a_board_that_is_never_tilted_leaves_the_focal_length_open() -> None:
    rng = np.random.default_rng(3)
    frontal = [
        picture(CHARUCO, SE3(np.eye(3), np.array([x - 0.18, y - 0.12, 0.55])), k)
        for k, (x, y) in enumerate(rng.uniform((-0.1, -0.07), (0.1, 0.07), (10, 2)))
    ]
    with pytest.raises(IntrinsicsError, match="tilt the board"):
        calibrate_intrinsics(frontal, CHARUCO)


def test_boards_are_written_in_a_line() -> None:
    assert BoardSpec.parse("chessboard:9x6:0.04") == CHESSBOARD
    assert BoardSpec.parse("charuco:9x6:0.04:0.03") == CHARUCO
    assert BoardSpec.parse("charuco:9x6:0.04:0.03:DICT_5X5_100").dictionary == "DICT_5X5_100"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is no board"),
        ("circles:9x6:0.04", "is no board"),
        ("chessboard:9x6", "is no board"),
        ("charuco:9x6:0.04", "is no board"),
        ("chessboard:nine:0.04", "counted as 7x5"),
        ("chessboard:9x2:0.04", "3 to 100 squares a side"),
        ("chessboard:9x6:-1", "side in metres"),
        ("chessboard:9x6:nan", "side in metres"),
        ("charuco:9x6:0.03:0.04", "do not fit"),
        ("charuco:9x6:0.04:0.03:DICT_9X9", "no dictionary"),
        ("charuco:12x10:0.04:0.03:DICT_4X4_50", "fewer markers"),
    ],
)
def test_what_is_no_board_says_why(text: str, says: str) -> None:
    with pytest.raises(BoardError, match=says):
        BoardSpec.parse(text)
