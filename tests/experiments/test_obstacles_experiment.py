"""The obstacles experiment, here with a few scenes."""

import json
import math
from pathlib import Path

import pytest
from shapely.geometry import LineString, Point, Polygon

from launcher.cli import main
from launcher.experiments.obstacle_scenes import draw_scene
from launcher.experiments.obstacle_trials import Trial, Watcher, conduct, false_stops
from launcher.experiments.obstacles import figures
from protocol.lab import load_lab

LAB = load_lab(Path(__file__).parents[2] / "labs/gulliver.yaml")


def test_scenes_are_drawn_within_the_areas_and_the_same_for_the_same_seed() -> None:
    floor = Polygon(LAB.areas[0].outline)
    scenes = [draw_scene(LAB, seed) for seed in range(40)]
    assert scenes == [draw_scene(LAB, seed) for seed in range(40)]
    assert {scene.kind for scene in scenes} == {"person", "pallet"}
    assert len({scene.vehicle.kind for scene in scenes}) == 2
    for scene in scenes:
        assert floor.covers(LineString([(scene.start.x, scene.start.y), *scene.points]))
        first, then, walk_s = scene.place(scene.start, 0.3)
        front_m = max(x for x, _ in scene.vehicle.footprint)
        stands = then or first
        away_m = math.dist((stands.x, stands.y), (scene.start.x, scene.start.y))
        assert away_m > front_m + scene.ahead_m, "ahead of the robot's front"
        assert scene.kind == "person" or scene.ahead_m >= 0.35
        path = LineString([(scene.start.x, scene.start.y), *scene.points])
        assert path.distance(Point(stands.x, stands.y)) < 0.12, "on its path"
        assert (walk_s > 0) == (scene.kind == "person")


def test_a_pallet_left_on_the_path_stops_the_robot_that_drives_on_when_it_is_gone() -> None:
    seed = next(seed for seed in range(50) if draw_scene(LAB, seed).kind == "pallet")
    trial = conduct(LAB, draw_scene(LAB, seed), Watcher.BOTH)
    assert trial.contacts == 0
    assert trial.reaction_s is not None and 0.0 < trial.reaction_s < 0.8
    assert trial.gap_m > 0.02
    assert trial.resumed is True


def test_who_steps_in_is_not_run_over_and_what_drops_into_the_field_is_not_hit() -> None:
    seed = next(seed for seed in range(50) if draw_scene(LAB, seed).kind == "person")
    person = conduct(LAB, draw_scene(LAB, seed), Watcher.SCANNER)
    drop = conduct(LAB, draw_scene(LAB, seed, drop=True), Watcher.SCANNER)
    assert (person.kind, drop.kind) == ("person", "drop")
    assert person.contacts == drop.contacts == 0
    assert drop.reaction_s is not None and drop.reaction_s < 0.3


def test_nothing_stops_it_on_an_empty_floor() -> None:
    stops = false_stops(LAB, "wifibot-14", 1, 5.0)
    assert stops.pop("metres") >= 1
    assert stops == {}


def test_the_figures_are_of_the_trials() -> None:
    def trial(seed: int, watcher: Watcher, reaction_s: float | None, contacts: int = 0, kind: str = "pallet") -> Trial:
        return Trial(seed, kind, watcher, 0.3, contacts, reaction_s, 0.1, True if watcher is Watcher.BOTH else None)

    trials = [trial(seed, watcher, 0.1 * seed) for seed in (1, 2, 3) for watcher in Watcher]
    trials += [trial(4, Watcher.BOTH, None, contacts=1, kind="person"), trial(9, Watcher.SCANNER, 0.2, kind="drop")]
    found = figures(trials)
    assert (found["scenes"], found["pallets"], found["people"], found["collisions"]) == (4, 3, 1, 1)
    assert found["reaction_camera_median_s"] == pytest.approx(0.2)
    assert (found["reaction_stops"], found["drops"], found["collisions_camera"]) == (3, 1, 0)


def test_the_command_prints_figures_and_draws_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "obstacles.png"
    options = ["--scenes", "1", "--drops", "0", "--empty", "1", "--workers", "1", "--plot", str(picture), "--json"]
    assert main(["experiment", "obstacles", *options]) == 0
    result = json.loads(capsys.readouterr().out)
    assert {"collisions", "reaction_camera_p95_s", "reaction_scanner_p95_s", "false_stops"} <= result["figures"].keys()
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_lab_without_scanners_is_told_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (Path(__file__).parents[2] / "labs/gulliver.yaml").read_text()
    file = tmp_path / "lab.yaml"
    file.write_text("\n".join(line for line in text.splitlines() if not line.strip().startswith("scanner: {pose")))
    assert main(["experiment", "obstacles", "--lab", str(file)]) == 2
    assert "no simulated vehicle with a scanner" in capsys.readouterr().err
