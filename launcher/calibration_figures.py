"""The figures of calibrations as commands print them: flat, with units."""

from datetime import UTC, datetime
from typing import Any

from protocol.messages import Calibration, CalibrationProposal


def in_force_figures(calibration: Calibration) -> dict[str, Any]:
    """A result's own figures."""
    figures: dict[str, Any] = {
        "id": calibration.id,
        "by": calibration.by,
        "since": datetime.fromtimestamp(calibration.stamp_ns / 1e9, UTC).isoformat(timespec="seconds"),
    }
    for camera, found in calibration.cameras.items():
        name = camera.replace("-", "_")
        figures[f"{name}_reprojection_px"] = found.reprojection_px
        figures[f"{name}_floor_tags"] = list(found.floor_tags)
        if found.left_out:
            figures[f"{name}_left_out"] = list(found.left_out)
    shifts_m = [tag.shift_m for tag in calibration.floor_tags.values()]
    figures["floor_tag_shift_max_mm"] = max(shifts_m, default=0.0) * 1e3
    return figures


def proposal_figures(proposal: CalibrationProposal) -> dict[str, Any]:
    """What a proposal would change."""
    figures: dict[str, Any] = {"id": proposal.calibration.id, "not_answered": list(proposal.not_answered)}
    for camera, compared in proposal.cameras.items():
        name = camera.replace("-", "_")
        figures[f"{name}_floor_tags"] = list(compared.floor_tags)
        if compared.left_out:
            figures[f"{name}_left_out"] = list(compared.left_out)
        figures[f"{name}_reprojection_before_px"] = compared.reprojection_before_px
        figures[f"{name}_reprojection_after_px"] = compared.reprojection_after_px
        figures[f"{name}_floor_shift_mean_mm"] = _mm(compared.floor_shift_mean_m)
        figures[f"{name}_floor_shift_max_mm"] = _mm(compared.floor_shift_max_m)
        figures[f"{name}_floor_std_mm"] = _mm(compared.floor_std_after_m)
    for tag, moved in proposal.floor_tags.items():
        figures[f"floor_tag_{tag}_shift_mm"] = _mm(moved.shift_m)
    return figures


def _mm(metres: float | None) -> float | None:
    return None if metres is None else metres * 1e3
