"""The tracking experiment keeps its budget on rendered Full HD frames, here for a few seconds (docs/results.md has thirty)."""

from pathlib import Path

import pytest
import yaml

from launcher.cli import main
from launcher.experiments.tracking import measure
from localization.pipeline import PipelineOptions
from protocol.lab import load_lab

GULLIVER = Path(__file__).resolve().parents[2] / "labs/gulliver.yaml"


def test_four_vehicles_are_tracked_within_the_budget() -> None:
    score, _ = measure(load_lab(GULLIVER), seconds=6.0, seed=7)
    figures = score.figures()
    assert figures["position_error_median_mm"] <= 5.0
    assert figures["position_error_p99_mm"] <= 20.0
    assert figures["heading_error_median_deg"] <= 0.5
    assert figures["pose_share"] >= 0.99
    assert figures["handover_jump_max_mm"] <= 10.0
    assert figures["handovers"] >= 10
    assert score.visible_tags > 300


def test_the_same_seed_gives_the_same_figures() -> None:
    whole = load_lab(GULLIVER)
    lab = whole.model_copy(update={"cameras": whole.cameras[:1]})
    options = PipelineOptions(full_search_every=5)
    first, second, other = (measure(lab, 0.5, seed, options)[0].position_errors_m for seed in (3, 3, 4))
    assert first == second
    assert first != other
    assert len(first) == pytest.approx(len(other), abs=5)


def test_nothing_tracked_is_said_in_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With one camera of the room, at 5 Hz: nothing of it is looked at while the vehicles stand."""
    lab = yaml.safe_load(GULLIVER.read_text())
    lab["cameras"] = [{**lab["cameras"][0], "rate_hz": 5}]
    lab["simulation"]["mounts"] = {"cam0": lab["simulation"]["mounts"]["cam0"]}
    path = tmp_path / "lab.yaml"
    path.write_text(yaml.safe_dump(lab))
    assert main(["experiment", "tracking", "--lab", str(path), "--seconds", "0.001"]) == 1
    said = capsys.readouterr().err
    assert said.startswith("lilliput: nothing was tracked in 0.001 s: 0 times a vehicle's tag")
    assert said.count("\n") == 1
