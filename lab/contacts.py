"""Contacts on the simulated floor: nobody passes through anybody, and every new touch is counted once."""

from typing import Protocol

from shapely.geometry.base import BaseGeometry

from geometry import SE2

_APART_M = 0.01
"""Two bodies stay in contact until this far apart, so that one touch is not counted twice."""
_NEGLIGIBLE_M2 = 1e-9


class Body(Protocol):
    """Something with an outline that stands on the floor."""

    pose: SE2
    radius_m: float

    def footprint_at(self, pose: SE2) -> BaseGeometry: ...


def overlap_m2(body: Body, pose: SE2, other: Body) -> float:
    """Shared area of the two outlines with `body` at `pose`."""
    if not _within(body, pose, other, 0.0):
        return 0.0
    return float(body.footprint_at(pose).intersection(other.footprint_at(other.pose)).area)


def blocks(body: Body, pose: SE2, other: Body) -> bool:
    """Whether `other` keeps `body` from moving to `pose`: it would overlap more than now (moving apart is allowed)."""
    after = overlap_m2(body, pose, other)
    return after > _NEGLIGIBLE_M2 and after >= overlap_m2(body, body.pose, other) - _NEGLIGIBLE_M2


class ContactCounter:
    """Which pairs of bodies touch now, and how many touches there were since the start."""

    def __init__(self) -> None:
        self.count = 0
        self._touching: dict[tuple[str, str], tuple[Body, Body]] = {}

    def touch(self, a_id: str, a: Body, b_id: str, b: Body) -> None:
        """The two touch; counted unless they did already."""
        key = (a_id, b_id) if a_id < b_id else (b_id, a_id)
        if key not in self._touching:
            self.count += 1
            self._touching[key] = (a, b)

    def forget(self, body_id: str) -> None:
        """The body is gone."""
        self._touching = {key: pair for key, pair in self._touching.items() if body_id not in key}

    def release_parted(self) -> None:
        """Pairs that moved apart no longer touch."""
        for key, (a, b) in list(self._touching.items()):
            if not _within(a, a.pose, b, _APART_M) or (
                a.footprint_at(a.pose).distance(b.footprint_at(b.pose)) > _APART_M
            ):
                del self._touching[key]


def _within(body: Body, pose: SE2, other: Body, margin_m: float) -> bool:
    return pose.distance_to(other.pose) < body.radius_m + other.radius_m + margin_m
