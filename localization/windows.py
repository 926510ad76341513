"""Where to look in the next frame: around the tracks, and around what this camera saw last (spec localization, "What the
reports ask for next": one search per vehicle, its track projected into every camera that can see it)."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import SE2
from localization.detection import TagGuess, TagObservation
from localization.prediction import is_fresh, pose_at, uncertainty_m
from localization.projection import CameraView
from localization.tags import KnownTags, TagKey, tag_corners
from protocol.lab import VehicleSpec
from protocol.messages import TrackedPose

Array = NDArray[np.float64]

_LEAST_MARGIN = 0.2
"""Every window is at least this share of the tag's side wider than the tag: corners turn and blur."""
_MEMORY_S = 2.0
_MOMENT_S = 0.2
"""So long memory helps a track that does not know its speed yet."""
_MOST_MEMORY_MARGIN = 2.0
"""What was seen last is looked for at most this many sides away; further is the full search's work."""


def guesses_from_tracks(
    view: CameraView, known: KnownTags, predicted: Mapping[str, TrackedPose], stamp_ns: int
) -> list[TagGuess]:
    """A guess for every vehicle tag that should be wholly in the picture at `stamp_ns`; stale poses are left out."""
    wearers = [
        (key, vehicle, predicted[vehicle.id])
        for key, vehicle in known.vehicles.items()
        if vehicle.id in predicted and is_fresh(predicted[vehicle.id], stamp_ns)
    ]
    if not wearers:
        return []
    corners = np.concatenate([_corners_in_map(vehicle, pose_at(pose, stamp_ns)) for _, vehicle, pose in wearers])
    pixels, meant = view.project(corners)
    guesses: list[TagGuess] = []
    for index, (key, vehicle, pose) in enumerate(wearers):
        of_tag = slice(4 * index, 4 * index + 4)
        if not meant[of_tag].all():
            continue
        square = pixels[of_tag]
        side_px = float(np.linalg.norm(square - np.roll(square, 1, axis=0), axis=1).mean())
        doubt_px = uncertainty_m(pose, stamp_ns, vehicle.limits) * side_px / vehicle.tag.size_m
        margin_px = _LEAST_MARGIN * side_px + doubt_px
        low, high = square.min(axis=0), square.max(axis=0)
        size = np.array([view.model.width, view.model.height])
        if (low >= -margin_px).all() and (high <= size + margin_px).all():
            x, y = square.mean(axis=0)
            guesses.append(TagGuess(key, float(x), float(y), side_px, margin_px))
    return guesses


def _corners_in_map(vehicle: VehicleSpec, pose: SE2) -> Array:
    """The corners of a vehicle's tag, shape (4, 3), metres, map frame."""
    T_map_tag = pose @ vehicle.tag.pose_on_vehicle()
    return np.column_stack([T_map_tag.apply(tag_corners(vehicle.tag.size_m)), np.full(4, vehicle.tag.height_m)])


@dataclass(frozen=True, slots=True)
class _Seen:
    stamp_ns: int
    x: float
    y: float
    side_px: float


class LastSeen:
    """Remembers where this camera saw each vehicle's tag, for when no track says where it is."""

    def __init__(self, known: KnownTags) -> None:
        self._known = known
        self._seen: dict[TagKey, _Seen] = {}

    def remember(self, tags: Iterable[TagObservation], stamp_ns: int) -> None:
        for tag in tags:
            if tag.key in self._known.vehicles:
                x, y = tag.centre
                self._seen[tag.key] = _Seen(stamp_ns, float(x), float(y), tag.side_px)

    def guesses(self, stamp_ns: int, found: Collection[TagKey], tracked: Collection[TagKey]) -> list[TagGuess]:
        """A guess for every tag seen within the last two seconds, the wider the longer ago; none for those `found` already,
        and after a moment none for `tracked` ones: a vehicle that drove on is not looked for at the picture's edge."""
        guesses: list[TagGuess] = []
        for key, seen in self._seen.items():
            age_s = (stamp_ns - seen.stamp_ns) * 1e-9
            longest_s = _MOMENT_S if key in tracked else _MEMORY_S
            if key in found or not 0 <= age_s <= longest_s:
                continue
            vehicle = self._known.vehicles[key]
            travelled_px = vehicle.limits.speed_mps * age_s * seen.side_px / vehicle.tag.size_m
            margin_px = min(_LEAST_MARGIN * seen.side_px + travelled_px, _MOST_MEMORY_MARGIN * seen.side_px)
            guesses.append(TagGuess(key, seen.x, seen.y, seen.side_px, margin_px))
        return guesses
