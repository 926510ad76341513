"""The obstacle box and the detours in force: one rule for guidance, which obeys it, and for the console, which shows it."""

from protocol.lab import Detours, ObstacleBox
from protocol.messages import RobotSettings


def effective_box(box: ObstacleBox, settings: RobotSettings | None) -> ObstacleBox:
    """The lab's obstacle box with what the operator has set over it."""
    if settings is None:
        return box
    given = {
        "start_m": settings.box_start_m,
        "length_m": settings.box_length_m,
        "width_m": settings.box_width_m,
        "stop_at_waypoint": settings.stop_at_waypoint,
        "robots": settings.box_robots,
        "unknown": settings.box_unknown,
    }
    return box.model_copy(update={name: value for name, value in given.items() if value is not None})


def effective_detours(detours: Detours, settings: RobotSettings | None) -> Detours:
    """The lab's rule about detours with what the operator has set over it."""
    if settings is None:
        return detours
    given = {
        "enabled": settings.detours,
        "after_s": settings.detour_after_s,
        "clearance_m": settings.detour_clearance_m,
    }
    return detours.model_copy(update={name: value for name, value in given.items() if value is not None})
