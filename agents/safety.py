"""What allows the robot to move, and nothing else does (spec gpss, "Safety"): a fresh command, a fresh pose, no emergency stop.

Pure: times come in. `now_ns` is the wall clock, which commands' deadlines and poses' capture times are compared with;
`now_s` is the monotonic clock, which bounds every age also when the wall clock is set. Hand driving needs a pose too: a
robot that no camera sees is one that nobody can keep from people and walls, so it is pushed back into view, not driven.
"""

from dataclasses import dataclass
from enum import StrEnum

from agents.motion import STOP, Twist
from protocol.loss import LossWatch
from protocol.messages import Command, EmergencyStop, Movement, Reason, ReasonCode

COMMAND_LIMIT_S = 0.5
POSE_LIMIT_S = 0.5
ODOMETRY_LIMIT_S = 0.2
OBSTACLE_STOP_M = 0.20
"""Inclusive: infrared sensors of this kind report their least range, 0.20 m, for everything that is nearer."""
OBSTACLE_CLEAR_M = 0.25
"""Once stopped, the robot goes on when there is this much room: a range that trembles around the limit is no permission."""


class Verdict(StrEnum):
    """What becomes of a command that arrives."""

    OBEYED = "obeyed"
    FOREIGN = "foreign"
    OLD_EPOCH = "old_epoch"
    OLD = "old"
    EXPIRED = "expired"


class CommandGate:
    """Lets commands through in the order of (epoch, sequence) while their deadline has not passed; counts every verdict."""

    def __init__(self, robot: str, limit_s: float = COMMAND_LIMIT_S) -> None:
        self.counts: dict[Verdict, int] = dict.fromkeys(Verdict, 0)
        self._robot = robot
        self._limit_s = limit_s
        self._current: Command | None = None
        self._received_s = 0.0
        self._loss = LossWatch()

    def offer(self, command: Command, now_ns: int, now_s: float) -> Verdict:
        """OBEYED makes it the current command; any other verdict leaves everything as it was."""
        verdict = self._judge(command, now_ns)
        self.counts[verdict] += 1
        if verdict is Verdict.OBEYED:
            self._current, self._received_s = command, now_s
            self._loss.add(command.sequence, now_s)
        return verdict

    def loss(self, now_s: float) -> float | None:
        """The share of guidance's commands of the last seconds that did not arrive (in time); None of too few."""
        return self._loss.share(now_s)

    @property
    def current(self) -> Command | None:
        """The newest command that was let through, fresh or not."""
        return self._current

    def age_s(self, now_s: float) -> float | None:
        """Seconds since the current command arrived; None when there was none."""
        return None if self._current is None else max(0.0, now_s - self._received_s)

    def fresh(self, now_ns: int, now_s: float) -> Command | None:
        """The current command if it may still be obeyed."""
        age_s = self.age_s(now_s)
        if self._current is None or age_s is None:
            return None
        return self._current if age_s <= self._limit_s and now_ns <= self._current.deadline_ns else None

    def _judge(self, command: Command, now_ns: int) -> Verdict:
        if command.robot != self._robot:
            return Verdict.FOREIGN
        if self._current is not None and command.order <= self._current.order:
            return Verdict.OLD_EPOCH if command.epoch < self._current.epoch else Verdict.OLD
        return Verdict.EXPIRED if now_ns > command.deadline_ns else Verdict.OBEYED


class EmergencyStopLatch:
    """The fleet's latch as this robot knows it. It stays engaged, whatever happens to the connection, until a release that
    is newer than the engagement arrives; and nothing is known before the first event, which is no permission either."""

    def __init__(self) -> None:
        self._state: EmergencyStop | None = None

    def update(self, event: EmergencyStop) -> bool:
        """Whether the event was taken. An engagement always is; a release only with a greater epoch than the engagement's,
        so that one that was overtaken on the way releases nothing. An engagement whose sender's clock is slower than the last
        release's counts as one after it, with a greater epoch: else no server would see it, and no release reach it."""
        known = self._state
        if known is not None and not event.engaged:
            newer = event.epoch > known.epoch if known.engaged else event.epoch >= known.epoch
            if not newer:
                return False
        if known is not None and event.engaged:
            least = known.epoch if known.engaged else known.epoch + 1
            event = event.model_copy(update={"epoch": max(event.epoch, least)})
        self._state = event
        return True

    @property
    def engaged(self) -> bool:
        return self._state is not None and self._state.engaged

    @property
    def epoch(self) -> int:
        """The greatest epoch known; -1 before the first event."""
        return -1 if self._state is None else self._state.epoch

    def forbids(self) -> Reason | None:
        """Why the latch keeps the robot still; None when it is known to be released."""
        if self._state is None:
            return Reason(code=ReasonCode.NOT_CONNECTED, text="the state of the emergency stop is not known yet")
        if not self._state.engaged:
            return None
        said = " by ".join(part for part in (self._state.reason, self._state.by) if part)
        return Reason(code=ReasonCode.EMERGENCY_STOP, text=said[:200])


