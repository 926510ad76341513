"""The search of the whole picture without a frame that pays for it: tiles, their pace, newcomers, and the watched floor tags."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry import SE2
from localization.detection import FullSearch, SpreadSearch, TagDetector, TagObservation, TagSizes, tiling
from localization.pipeline import CameraPipeline, PipelineOptions
from localization.search_plan import SearchPlan
from protocol.clock import SimulatedClock
from protocol.frames import Frame
from protocol.messages import CameraExtrinsics, TrackedPose
from tests.localization.synthetic import MOUNTS, PlacedTag, floor_tags, mount, render, small_lab, vehicle_tag

LAB = small_lab()
MODEL = LAB.camera("left").model()
SIZES = [TagSizes(40.0, 55.0)]
START_NS = 1_000_000_000_000


class TileClock(SimulatedClock):
    """Every second look at it, so every tile, takes that long."""

    def __init__(self, tile_ms: float) -> None:
        super().__init__()
        self.tile_ms, self._looks = tile_ms, 0

    def monotonic_s(self) -> float:
        self._looks += 1
        if self._looks % 2 == 0:
            self.wait(self.tile_ms * 1e-3)
        return super().monotonic_s()


@given(
    st.integers(60, 3840),
    st.integers(60, 2160),
    st.lists(st.tuples(st.floats(10, 150), st.floats(1.0, 2.0)), min_size=1, max_size=3),
    st.floats(0, 1),
    st.floats(0, 1),
)
def test_every_tag_lies_wholly_in_a_tile_that_is_fine_enough(
    width: int, height: int, kinds: list[tuple[float, float]], x: float, y: float
) -> None:
    tiles = tiling(width, height, [TagSizes(least, least * spread) for least, spread in kinds])
    for least, spread in kinds:
        reach = least * spread * 1.25 * 2**0.5  # turned by 45 degrees, with its white border
        if reach > min(width, height):
            continue
        left, top = x * (width - reach), y * (height - reach)
        assert any(
            tile.box.left <= left
            and tile.box.top <= top
            and left + reach <= tile.box.right
            and top + reach <= tile.box.bottom
            and (tile.level.decimation == 1.0 or least / tile.level.decimation >= 18.0)
            for tile in tiles.rim + tiles.inside
        )


def test_tiles_cover_nothing_outside_and_cost_little_more_than_the_whole() -> None:
    tiles = tiling(1920, 1080, [TagSizes(58.0, 70.0)])
    for tile in tiles.rim + tiles.inside:
        assert 0 <= tile.box.left < tile.box.right <= 1920
        assert 0 <= tile.box.top < tile.box.bottom <= 1080
    whole_ms = tiles.levels[0].nominal_ms(1920 * 1080)
    assert tiles.nominal_ms < 1.7 * whole_ms, "overlaps cost the rest"


def test_a_round_finds_what_a_whole_search_finds() -> None:
    tags = [*floor_tags(LAB), vehicle_tag(LAB, "robot-10", SE2(0.7, 0.6, 0.8))]
    image = render(MODEL, MOUNTS["left"], tags)
    detector = TagDetector(["tag36h11"])
    search = SpreadSearch(detector, SimulatedClock(), 0.8)
    search.aim(tiling(MODEL.width, MODEL.height, SIZES))
    everywhere = {tag.key: tag.corners for tag in FullSearch(detector, 40.0).find(image)}
    assert len(everywhere) == 5
    seen_before: set[tuple[str, int]] = set()
    for number in range(40):
        step = search.step(image, 1 / 60, 0.0)
        seen_before |= {tag.key for tag in step.tags}
        if step.round_tags is not None:
            assert number > 1, "spread over frames"
            assert {tag.key for tag in step.round_tags} == seen_before == set(everywhere)
            for tag in step.round_tags:
                assert tag.corners == pytest.approx(everywhere[tag.key], abs=0.15)
            return
    pytest.fail("the round never ended")


@pytest.mark.parametrize("tile_ms", [0.5, 2.0, 9.0])
def test_frames_keep_to_their_budget_however_slow_the_machine_is(tile_ms: float) -> None:
    clock = TileClock(tile_ms)
    search = SpreadSearch(TagDetector(["tag36h11"]), clock, 3.0)
    search.aim(tiling(960, 540, [TagSizes(20.0, 25.0)]))
    image = np.full((540, 960), 90, np.uint8)
    took_ms: list[float] = []
    rounds = 0
    for _ in range(150):
        before = clock.now_ns()
        rounds += search.step(image, 1 / 60, 0.0).round_tags is not None
        took_ms.append((clock.now_ns() - before) * 1e-6)
    settled = took_ms[50:]  # by then it knows how long tiles take
    assert max(settled) <= max(3.0, tile_ms) + 0.1
    assert np.mean(settled) <= 3.1
    assert rounds >= 1


def test_the_pace_spreads_a_round_over_the_time_it_may_take() -> None:
    search = SpreadSearch(TagDetector(["tag36h11"]), SimulatedClock(), 3.0)
    search.aim(tiling(960, 540, SIZES))
    image = np.full((540, 960), 90, np.uint8)
    ends = [n for n in range(600) if search.step(image, 1 / 60, 2.0).round_tags is not None]
    gaps = np.diff(ends) / 60
    assert len(gaps) >= 3
    assert 1.5 <= float(gaps.mean()) <= 2.5


def test_the_rim_is_searched_more_often_than_the_inside() -> None:
    tiles = tiling(1920, 1080, [TagSizes(20.0, 25.0)])
    assert len(tiles.inside) > 2 * len(tiles.rim)
    search = SpreadSearch(TagDetector(["tag36h11"]), SimulatedClock(), 3.0)
    search.aim(tiles)
    image = np.full((1080, 1920), 90, np.uint8)
    picture = render(MODEL, MOUNTS["left"], [PlacedTag(10, SE2(0.75, 0.5, 0.0), 0.0, 0.08)])
    image[:80, :80] = picture[230:310, 440:520]
    seen = [n for n in range(len(tiles.rim + tiles.inside)) if search.step(image, 1 / 60, 0.0).tags]
    assert len(seen) >= 2, "a newcomer at the rim is seen more than once in a round"


def test_how_fast_follows_what_is_missing() -> None:
    plan = SearchPlan(["a", "b"], None, 0)
    second = 1_000_000_000

    def after(seconds: float, *tracked: str) -> float:
        stamp_ns = START_NS + round(seconds * second)
        plan.note(stamp_ns, tracked)
        return plan.round_s(stamp_ns)

    assert after(0.0) == 0.0, "at the start everything is missing"
    nothing = after(5.0)
    assert nothing > 0.0
    both = after(6.0, "a", "b")
    assert both > nothing
    assert after(6.1, "a") == 0.0, "just lost"
    one = after(9.0, "a")
    assert nothing < one < both
    assert after(9.1, "a", "b") == both


# --- with a camera around it ---


def truth(camera: str) -> CameraExtrinsics:
    T = MOUNTS[camera]
    rx, ry, rz = (float(v) for v in T.rotvec())
    x, y, z = (float(v) for v in T.translation)
    return CameraExtrinsics(camera, 0, (rx, ry, rz), (x, y, z), 0.05, (0, 1, 2, 3))


class Watching:
    """A calibrated camera at some rate that looks at still pictures."""

    def __init__(self, rate_hz: float) -> None:
        self.rate_hz, self.number = rate_hz, 0
        self.pipeline = CameraPipeline(
            LAB,
            "left",
            clock=SimulatedClock(),
            options=PipelineOptions(calibration_frames=3),
            extrinsics=truth("left"),
        )
        self.tracks: dict[str, TrackedPose] = {}

    def look(self, image: np.ndarray[tuple[int, int], np.dtype[np.uint8]]) -> set[int]:
        """Ids of the vehicles found in the next frame."""
        stamp_ns = START_NS + round(self.number * 1e9 / self.rate_hz)
        found = self.pipeline.process(Frame(self.number, stamp_ns, image), self.tracks)
        self.number += 1
        return {detection.tag_id for detection in found.detections}

    def settle(self) -> "Watching":
        for _ in range(12):
            self.look(STILL)
        assert self.pipeline.problem is None
        return self


STILL = render(MODEL, MOUNTS["left"], floor_tags(LAB))


@pytest.mark.parametrize("rate_hz", [15.0, 60.0])
@pytest.mark.parametrize("shift_m", [0.02, 0.3])
def test_a_bumped_camera_is_noticed_and_finds_its_place_again(rate_hz: float, shift_m: float) -> None:
    camera = Watching(rate_hz).settle()
    x, y, z = (float(v) for v in MOUNTS["left"].translation)
    elsewhere = mount(x + shift_m, y, z, 0.02, 0.015, -0.01)
    moved = render(MODEL, elsewhere, floor_tags(LAB), seed=1)
    frames = 0
    while camera.pipeline.extrinsics is not None:
        camera.look(moved)
        frames += 1
        assert frames <= rate_hz, "not noticed within a second"
    for _ in range(6):
        camera.look(moved)
    assert camera.pipeline.extrinsics is not None
    assert camera.pipeline.extrinsics.translation[0] == pytest.approx(x + shift_m, abs=0.003)
    assert camera.pipeline.problem is None


@pytest.mark.parametrize("hidden", [{0}, {0, 3}, {0, 1, 2}, {0, 1, 2, 3}])
def test_covered_floor_tags_are_no_alarm(hidden: set[int]) -> None:
    camera = Watching(15.0).settle()
    before = camera.pipeline.extrinsics
    covered = render(MODEL, MOUNTS["left"], [tag for tag in floor_tags(LAB) if tag.tag_id not in hidden], seed=2)
    for _ in range(60):
        camera.look(covered)
    for _ in range(15):
        camera.look(STILL)
    assert camera.pipeline.extrinsics is before
    assert camera.pipeline.problem is None
    assert camera.pipeline.floor_tags_seen == (0, 1, 2, 3)


def test_floor_tags_are_watched_without_searching_whole_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    camera = Watching(60.0).settle()

    def refuse(*_: object) -> list[TagObservation]:
        raise AssertionError("a whole frame was searched")

    monkeypatch.setattr(FullSearch, "find", refuse)
    for _ in range(60):
        camera.look(STILL)
    assert camera.pipeline.floor_tags_seen == (0, 1, 2, 3)


def test_a_newcomer_that_moves_is_found_at_once() -> None:
    camera = Watching(60.0).settle()
    # All there is was lost long ago: the tiles are in no hurry.
    camera.number += 600
    camera.look(STILL)
    for number in range(4):
        pose = SE2(0.5 + 0.05 * number, 0.5, 0.3)
        arriving = render(MODEL, MOUNTS["left"], [*floor_tags(LAB), vehicle_tag(LAB, "robot-10", pose)], seed=number)
        if 10 in camera.look(arriving):
            return
    pytest.fail("not found within four frames")


def test_a_newcomer_that_stands_is_found_within_a_round() -> None:
    camera = Watching(60.0).settle()
    camera.number += 600
    still = render(MODEL, MOUNTS["left"], [*floor_tags(LAB), vehicle_tag(LAB, "robot-11", SE2(0.9, 0.5, 1.0))])
    assert any(11 in camera.look(still) for _ in range(40))
