"""The messages of the live stream: a snapshot first, then changes."""

from typing import Literal

from pydantic import Field

from protocol.lab import ZoneSpec
from protocol.messages import EmergencyStop, Event, Route, SimulatedObject, SpeedZone, Waypoint
from server.views.base import View
from server.views.cameras import CameraView
from server.views.health import HealthView
from server.views.obstacles import ObstaclesView
from server.views.robots import RobotView


class LiveSnapshot(View):
    """All that there is; the first message of a connection. Ages within are as of `stamp_ns`, by the server's clock."""

    type: Literal["snapshot"]
    stamp_ns: int
    robots: dict[str, RobotView]
    cameras: dict[str, CameraView]
    waypoints: dict[str, Waypoint]
    routes: dict[str, Route]
    objects: dict[str, SimulatedObject]
    zones: dict[str, ZoneSpec]
    speed_zones: dict[str, SpeedZone] = Field(description="Those of the lab description and those drawn by operators.")
    estop: EmergencyStop
    obstacles: ObstaclesView | None
    health: HealthView
    events: list[Event] = Field(description="The newest of the history, oldest first.")


class LiveChanges(View):
    """What changed since the message before. An absent entry did not change, a null one is gone. Ages grow by themselves:
    nothing is sent because time passes."""

    type: Literal["changes"]
    stamp_ns: int
    robots: dict[str, RobotView | None] = Field(default_factory=dict)
    cameras: dict[str, CameraView | None] = Field(default_factory=dict)
    waypoints: dict[str, Waypoint | None] = Field(default_factory=dict)
    routes: dict[str, Route | None] = Field(default_factory=dict)
    objects: dict[str, SimulatedObject | None] = Field(default_factory=dict)
    zones: dict[str, ZoneSpec | None] = Field(default_factory=dict)
    speed_zones: dict[str, SpeedZone | None] = Field(default_factory=dict)
    estop: EmergencyStop | None = None
    obstacles: ObstaclesView | None = None
    health: HealthView | None = None
    events: list[Event] = Field(default_factory=list[Event], description="New lines of the history, oldest first.")
