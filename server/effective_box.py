"""The obstacle box in force: one rule for guidance, which obeys it, and for the console, which shows it."""

from protocol.lab import ObstacleBox
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
    }
    return box.model_copy(update={name: value for name, value in given.items() if value is not None})
