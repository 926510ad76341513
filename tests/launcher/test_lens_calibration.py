"""`./lilliput calibrate intrinsics`: from pictures of a board to the line in the lab file."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from geometry import CameraModel
from launcher.cli import main
from launcher.lens_calibration import lab_file_line
from protocol.lab import Intrinsics
from tests.localization.test_intrinsics import CHARUCO, LENS, picture, views

BOARD = "charuco:9x6:0.04:0.03"
VIEWS = 12


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A camera's folder in a recording: the board twelve times, once more from the same place, once out of sight, and a file
    that broke."""
    folder = tmp_path_factory.mktemp("recording") / "cam4"
    folder.mkdir()
    poses = [*views(VIEWS)]
    for number, T_camera_board in enumerate([*poses, poses[-1]]):
        cv2.imwrite(str(folder / f"{number:02}.png"), picture(CHARUCO, T_camera_board, number))
    cv2.imwrite(str(folder / "90.png"), np.full((LENS.height, LENS.width), 90, np.uint8))
    (folder / "91.png").write_bytes(b"\x89PNG")
    return folder.parent


def test_the_shell_prints_the_line_for_the_lab_file(
    recording: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("launcher.lens_calibration._SHOW_EVERY_S", 0.0)
    assert main(["calibrate", "intrinsics", str(recording / "cam4"), "--board", BOARD]) == 0
    out, err = capsys.readouterr()
    line, *figures = out.splitlines()
    lens = Intrinsics.model_validate(yaml.safe_load(line)["intrinsics"])
    for name in ("fx", "fy", "cx", "cy"):
        assert getattr(lens, name) == pytest.approx(getattr(LENS, name), abs=2.0), name
    assert any(figure.split() == ["frames_unreadable", "1"] for figure in figures)
    assert "looking for a charuco of 9 x 6 squares" in err
    assert f"{VIEWS + 2} of {VIEWS + 3} frames, " in err, "the last frame that could be read"


def test_json_says_what_the_lens_rests_on(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["calibrate", "intrinsics", str(recording), "--camera", "cam4", "--board", BOARD, "--json"]
    assert main(argv) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["name"] == "intrinsics"
    assert result["settings"] == {"recording": str(recording / "cam4"), "board": BOARD, "every": 1}
    found = result["figures"]
    assert (found["width_px"], found["height_px"]) == (LENS.width, LENS.height)
    assert abs(found["fx_px"] - LENS.fx) < 4 * found["fx_std_px"] < 4.0
    assert abs(found["k1"] - LENS.distortion[0]) < 4 * found["k1_std"] < 0.1
    assert 0.0 < found["rms_px"] < 0.2
    assert 0.3 < found["coverage_share"] <= 1.0
    assert found["frames"] == VIEWS + 3
    assert found["frames_alike"] >= 1
    assert (found["frames_unreadable"], found["frames_without_board"] >= 1) == (1, True)
    reasons = ("used", "unreadable", "without_board", "blurred", "alike", "outliers")
    assert sum(found[f"frames_{reason}"] for reason in reasons) == found["frames"]
    line = yaml.safe_load(found["lab_file_line"])["intrinsics"]
    assert line["fx"] == pytest.approx(found["fx_px"], abs=0.001)
    assert line["distortion"] == pytest.approx([found[name] for name in ("k1", "k2", "p1", "p2", "k3")], abs=1e-6)


def test_small_distortions_stay_numbers_in_yaml() -> None:
    lens = CameraModel(640, 480, 500.0, 500.0, 320.0, 240.0, (1e-5, -2e-5, 0.0, 0.0, 0.0))
    assert yaml.safe_load(lab_file_line(lens))["intrinsics"]["distortion"] == [1e-5, -2e-5, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (["cam4", "--board", "charuco:9x6"], "'charuco:9x6' is no board"),
        (["cam4"], "required: --board"),
        (["cam4", "--board", BOARD, "--every", "0"], "--every 0: frames are counted from 1"),
        (["nowhere", "--board", BOARD], "nowhere does not exist"),
        ([".", "--board", BOARD], "choose one of cam4 with --camera"),
        ([".", "--board", BOARD, "--camera", "cam9"], "has no camera 'cam9'; it has cam4"),
        (["cam4", "--board", BOARD, "--every", "4"], "usable views of the board, 8 are needed: of 4 frames"),
    ],
)
def test_what_gives_no_lens_is_said_in_a_line(
    recording: Path, argv: list[str], says: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(["calibrate", "intrinsics", str(recording / argv[0]), *argv[1:]]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    error = err.splitlines()[-1]
    assert error.startswith("lilliput: ")
    assert says in error
