"""What one camera looks for in a frame, and where: windows around tracks and memories, the floor tags in turn, and the whole
picture, spread over frames or at once (spec localization, "The pipeline of 2025", steps 2 and 3)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from localization.calibration import SelfCalibration
from localization.detection import (
    FullSearch,
    MotionSearch,
    SpreadSearch,
    TagDetector,
    TagGuess,
    TagObservation,
    TagSearch,
    Tiling,
    WindowedSearch,
    is_whole,
    tiling,
    without_duplicates,
)
from localization.floor_watch import FloorWatch
from localization.prediction import is_fresh
from localization.projection import CameraView
from localization.search_plan import SearchPlan
from localization.tag_sizes import floor_tag_sizes, vehicle_tag_sizes
from localization.tags import KnownTags, TagKey
from localization.windows import LastSeen, guesses_from_tracks
from protocol.clock import Clock
from protocol.frames import Frame
from protocol.messages import TrackedPose

_UNCALIBRATED_SIDE = 0.0145
_LEAST_SIDE_PX = 14.0
"""Before a camera knows its height it is asked for tags from this share of the picture's width on (28 px in Full HD), and while
that does not show enough floor tags, for ever smaller ones."""
_ENOUGH_FLOOR_TAGS = 2
_LONGEST_PAUSE_S = 0.2
"""What a longer gap between frames would allow to be searched is not made up for in one frame."""


@dataclass(frozen=True, slots=True)
class Sightings:
    """The vehicle tags in a frame; whether a search of the whole picture was completed in it; what windows and what the search
    of the whole took."""

    vehicles: list[TagObservation]
    full_search: bool
    window_ms: float
    full_ms: float


class CameraSearch:
    """Finds the tags in one camera's frames and shows the floor tags to its calibration. Belongs to one thread.

    `width` is the picture's; `every` a fixed K, None the adaptive search with `budget_ms` per frame; `rate_hz` the camera's;
    `turn`, from 0 to 1, shifts searches of whole frames against other cameras'.
    """

    def __init__(
        self,
        known: KnownTags,
        calibration: SelfCalibration,
        clock: Clock,
        *,
        width: int,
        every: int | None,
        budget_ms: float,
        rate_hz: float,
        turn: float,
    ) -> None:
        self._known, self._calibration, self._clock = known, calibration, clock
        detector = TagDetector(known.families(), known.keys())
        self._first_side_px = max(_LEAST_SIDE_PX, _UNCALIBRATED_SIDE * width)
        self._full = FullSearch(detector, self._first_side_px)
        self._motion = MotionSearch(detector)
        self._spread = SpreadSearch(detector, clock, budget_ms)
        self._windowed = WindowedSearch(detector)
        self._watch = FloorWatch(WindowedSearch(detector, last_resorts=False), known)
        self._last_seen = LastSeen(known)
        self._rarely = max(1, every or round(rate_hz))
        self._plan = SearchPlan([vehicle.id for vehicle in known.vehicles.values()], every, int(turn * self._rarely))
        self._adaptive = every is None
        self._aimed_at: CameraView | None = None
        self._tilings: dict[bool, Tiling] = {}
        self._uncalibrated = int(turn * self._rarely)
        self._last_ns: int | None = None
        self._seen: frozenset[TagKey] = frozenset()
        self.floor_tags: tuple[TagObservation, ...] = ()
        """The floor tags in the newest complete look at them."""

    def find(self, frame: Frame, predicted: Mapping[str, TrackedPose]) -> Sightings:
        """The vehicle tags in the frame; `predicted` are tracks by vehicle id, of any time."""
        start_s = self._clock.monotonic_s()
        since_s = self._since_s(frame.stamp_ns)
        first = self._last_ns is None
        self._last_ns = frame.stamp_ns
        self._aim()
        tracked = {name for name, pose in predicted.items() if is_fresh(pose, frame.stamp_ns)}
        self._plan.note(frame.stamp_ns, tracked | {self._known.vehicles[key].id for key in self._seen})
        whole = first or self._whole_frame_due(frame.stamp_ns)
        tags = self._in_windows(frame, predicted, tracked, remember=not whole)
        whole = self._watch_floor(frame, since_s, whole=whole)
        windowed_s = self._clock.monotonic_s()
        completed = False
        if whole:
            tags += self._whole(frame)
            completed = True
        elif self._adaptive and self._aimed_at is not None:
            tags, completed = self._elsewhere(frame, since_s, tags)
        vehicles = [tag for tag in without_duplicates(tags) if tag.key in self._known.vehicles]
        self._last_seen.remember(vehicles, frame.stamp_ns)
        self._seen = frozenset(tag.key for tag in vehicles)
        done_s = self._clock.monotonic_s()
        return Sightings(vehicles, completed, (windowed_s - start_s) * 1e3, (done_s - windowed_s) * 1e3)

    def _since_s(self, stamp_ns: int) -> float:
        if self._last_ns is None:
            return 0.0
        return min(_LONGEST_PAUSE_S, max(0.0, (stamp_ns - self._last_ns) * 1e-9))

    def _aim(self) -> None:
        """Once the camera knows its place, searches are as coarse as the smallest tag in its view allows."""
        view = self._calibration.view
        if view is self._aimed_at:
            return
        self._aimed_at = view
        self._watch.aim(view)
        if view is not None:
            floor, vehicles = floor_tag_sizes(view, self._known), vehicle_tag_sizes(view, self._known)
            self._full.side_px = min((kind.least_px for kind in floor + vehicles), default=self._first_side_px)
            width, height = view.model.width, view.model.height
            self._tilings = {blind: tiling(width, height, vehicles + floor * blind) for blind in (False, True)}
            self._spread.aim(self._tilings[False])
            self._motion.aim(self._tilings[False].levels)

    def _whole_frame_due(self, stamp_ns: int) -> bool:
        if self._plan.whole_frame_due(stamp_ns):
            return True
        if self._calibration.view is not None:
            return False
        # Without a calibration there are no poses that a long search could delay.
        self._uncalibrated += 1
        return self._calibration.eager or self._uncalibrated % self._rarely == 0

    def _in_windows(
        self, frame: Frame, predicted: Mapping[str, TrackedPose], tracked: set[str], *, remember: bool
    ) -> list[TagObservation]:
        """Around tracks first; what they did not show, where it was last."""
        view = self._calibration.view
        guesses = [] if view is None else guesses_from_tracks(view, self._known, predicted, frame.stamp_ns)
        tags = self._search(self._windowed, frame, guesses)
        if remember:
            keys = {key for key, vehicle in self._known.vehicles.items() if vehicle.id in tracked}
            memory = self._last_seen.guesses(frame.stamp_ns, {tag.key for tag in tags}, keys)
            tags += self._search(self._windowed, frame, memory)
        return tags

    def _watch_floor(self, frame: Frame, since_s: float, *, whole: bool) -> bool:
        """Floor tags for the calibration, one by one or, when it wants more at once, all; returns whether the whole picture is
        to be searched, since windows do not show them all."""
        if whole or self._calibration.view is None:
            return whole
        if self._calibration.eager:
            look = self._watch.look(frame.pixels)
            if len({tag.key for tag in look} & self._known.floor.keys()) < max(_ENOUGH_FLOOR_TAGS, self._watch.expects):
                return True
            self._observe(look, frame.stamp_ns)
            return False
        finished = self._watch.step(frame.pixels, since_s)
        if finished is not None:
            self._observe(finished, frame.stamp_ns)
        return False

    def _whole(self, frame: Frame) -> list[TagObservation]:
        tags = self._search(self._full, frame)
        self._observe(tags, frame.stamp_ns)
        self._spread.restart()
        if self._aimed_at is None and len(self.floor_tags) < _ENOUGH_FLOOR_TAGS:
            finer_px = self._full.side_px / 2
            self._full.side_px = finer_px if finer_px >= _LEAST_SIDE_PX * 0.9 else self._first_side_px
        return tags

    def _elsewhere(
        self, frame: Frame, since_s: float, found: list[TagObservation]
    ) -> tuple[list[TagObservation], bool]:
        """What was found with what comes to it from where something moves and from some tiles; whether that ends a round."""
        tags = list(found)
        if self._plan.is_missing(frame.stamp_ns):
            tags += self._motion.find(frame.pixels, found)
        blind = self._watch.blind
        self._spread.aim(self._tilings[blind])
        step = self._spread.step(frame.pixels, since_s, 0.0 if blind else self._plan.round_s(frame.stamp_ns))
        if step.round_tags is not None and blind:
            # Windows do not show the floor tags: they are covered, or somewhere else.
            self._observe(step.round_tags, frame.stamp_ns)
        return tags + step.tags, step.round_tags is not None

    def _observe(self, tags: Sequence[TagObservation], stamp_ns: int) -> None:
        self.floor_tags = tuple(tag for tag in tags if tag.key in self._known.floor)
        self._calibration.observe(tags, stamp_ns)

    def _search(self, search: TagSearch, frame: Frame, guesses: Sequence[TagGuess] = ()) -> list[TagObservation]:
        return [tag for tag in search.find(frame.pixels, guesses) if is_whole(tag, frame.pixels)]
