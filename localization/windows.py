"""Where to look in the next frame: around the tracks, and around what this camera saw last (spec localization, "What the
reports ask for next": one search per vehicle, its track projected into every camera that can see it)."""

from collections.abc import Collection, Iterable, Mapping, Sequence
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
_OBLIQUE = 3.0
"""Seen at an angle, a pixel is more metres away from the camera than across: so many times, and the way to the tag's edge."""
_MEMORY_S = 2.0
_MOMENT_S = 0.2
"""So long memory helps a track that does not know its speed yet."""
_MOST_MEMORY_MARGIN = 2.0
"""What was seen last is looked for at most this many sides away; further is the full search's work."""


def guesses_from_tracks(
    view: CameraView, known: KnownTags, predicted: Mapping[str, TrackedPose], stamp_ns: int
) -> list[TagGuess]:
    """A guess for every vehicle tag that should be wholly in the picture at `stamp_ns`; stale poses are left out."""
    wearers = _near_the_picture(view, known, predicted, stamp_ns)
    if not wearers:
        return []
    pixels, meant = view.project(_corners_in_map(wearers))
    squares, meant = pixels.reshape(-1, 4, 2), meant.reshape(-1, 4).all(axis=1)
    edges = squares - squares[:, [3, 0, 1, 2]]
    sides_px = np.sqrt(np.einsum("nij,nij->ni", edges, edges)).mean(axis=1)
    margins_px = _LEAST_MARGIN * sides_px + sides_px * [wearer.doubt_sides for wearer in wearers]
    size = np.array([view.model.width, view.model.height])
    reaches = (squares.min(axis=1) >= -margins_px[:, None]) & (squares.max(axis=1) <= size + margins_px[:, None])
    centres = squares.mean(axis=1)
    return [
        TagGuess(
            wearers[index].key,
            float(centres[index, 0]),
            float(centres[index, 1]),
            float(sides_px[index]),
            float(margins_px[index]),
        )
        for index in np.flatnonzero(meant & reaches.all(axis=1))
    ]


@dataclass(frozen=True, slots=True)
class _Wearer:
    """A vehicle with its tag's pose, T_map_tag, and by how many of the tag's sides it may be elsewhere."""

    key: TagKey
    vehicle: VehicleSpec
    tag: SE2
    doubt_sides: float


def _near_the_picture(
    view: CameraView, known: KnownTags, predicted: Mapping[str, TrackedPose], stamp_ns: int
) -> list[_Wearer]:
    """The tracked vehicles whose tags are in the picture or not far outside: most are before other cameras."""
    wearers: list[_Wearer] = []
    for key, vehicle in known.vehicles.items():
        pose = predicted.get(vehicle.id)
        if pose is None or not is_fresh(pose, stamp_ns):
            continue
        tag = pose_at(pose, stamp_ns) @ vehicle.tag.pose_on_vehicle()
        doubt_m = uncertainty_m(pose, stamp_ns, vehicle.limits)
        margin_m = _OBLIQUE * (doubt_m + _LEAST_MARGIN * vehicle.tag.size_m)
        if view.extent(vehicle.tag.height_m).is_near(tag.x, tag.y, margin_m):
            wearers.append(_Wearer(key, vehicle, tag, doubt_m / vehicle.tag.size_m))
    return wearers


def _corners_in_map(wearers: Sequence[_Wearer]) -> Array:
    """The corners of the vehicles' tags, shape (4 N, 3), metres, map frame."""
    squares = np.stack([tag_corners(wearer.vehicle.tag.size_m) for wearer in wearers])
    yaws = np.array([wearer.tag.yaw for wearer in wearers])
    c, s = np.cos(yaws)[:, None], np.sin(yaws)[:, None]
    corners = np.empty((len(wearers), 4, 3))
    corners[:, :, 0] = c * squares[:, :, 0] - s * squares[:, :, 1] + [[wearer.tag.x] for wearer in wearers]
    corners[:, :, 1] = s * squares[:, :, 0] + c * squares[:, :, 1] + [[wearer.tag.y] for wearer in wearers]
    corners[:, :, 2] = [[wearer.vehicle.tag.height_m] for wearer in wearers]
    return corners.reshape(-1, 3)


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
