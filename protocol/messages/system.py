"""What the system says of itself: its processes and the log of events."""

from enum import StrEnum
from typing import Annotated, Literal

from pydantic import Field

from protocol.messages.base import Counted, Message, StampNs

Share = Annotated[float, Field(strict=True, ge=0, le=1, allow_inf_nan=False)]


class ProcessState(Message):
    """One process of the process table on one machine."""

    name: str
    state: Literal["starting", "running", "restarting", "stopped"]
    pid: int | None
    restarts: int
    since_ns: StampNs
    stamp_ns: StampNs
    last_error: str = Field(default="", description="How it ended the last time, e.g. 'killed by signal 9'.")


class IntakeState(Message):
    """What became of the datagrams that robots sent, counted since the intake started, and how well each robot is heard."""

    stamp_ns: StampNs
    received: Counted
    accepted: Counted
    undecodable: Counted = Field(
        description="Short, garbled, of another version, forged, or unsigned although a key is set."
    )
    wrong_kind: Counted
    unknown_robot: Counted
    wrong_sender: Counted = Field(description="The envelope's sender is not the robot that the status is of.")
    old: Counted
    future: Counted
    duplicate: Counted
    out_of_order: Counted
    last_problem: str | None
    losses: dict[str, Share] = Field(
        description="By robot: the share of its statuses of the last seconds that got lost."
    )


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
