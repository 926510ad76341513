"""Judges tracked poses against the truth: errors of position and heading, the share of frames that gave a pose, and the
jump of the error when another set of cameras takes over."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from geometry import angle_difference
from protocol.messages import TrackedPose, TruePose


@dataclass
class TrackingScore:
    """Collects samples; `figures` sums them up."""

    position_errors_m: list[float] = field(default_factory=list[float])
    heading_errors_rad: list[float] = field(default_factory=list[float])
    speed_errors_mps: list[float] = field(default_factory=list[float])
    jumps_m: list[float] = field(default_factory=list[float])
    handovers: int = 0
    visible_tags: int = 0
    found_tags: int = 0
    unexpected: int = 0
    _last: dict[str, tuple[tuple[str, ...], tuple[float, float]]] = field(default_factory=dict, repr=False)

    def tags(self, visible: Sequence[int], found: Sequence[int]) -> None:
        """One frame of one camera: vehicle tags that were wholly visible in it, and those that it gave a pose for."""
        self.visible_tags += len(visible)
        self.found_tags += len(set(visible) & set(found))
        self.unexpected += len(found) - len(set(found))

    def pose(self, tracked: TrackedPose, true: TruePose) -> None:
        """One tracked pose with the truth of its own instant."""
        error = (tracked.x - true.x, tracked.y - true.y)
        self.position_errors_m.append(math.hypot(*error))
        self.heading_errors_rad.append(abs(angle_difference(tracked.yaw, true.yaw)))
        true_vx, true_vy = true.linear_mps * math.cos(true.yaw), true.linear_mps * math.sin(true.yaw)
        self.speed_errors_mps.append(math.hypot(tracked.vx - true_vx, tracked.vy - true_vy))
        last = self._last.get(tracked.vehicle)
        if last is not None and last[0] != tracked.cameras:
            self.handovers += 1
            self.jumps_m.append(math.hypot(error[0] - last[1][0], error[1] - last[1][1]))
        self._last[tracked.vehicle] = (tracked.cameras, error)

    @property
    def has_figures(self) -> bool:
        """Whether anything was tracked that can be judged."""
        return bool(self.position_errors_m and self.visible_tags)

    def figures(self) -> dict[str, float | int]:
        """Flat figures, units in their names. ValueError when nothing was tracked: there is nothing to report then."""
        if not self.has_figures:
            raise ValueError("no pose was tracked, or no tag was ever visible")
        position_mm = np.array(self.position_errors_m) * 1e3
        heading_deg = np.degrees(self.heading_errors_rad)
        return {
            "position_error_median_mm": float(np.median(position_mm)),
            "position_error_p99_mm": float(np.percentile(position_mm, 99)),
            "position_error_max_mm": float(position_mm.max()),
            "heading_error_median_deg": float(np.median(heading_deg)),
            "heading_error_p99_deg": float(np.percentile(heading_deg, 99)),
            "velocity_error_median_mmps": float(np.median(self.speed_errors_mps)) * 1e3,
            "pose_share": self.found_tags / self.visible_tags,
            "handover_jump_max_mm": max(self.jumps_m, default=0.0) * 1e3,
            "handovers": self.handovers,
            "poses": len(self.position_errors_m),
            "duplicate_detections": self.unexpected,
        }
