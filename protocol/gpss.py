"""GPSS as a robot of its own speaks it over Redis (spec gpss, "The protocol"): the keys, and the JSON documents in them.

Each robot has four keys, strings with one JSON document each; whoever writes a document also publishes it on the topic of
the key's name, so that its reader may poll or subscribe. We write `gpss:ROBOT:command` (10 times a second) and
`gpss:ROBOT:pose` (as often as the cameras see it), the robot writes `gpss:ROBOT:status` (continuously) and
`gpss:ROBOT:response`. The report says what the documents hold, not how their fields are called; they are the models below.

Metres in the map frame, radians counter-clockwise from x, m/s and rad/s, times as whole milliseconds since the epoch.
"""

from typing import Annotated, Literal

from pydantic import Field

from protocol.messages.base import Finite, Message, NonNegative
from protocol.messages.fleet import Mode, Movement

LARGEST_DOCUMENT = 4096
"""Bytes of a robot's document; longer ones are refused unread."""

TimestampMs = Annotated[int, Field(ge=0, lt=9_000_000_000_000)]
"""Milliseconds since the epoch; as nanoseconds they fit 63 bits."""

Name = Literal["command", "pose", "status", "response"]
READ: tuple[Name, ...] = ("command", "pose")
"""What a robot reads."""
WRITTEN: tuple[Name, ...] = ("status", "response")
"""What a robot writes."""


def key(robot: str, name: Name) -> str:
    """The key of that document of a robot, and the topic that it is published on."""
    return f"gpss:{robot}:{name}"


def user_name(robot: str) -> str:
    """The Redis user of a robot."""
    return f"gpss-{robot}"


class GpssCommand(Message):
    """What the robot is to do now. `x`, `y` and `final_angle` are null where the movement has none. To be obeyed until
    `deadline`; the key itself vanishes then. A greater `sequence` is newer, always."""

    command: Literal[Movement.MOVE_TO, Movement.WAITING, Movement.NO_ACTION, Movement.ROTATE]
    x: Finite | None = None
    y: Finite | None = None
    final_angle: Finite | None = None
    speed: NonNegative = 0.0
    timestamp: TimestampMs
    sequence: Annotated[int, Field(ge=0)]
    deadline: TimestampMs


class GpssPose(Message):
    """Where the cameras saw the robot's rotation centre at `timestamp`."""

    x: Finite
    y: Finite
    angle: Finite
    timestamp: TimestampMs


class GpssStatus(Message):
    """Where the robot believes to be (null: it does not know) and what it really does. `timestamp` grows from one to the
    next; `battery` is the share of a full charge."""

    x: Finite | None
    y: Finite | None
    angle: Finite | None
    linear_velocity: Finite
    angular_velocity: Finite
    ip: Annotated[str, Field(max_length=64)] = ""
    area: Annotated[str, Field(max_length=64)] | None = None
    timestamp: TimestampMs
    battery: Annotated[float, Field(ge=0, le=1)] | None = None
    mode: Literal["automatic", "manual"] = "automatic"
    faults: Annotated[tuple[Annotated[str, Field(max_length=200)], ...], Field(max_length=16)] = ()

    @property
    def operating_mode(self) -> Mode:
        return Mode.MANUAL if self.mode == "manual" else Mode.AUTOMATIC


class GpssResponse(Message):
    """What became of the command with `command_timestamp`: `reached_timestamp` is empty ("" or null) until the target is
    reached."""

    command: Literal[Movement.MOVE_TO, Movement.WAITING, Movement.NO_ACTION, Movement.ROTATE]
    command_timestamp: TimestampMs
    reached_timestamp: TimestampMs | Literal[""] | None = None
    x: Finite | None = None
    y: Finite | None = None
    angle: Finite | None = None

    @property
    def reached_ms(self) -> int | None:
        return self.reached_timestamp if isinstance(self.reached_timestamp, int) else None