@dataclass(frozen=True, slots=True)
class Situation:
    """What the dead-man's switch looks at. `pose_age_s`: the greater of the time since capture and since arrival, None when
    there is no pose that may be trusted; `fault`: what is wrong with the base, None when nothing is; `battery_empty`: the share
    of its charge that is left when that is too little."""

    latch: Reason | None
    fault: str | None
    command: Command | None
    command_age_s: float | None
    pose_age_s: float | None
    battery_empty: float | None = None


def why_still(situation: Situation, pose_limit_s: float = POSE_LIMIT_S) -> Reason | None:
    """Why the robot must hold still on its own account, the gravest reason first; None when it may obey the command."""
    if situation.latch is not None:
        return situation.latch
    if situation.fault is not None:
        return Reason(code=ReasonCode.DRIVER_FAULT, text=situation.fault[:200])
    if situation.command is None:
        age_s = situation.command_age_s
        text = "no command yet" if age_s is None else f"no fresh command, the last one came {age_s:.1f} s ago"
        return Reason(code=ReasonCode.COMMAND_STALE, text=text)
    if situation.pose_age_s is None:
        return Reason(code=ReasonCode.POSE_STALE, text="not localized")
    if situation.pose_age_s > pose_limit_s:
        return Reason(code=ReasonCode.POSE_STALE, text=f"the last camera pose is {situation.pose_age_s:.1f} s old")
    if situation.battery_empty is not None and situation.command.movement in (Movement.MOVE_TO, Movement.ROTATE):
        # A hand may still drive it to where it is charged.
        text = f"{situation.battery_empty:.0%} of the battery is left"
        return Reason(code=ReasonCode.BATTERY_EMPTY, text=text)
    return None


class BatteryWatch:
    """Whether the battery is empty; once it was, it must have gained a little to count as charged."""

    _GAINED = 0.02

    def __init__(self, empty: float) -> None:
        self._empty = empty
        self._share: float | None = None
        self._was_empty = False

    def update(self, share: float | None) -> None:
        """The share of a full charge, 0 to 1; None while unknown."""
        self._share = share
        if share is not None:
            self._was_empty = share <= (self._empty + self._GAINED if self._was_empty else self._empty)

    @property
    def empty(self) -> float | None:
        """What is left when that is too little to drive, else None."""
        return self._share if self._was_empty else None


class Since:
    """Puts to a reason since when it holds: the same code again is the same stop, whatever its text says meanwhile."""

    def __init__(self) -> None:
        self._code: ReasonCode | None = None
        self._since_ns = 0

    def of(self, reason: Reason | None, now_ns: int) -> Reason | None:
        code = None if reason is None else reason.code
        if code != self._code:
            self._code, self._since_ns = code, now_ns
        return None if reason is None else reason.model_copy(update={"since_ns": self._since_ns})


class FrontGuard:
    """The forward range sensor: nothing within 0.20 m is driven towards. Turning on the spot and reversing stay allowed."""

    def __init__(self) -> None:
        self._blocked = False

    def limit(self, twist: Twist, front_range_m: float | None) -> tuple[Twist, Reason | None]:
        """The twist that may be driven, and why when it is another one."""
        limit_m = OBSTACLE_CLEAR_M if self._blocked else OBSTACLE_STOP_M
        self._blocked = front_range_m is not None and front_range_m <= limit_m
        if not self._blocked or front_range_m is None or twist.linear_mps <= 0.0:
            return twist, None
        return STOP, Reason(code=ReasonCode.OBSTACLE, text=f"{front_range_m:.2f} m ahead of the range sensor")
