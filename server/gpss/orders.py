"""What a GPSS robot is told: guidance's commands as the report's documents, and `Waiting` whenever nothing may move it.

Pure: times come in. What the protocol has no word for is said with those it has: a hand on the console's stick (`Drive`) is
`Waiting`, since such a robot has a stick of its own.
"""

from collections import OrderedDict
from dataclasses import dataclass

from protocol.datagram import Sequencer
from protocol.gpss import GpssCommand
from protocol.messages import Command, EmergencyStop, Movement

LIFETIME_MS = 500
"""How long a command may be obeyed at most, whatever its own deadline says: the dead-man's switch of such a robot."""
REPEAT_S = 0.2
"""How often `Waiting` is said anew while guidance is silent or the emergency stop engaged."""
_REMEMBERED = 6000
"""Commands that an answer may name: ten minutes of them."""
_TARGETED = (Movement.MOVE_TO, Movement.ROTATE)


@dataclass(frozen=True, slots=True)
class Sent:
    """A command as it was sent (`movement` may be another one than guidance's)."""

    movement: Movement
    command: Command


class RobotOrders:
    """The orders of one robot. Only the newest command counts, by (epoch, sequence), and none after its deadline."""

    def __init__(self, robot: str, now_ns: int) -> None:
        self.robot = robot
        self._sequencer = Sequencer(now_ns)
        self._command: Command | None = None
        self._stamp_ms = 0
        self._said_s: float | None = None
        self._due = False
        self._sent: OrderedDict[int, Sent] = OrderedDict()

    def offer(self, command: Command, now_ns: int) -> bool:
        """Whether the command was taken: an older one than the newest, or one that came too late, changes nothing."""
        if command.robot != self.robot or now_ns > command.deadline_ns:
            return False
        if self._command is not None and command.order <= self._command.order:
            return False
        self._command, self._due = command, True
        return True

    def hurry(self) -> None:
        """Something outside the commands has changed: say what holds now."""
        self._due = True

    def next(self, latch: EmergencyStop | None, now_ns: int, now_s: float) -> GpssCommand | None:
        """The document to write now, None when there is nothing new to say. Nothing is said before the state of the latch is
        known, and nothing before guidance has ever spoken, unless it is to stop."""
        if latch is None:
            return None
        silent = self._command is None or now_ns > self._command.deadline_ns
        held = latch.engaged or silent
        if silent and self._command is None and not latch.engaged:
            return None
        repeat = held and (self._said_s is None or now_s - self._said_s >= REPEAT_S)
        if not (self._due or repeat):
            return None
        self._due, self._said_s = False, now_s
        return self._waiting(now_ns) if held or self._command is None else self._translated(self._command, now_ns)

    def answered(self, timestamp_ms: int) -> Sent | None:
        """The command that was sent with this time stamp, None when that was never or long ago."""
        return self._sent.get(timestamp_ms)

    def _translated(self, command: Command, now_ns: int) -> GpssCommand:
        if command.movement is Movement.DRIVE:
            return self._waiting(now_ns)
        stamp_ms = self._stamp(now_ns)
        target = command.target if command.movement in _TARGETED else None
        self._remember(stamp_ms, Sent(command.movement, command))
        return GpssCommand(
            command=command.movement,
            x=None if target is None else target.x,
            y=None if target is None else target.y,
            final_angle=None if target is None else target.yaw,
            speed=command.speed_mps if command.movement is Movement.MOVE_TO else 0.0,
            timestamp=stamp_ms,
            sequence=self._sequencer.next(),
            deadline=min(stamp_ms + LIFETIME_MS, command.deadline_ns // 1_000_000),
        )

    def _waiting(self, now_ns: int) -> GpssCommand:
        stamp_ms = self._stamp(now_ns)
        if self._command is not None:
            self._remember(stamp_ms, Sent(Movement.WAITING, self._command))
        return GpssCommand(
            command=Movement.WAITING,
            timestamp=stamp_ms,
            sequence=self._sequencer.next(),
            deadline=stamp_ms + LIFETIME_MS,
        )

    def _stamp(self, now_ns: int) -> int:
        """Unlike any before, since answers name commands by it."""
        self._stamp_ms = max(now_ns // 1_000_000, self._stamp_ms + 1)
        return self._stamp_ms

    def _remember(self, stamp_ms: int, sent: Sent) -> None:
        self._sent[stamp_ms] = sent
        if len(self._sent) > _REMEMBERED:
            self._sent.popitem(last=False)
