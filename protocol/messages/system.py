"""What the system says of itself: its processes and the log of events."""

from enum import StrEnum
from typing import Literal

from pydantic import Field

from protocol.messages.base import Message, StampNs


class ProcessState(Message):
    """One process of the process table on one machine."""

    name: str
    state: Literal["starting", "running", "restarting", "stopped"]
    pid: int | None
    restarts: int
    since_ns: StampNs
    stamp_ns: StampNs
    last_error: str = Field(default="", description="How it ended the last time, e.g. 'killed by signal 9'.")


class EventLevel(StrEnum):
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


class Event(Message):
    """A line of the history: who did what, or what went wrong."""

    stamp_ns: StampNs
    level: EventLevel
    source: str = Field(description="Process, camera, robot or user it comes from.")
    kind: str = Field(description="Machine-readable, e.g. 'route_started', 'camera_lost', 'emergency_stop'.")
    text: str
