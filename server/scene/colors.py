"""The scene's colours, and which one a robot has: by what guidance says of it, as in the console. Deeper than they are to
look: the renderer's tone mapping makes everything paler."""

from protocol.messages import ReasonCode
from server.scene.shapes import Color

FLOOR: Color = (26, 30, 36)
GRID: Color = (48, 55, 64)
GRID_SECTION: Color = (66, 75, 86)
AREA: Color = (110, 125, 145)
TAG: Color = (200, 205, 210)
ZONE: Color = (150, 60, 230)
CAMERA: Color = (20, 150, 190)
CAMERA_LOST: Color = (220, 30, 30)
WAYPOINT: Color = (0, 190, 70)
ROUTE: Color = (0, 130, 60)
PATH: Color = (0, 130, 230)
BOX_CLEAR: Color = (10, 80, 240)
BOX_TAKEN: Color = (235, 10, 50)
OBSTACLE: Color = (215, 15, 20)
BODY: Color = (30, 34, 42)
TAG_PLATE: Color = (230, 230, 230)
TAG_INK: Color = (8, 8, 9)

IDLE: Color = (120, 132, 148)
DRIVING: Color = (0, 175, 70)
WAITING: Color = (245, 150, 0)
MANUAL: Color = (120, 70, 240)
STOPPED: Color = (220, 20, 25)
LOST: Color = (80, 86, 96)

_OF_REASON: dict[ReasonCode, Color] = {
    ReasonCode.ROUTE: DRIVING,
    ReasonCode.MANUAL: MANUAL,
    ReasonCode.IDLE: IDLE,
    ReasonCode.ROUTE_DONE: IDLE,
    ReasonCode.EMERGENCY_STOP: STOPPED,
    ReasonCode.DRIVER_FAULT: STOPPED,
    ReasonCode.WAYPOINT_MISSING: STOPPED,
    ReasonCode.NOT_CONNECTED: LOST,
}


def of_reason(code: ReasonCode | None) -> Color:
    """The colour of a robot in that state; whatever makes it wait is amber, and one that nobody guides is grey."""
    return LOST if code is None else _OF_REASON.get(code, WAITING)
