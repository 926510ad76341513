"""The coverage experiment: its statistics against chance, its samples and figures on one small room."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from launcher.cli import main
from launcher.experiments.coverage import figures, measure
from launcher.experiments.coverage_plot import plot_coverage
from launcher.experiments.coverage_samples import Drive, Placements, RoomSamples
from launcher.experiments.fleets import with_fleet
from launcher.experiments.nees import consistency, nees
from launcher.experiments.rooms import surveyed_as_described
from protocol.lab import Lab, load_lab

GULLIVER = Path(__file__).resolve().parents[2] / "labs/gulliver.yaml"


def half_a_room() -> Lab:
    """The two middle cameras over their part of the floor."""
    whole = load_lab(GULLIVER)
    area = whole.areas[0].model_copy(update={"outline": ((1.9, -0.3), (6.1, -0.3), (6.1, 4.6), (1.9, 4.6))})
    return surveyed_as_described(whole).model_copy(update={"cameras": whole.cameras[1:3], "areas": (area,)})


def test_nees_of_honest_covariances_is_the_dimension() -> None:
    rng = np.random.default_rng(1)
    roots = rng.normal(size=(4000, 3, 3))
    errors = np.einsum("nij,nj->ni", roots, rng.normal(size=(4000, 3)))
    assert float(nees(errors, roots @ roots.transpose(0, 2, 1)).mean()) == pytest.approx(3.0, abs=0.15)


@pytest.mark.parametrize(("scale", "honest"), [(1.0, 0.90), (1.6, 0.0)])
def test_the_band_holds_what_is_honest_though_samples_of_a_room_hang_together(scale: float, honest: float) -> None:
    """24 rooms of 200 samples whose errors come from 3 independent draws: inside about 95 times of 100; with errors `scale`
    times as large hardly ever, since dishonesty does not widen the band."""
    rng = np.random.default_rng(2)
    inside = 0
    for _ in range(100):
        draws = scale * rng.normal(size=(24, 3, 3))
        rooms = [np.square(draw[rng.integers(0, 3, 200)]).sum(axis=1) for draw in draws]
        found = consistency(rooms, 3)
        inside += found.low <= found.mean <= found.high
        assert found.low < 3.0 < found.high
    assert inside >= 100 * honest if scale == 1.0 else inside <= 10


def test_one_room_tells_nothing_of_the_spread() -> None:
    with pytest.raises(ValueError, match="at least two rooms"):
        consistency([np.ones(5)], 3)


def test_a_fleet_has_tags_of_its_own() -> None:
    lab = with_fleet(load_lab(GULLIVER), 30)
    ids = {vehicle.tag.id for vehicle in lab.vehicles}
    assert len(ids) == len({vehicle.id for vehicle in lab.vehicles}) == 30
    assert not ids & set(lab.floor_tags.poses)
    assert {vehicle.tag.height_m for vehicle in lab.vehicles} == {0.25, 0.35}
    with pytest.raises(ValueError, match="no vehicle"):
        with_fleet(lab.model_copy(update={"vehicles": ()}), 2)


@pytest.fixture(scope="module")
def rooms() -> list[RoomSamples]:
    return measure(half_a_room(), range(5, 7), drives=1, cell_m=0.8)


def test_the_floor_is_covered_within_the_budget(rooms: list[RoomSamples]) -> None:
    found = figures(rooms)
    assert found["error_median_mm"] <= 1.5
    assert found["error_max_mm"] <= 6.0
    assert found["detection_share"] >= 0.99
    assert found["handover_jump_max_mm"] <= 3.0
    assert found["handovers"] >= 10
    assert found["poses"] >= 30
    assert found["nees_dimension"] == 3
    assert {room.seed for room in rooms if room.drive is not None} == {5}


def test_rooms_differ_and_are_made_anew_alike(rooms: list[RoomSamples]) -> None:
    one, other = (room.placements for room in rooms)
    assert one.places.shape == other.places.shape
    assert not np.array_equal(one.errors, other.errors, equal_nan=True)


def test_the_heat_map_is_a_picture(rooms: list[RoomSamples], tmp_path: Path) -> None:
    path = tmp_path / "new" / "coverage.png"
    plot_coverage(half_a_room(), Placements.joined([room.placements for room in rooms]), 0.8, path)
    picture = cv2.imread(str(path))
    assert picture is not None
    assert picture.shape[:2] == (1000, 900)
    assert path.stat().st_size < 300_000


def test_figures_count_what_nobody_found() -> None:
    """By hand: three places, two in view of a camera, one found 3 mm and 4 mm off."""
    errors = np.array([[0.003, 0.004, 0.0], [np.nan] * 3, [np.nan] * 3])
    covariances = np.full((3, 3, 3), np.nan)
    covariances[0] = np.diag([9e-6, 16e-6, 1e-6])
    part = Placements(np.zeros((3, 2)), np.array([2, 1, 0]), np.array([1, 0, 0]), errors, covariances)
    other = Placements(part.places, part.visible, part.found, 0.5 * errors, covariances)
    found = figures([RoomSamples(1, part, Drive(0.002, 3, 0.0025)), RoomSamples(2, other, None)])
    assert found["error_max_mm"] == pytest.approx(5.0)
    assert found["detection_share"] == pytest.approx(1 / 3)
    assert found["nees_mean"] == pytest.approx((2.0 + 0.5) / 2)
    assert (found["handover_jump_max_mm"], found["handovers"]) == (pytest.approx(2.0), 3)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--rooms", "1"], "--rooms must be at least 2"),
        (["--drives", "99"], "--drives must be from 0 to --rooms"),
        (["--cell", "0"], "--cell must be from 0.1 to 5 m"),
        (["--workers", "0"], "--workers must be at least 1"),
    ],
)
def test_bad_use_is_a_sentence(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["experiment", "coverage", "--lab", str(GULLIVER), *arguments]) == 2
    assert said in capsys.readouterr().err
