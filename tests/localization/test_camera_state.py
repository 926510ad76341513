"""What a camera says of itself: what is wrong, and since when."""

from dataclasses import dataclass
from typing import cast

from localization.camera_state import CameraStatistics
from localization.pipeline import CameraPipeline
from localization.sources import SourceState
from protocol.lab import CameraSpec
from protocol.messages import CameraExtrinsics, CameraState
from tests.localization.synthetic import small_lab

SECOND = 10**9
START_NS = 1_700_000_000 * SECOND
WELL = SourceState(connected=True, error=None, received=9, broken=0, skipped=0)


@dataclass
class SeenPipeline:
    """What the statistics look at of a pipeline."""

    spec: CameraSpec
    extrinsics: CameraExtrinsics | None = None
    problem: str | None = None
    floor_tags_seen: tuple[int, ...] = ()


class Camera:
    """A camera's statistics over seconds."""

    def __init__(self) -> None:
        self.pipeline = SeenPipeline(small_lab().camera("left"))
        self.statistics = CameraStatistics(0.0)

    def at(self, second: float, source: SourceState = WELL) -> CameraState:
        pipeline = cast("CameraPipeline", self.pipeline)
        return self.statistics.state(source, pipeline, second, START_NS + round(second * SECOND))


def test_since_when_a_source_is_silent_is_its_own_word() -> None:
    silent = SourceState(False, "no frame for 3.2 s", 9, 0, 0, error_since_ns=START_NS - 3)
    state = Camera().at(5.0, silent)
    assert (state.error, state.error_since_ns) == ("no frame for 3.2 s", START_NS - 3)


def test_a_problem_begins_once_however_its_words_change() -> None:
    camera = Camera()
    assert (camera.at(0.0).error, camera.at(0.0).error_since_ns) == (None, None)
    for second in (1.0, 2.0, 3.0):
        camera.pipeline.problem = f"the camera moved: floor tags are {second:.0f} mm off; calibrating again"
        state = camera.at(second)
        assert (state.error, state.error_since_ns) == (camera.pipeline.problem, START_NS + SECOND)
    camera.pipeline.problem = None
    assert camera.at(4.0).error_since_ns is None
    camera.pipeline.problem = "another"
    assert camera.at(5.0).error_since_ns == START_NS + 5 * SECOND


def test_a_camera_that_loses_all_its_floor_tags_says_so() -> None:
    camera = Camera()
    assert camera.at(10.0).error is None, "it never saw any: that is the calibration's to say"
    camera.pipeline.floor_tags_seen = (1, 2)
    camera.at(11.0)
    camera.pipeline.floor_tags_seen = ()
    assert camera.at(12.9).error is None, "one search may miss them"
    state = camera.at(13.5)
    assert state.error == "none of its floor tags is seen any more: is it covered, dark, or disturbed?"
    assert state.error_since_ns == START_NS + 11 * SECOND
    camera.pipeline.floor_tags_seen = (1,)
    assert camera.at(14.0).error is None
