"""What the system says of its health, and what is missing since when (spec console: an empty console must say why)."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Literal

from pydantic import Field

from protocol.channels import INTAKE
from protocol.messages import IntakeState, ProcessState
from server.views.base import View, age_s


class Condition(StrEnum):
    """ok; warn: late, but not yet too old to use; stale: too old; missing: never heard; idle: speaks only when something
    happens."""

    OK = "ok"
    WARN = "warn"
    STALE = "stale"
    MISSING = "missing"
    IDLE = "idle"


class ChannelView(View):
    """One instance of a channel."""

    channel: str
    instance: str
    producer: str
    condition: Condition
    age_s: float | None = Field(description="Of its newest message; null when there never was one.")
    stale_after_s: float
    since_ns: int | None = Field(description="Stamp of the last message while the channel is stale.")


class ProblemView(View):
    """Something that an operator should know, in a sentence."""

    severity: Literal["warning", "error"]
    source: str = Field(description="The camera, robot or process that it is about.", examples=["cam2"])
    since_ns: int | None = Field(description="Since when, if that is known.")
    text: str = Field(examples=["no frames from cam2 since 12:03:10"])


class UdpView(View):
    """What became of the datagrams that robots sent, counted since the intake started."""

    listening: bool = Field(description="Whether the intake says so; the counts are what it said last.")
    received: int
    accepted: int
    undecodable: int = Field(
        description="Short, garbled, of another version, forged, or unsigned although a key is set."
    )
    wrong_kind: int
    unknown_robot: int
    wrong_sender: int = Field(description="The envelope's sender is not the robot that the status is of.")
    old: int
    future: int
    duplicate: int
    out_of_order: int
    last_problem: str | None

    @classmethod
    def of(cls, state: IntakeState | None, now_ns: int) -> "UdpView":
        """What the intake said last, nothing of anything when it never said any."""
        if state is None:
            return cls(listening=False, last_problem=None, **dict.fromkeys(_COUNTS, 0))
        counts = {name: getattr(state, name) for name in _COUNTS}
        return cls(listening=is_fresh(state, now_ns), last_problem=state.last_problem, **counts)


_COUNTS = tuple(name for name in UdpView.model_fields if name not in ("listening", "last_problem"))


def is_fresh(state: IntakeState, now_ns: int) -> bool:
    """Whether the intake still says something."""
    return age_s(state.stamp_ns, now_ns) <= INTAKE.stale_after_s


def losses(state: IntakeState | None, now_ns: int) -> Mapping[str, float]:
    """By robot: the share of its statuses of the last seconds that did not arrive; empty when that is not known."""
    return state.losses if state is not None and is_fresh(state, now_ns) else {}


class RedisView(View):
    """Whether Redis answers."""

    reachable: bool
    since_ns: int | None = Field(description="Since when it does not.")


class HealthSummary(View):
    """What everybody may know of the health: how bad it is, not what."""

    state: Literal["ok", "warning", "error"]
    stamp_ns: int
    redis_reachable: bool
    errors: int
    warnings: int


class HealthView(View):
    """The health of the whole: `error` when something is missing that robots need, `warning` when less."""

    state: Literal["ok", "warning", "error"]
    stamp_ns: int
    started_ns: int = Field(description="When this server started.")
    redis: RedisView
    channels: tuple[ChannelView, ...]
    processes: tuple[ProcessState, ...]
    udp: UdpView
    problems: tuple[ProblemView, ...]

    def summary(self) -> HealthSummary:
        """The part of it for those who have not logged in."""
        severities = [problem.severity for problem in self.problems]
        return HealthSummary(
            state=self.state,
            stamp_ns=self.stamp_ns,
            redis_reachable=self.redis.reachable,
            errors=severities.count("error"),
            warnings=severities.count("warning"),
        )
