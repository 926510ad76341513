"""The benchmark's own arithmetic, and one run of it that is as small as can be: every figure comes, and tags are found."""

from pathlib import Path

import pytest

from launcher.cli import main
from launcher.paths import DEFAULT_LAB
from protocol.lab import load_lab
from tests.bench.follow import Block, figures
from tests.bench.localization import Plan, measure, ratios
from tests.bench.scene import bench_lab
from tests.bench.sustained import SustainedError, sustained


def test_figures_are_medians_over_blocks() -> None:
    quiet = Block(process_ms=[1.0] * 99 + [5.0], decode_ms=[2.0] * 100, visible=100, found=100, errors_m=[0.001] * 100)
    few = Block(process_ms=[1.0] * 99, decode_ms=[2.0] * 99, visible=99, found=99)
    busy = Block(process_ms=[10.0] * 100, decode_ms=[20.0] * 100, visible=100, found=98, errors_m=[0.003] * 98)
    found = figures([quiet, busy, quiet])
    assert found["median_ms"] == 1.0
    assert found["with_decode_median_ms"] == 3.0
    assert found["p99_ms"] == pytest.approx(1.04)
    assert found["found_share"] == pytest.approx(298 / 300)
    assert found["position_error_median_mm"] == pytest.approx(1.0)
    assert "p99_ms" not in figures([quiet, few])


def test_no_vehicle_in_view_is_no_result() -> None:
    with pytest.raises(ValueError, match="no frame shows"):
        figures([Block(), Block()])


def test_ratios_say_how_much_faster_ours_is() -> None:
    found = ratios(
        {
            "fullhd_4_follow_median_ms": 2.0,
            "fullhd_4_follow_p99_ms": 4.0,
            "fullhd_4_gulliview2025_median_ms": 6.0,
            "fullhd_4_gulliview2025_p99_ms": 40.0,
            "fullhd_4_gulliview2025_with_decode_median_ms": 9.0,
            "fullhd_20_gulliview2023_median_ms": 90.0,
            "uhd_4_follow_median_ms": 3.0,
            "uhd_4_follow_p99_ms": 4.0,
        }
    )
    assert found == {
        "fullhd_4_gulliview2025_median_ratio": 3.0,
        "fullhd_4_gulliview2025_p99_ratio": 10.0,
        "uhd_4_ratio": 1.5,
        "uhd_4_p99_ratio": 1.0,
    }


def test_a_small_run_gives_every_figure_and_finds_every_tag() -> None:
    small = Plan((4,), 1, {"fullhd": {"ours": 12, "gulliview2025": 12}}, 0.5, ("ours",))
    whole = load_lab(DEFAULT_LAB)
    found = measure(whole.model_copy(update={"cameras": whole.cameras[1:3]}), small, ("fullhd",), seed=5)
    for name in ("follow", "gulliview2025"):
        assert found[f"fullhd_4_{name}_found_share"] == 1.0
        assert found[f"fullhd_4_{name}_position_error_median_mm"] < 5.0
        assert f"fullhd_4_{name}_median_ms" in found
        assert f"fullhd_4_{name}_p99_ms" not in found, "24 frames have no 99th percentile"
    assert "fullhd_4_gulliview2025_median_ratio" in found
    assert found["fullhd_cameras_sustained_fps"] > 0
    assert found["fullhd_cameras_sustained_jpeg_fps"] > 0
    assert found["fullhd_cameras_sustained_pose_share"] > 0.99
    assert found["fullhd_cameras_sustained_jpeg_pose_share"] > 0.99


def test_a_camera_process_that_ends_early_is_said(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    lab = bench_lab(load_lab(DEFAULT_LAB), "fullhd", 1)
    (tmp_path / "empty").write_bytes(b"")
    with pytest.raises(SustainedError, match="a camera process of gulliview2025 ended early"):
        sustained(lab, [tmp_path / "empty"], "fullhd", "gulliview2025", with_decode=True, seconds=0.1)
    assert "DecodeError" in capfd.readouterr().err


def test_an_unknown_benchmark_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "nothing"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
