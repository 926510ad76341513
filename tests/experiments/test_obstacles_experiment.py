"""The obstacles experiment, here with a few scenes."""

import json
import math
from itertools import combinations
from pathlib import Path

import pytest
from shapely.geometry import LineString, Point, Polygon, box

from geometry import SE2
from launcher.cli import main
from launcher.experiments.detour_scenes import CLEARANCE_M, half_width_m, left_behind, outline_of, way_exists
from launcher.experiments.detour_trials import DetourTrial, conduct_detour
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
    stops = false_stops(LAB, "wifibot-14", 1, 10.0)
    assert stops.pop("metres") >= 2, "around a corner too"
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


def wall_with_a_gap(gap_m: float) -> list[Polygon]:
    """Across the whole floor at x = 3."""
    return [box(3.0, -1.0, 3.4, 2.0), box(3.0, 2.0 + gap_m, 3.4, 6.0)]


@pytest.mark.parametrize(
    ("things", "stops", "exists"),
    [
        pytest.param([], [((6.0, 2.0), 0.2)], True, id="empty floor"),
        pytest.param(wall_with_a_gap(0.93), [((6.0, 2.0), 0.2)], True, id="a gap just wide enough"),
        pytest.param(wall_with_a_gap(0.91), [((6.0, 2.0), 0.2)], False, id="a gap a little too narrow"),
        pytest.param([box(3.0, 0.63, 3.4, 6.0)], [((6.0, 2.0), 0.2)], True, id="along the border"),
        pytest.param([box(3.0, 0.31, 3.4, 6.0)], [((6.0, 2.0), 0.2)], False, id="too near the border"),
        pytest.param([box(5.9, 2.3, 6.1, 2.5)], [((6.0, 2.0), 0.2)], False, id="the goal has no room"),
        pytest.param([box(3.9, 2.3, 4.1, 2.5)], [((4.0, 2.0), 0.2), ((6.0, 2.0), 0.2)], True, id="beside a waypoint"),
        pytest.param([box(3.9, 2.1, 4.1, 2.5)], [((4.0, 2.0), 0.05), ((6.0, 2.0), 0.2)], False, id="on a waypoint"),
        pytest.param([box(1.1, 1.9, 1.3, 2.1)], [((6.0, 2.0), 0.2)], False, id="the robot has no room"),
    ],
)
def test_a_way_is_where_the_body_and_its_clearance_fit(
    things: list[Polygon], stops: list[tuple[tuple[float, float], float]], exists: bool
) -> None:
    vehicle = LAB.vehicle("wifibot-14")
    assert half_width_m(vehicle) + CLEARANCE_M == pytest.approx(0.46)
    assert way_exists(LAB, vehicle, SE2(1.0, 2.0, 0.0), stops, things) is exists


def test_pallets_are_left_behind_in_rows_across_the_path_away_from_the_robot() -> None:
    floor = Polygon(LAB.areas[0].outline)
    counts: set[int] = set()
    for seed in range(40):
        scene = draw_scene(LAB, seed)
        if scene.kind != "pallet":
            continue
        things = left_behind(scene, LAB, scene.start, 0.3)
        assert things == left_behind(scene, LAB, scene.start, 0.3)
        counts.add(len(things))
        outlines = [outline_of(thing) for thing in things]
        assert outlines[0].distance(LineString([(scene.start.x, scene.start.y), *scene.points])) == 0.0
        assert all(floor.intersects(outline) for outline in outlines[1:])
        nearest_m = min(outline.distance(Point(scene.start.x, scene.start.y)) for outline in outlines)
        assert nearest_m >= half_width_m(scene.vehicle) + CLEARANCE_M
        assert not any(a.intersects(b) for a, b in combinations(outlines, 2))
    assert counts >= {1, 2, 3, 4}


def test_a_robot_gets_to_its_goal_around_what_is_left_behind() -> None:
    trial = conduct_detour(LAB, draw_scene(LAB, 18))
    assert trial.way
    assert trial.arrived and trial.diverted
    assert trial.contacts == 0
    assert trial.clearance_m is not None and trial.clearance_m >= 0.25
    assert math.dist(trial.track[-1], trial.points[-1]) < 0.16


def test_a_robot_whose_goal_has_no_room_waits_and_says_that_there_is_no_way() -> None:
    trial = conduct_detour(LAB, draw_scene(LAB, 2))
    assert not trial.way
    assert trial.told and not trial.arrived
    assert trial.contacts == 0
    assert trial.gap_m >= 0.25


def test_the_share_of_detours_is_of_scenes_with_a_way() -> None:
    def trial(*, way: bool, arrived: bool, diverted: bool = True, contacts: int = 0) -> DetourTrial:
        return DetourTrial(
            1, (), (), way, arrived, diverted, not way, contacts, 0.2, 0.3 if arrived else None, 20.0, ()
        )

    both = Trial(1, "pallet", Watcher.BOTH, 0.3, 0, 0.2, 0.1, True)
    single = [Trial(1, "pallet", watcher, 0.3, 0, 0.2, 0.1) for watcher in (Watcher.CAMERA, Watcher.SCANNER)]
    detours = [
        trial(way=True, arrived=True),
        trial(way=True, arrived=True, diverted=False),
        trial(way=True, arrived=True, contacts=1),
        trial(way=True, arrived=False),
        trial(way=False, arrived=False),
    ]
    found = figures([both, *single], detours)
    assert found["detour_share"] == pytest.approx(0.5)
    assert (found["detour_scenes"], found["detour_ways"], found["detour_no_way_told"]) == (5, 4, 1)
    assert (found["collisions"], found["collisions_detour"]) == (1, 1)
    assert found["detour_clearance_min_m"] == pytest.approx(0.3)


def test_the_command_prints_figures_and_draws_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "obstacles.png"
    # A person right before the robot, and then two pallets that leave room.
    options = ["--seed", "30", "--scenes", "2", "--drops", "0", "--empty", "1", "--workers", "1"]
    assert main(["experiment", "obstacles", *options, "--plot", str(picture), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["figures"]
    assert {"reaction_camera_p95_s", "reaction_scanner_p95_s", "detour_clearance_min_m"} <= found.keys()
    assert (found["collisions"], found["false_stops"], found["detour_share"]) == (0, 0, 1.0)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_lab_without_scanners_is_told_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (Path(__file__).parents[2] / "labs/gulliver.yaml").read_text()
    file = tmp_path / "lab.yaml"
    file.write_text("\n".join(line for line in text.splitlines() if not line.strip().startswith("scanner: {pose")))
    assert main(["experiment", "obstacles", "--lab", str(file)]) == 2
    assert "no simulated vehicle with a scanner" in capsys.readouterr().err
