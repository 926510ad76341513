"""What a GPSS robot says: its documents checked and turned into our statuses and responses; what is not right is counted and
told as datagrams are (`server.intake.statuses`)."""

from typing import TypeVar

from protocol.clock import Clock
from protocol.codec import decode
from protocol.datagram import Datagram
from protocol.errors import DecodeError
from protocol.gpss import LARGEST_DOCUMENT, GpssResponse, GpssStatus, Name, key
from protocol.messages import Movement, Outcome, Response, Status, Target
from server.gpss.orders import RobotOrders, Sent
from server.intake.statuses import StatusIntake

M = TypeVar("M", GpssStatus, GpssResponse)

_NS_PER_MS = 1_000_000
_AHEAD_MS = 500
"""How far a robot's clock may be ahead."""


class RobotReports:
    """One robot's documents. Each is taken once, however often and by whichever way it comes."""

    def __init__(self, robot: str, orders: RobotOrders, intake: StatusIntake, clock: Clock) -> None:
        self._robot, self._orders, self._intake, self._clock = robot, orders, intake, clock
        self._last: dict[Name, bytes] = {}
        self._answered = (0, 0)
        self._told: object = None

    def status(self, data: bytes) -> None:
        """A status document as it was found or published."""
        if not self._is_new("status", data):
            return
        try:
            said = _checked(GpssStatus, data)
        except DecodeError as error:
            self._intake.refuse("undecodable", f"{key(self._robot, 'status')}: {error}")
            return
        status = Status(
            robot=self._robot,
            sequence=said.timestamp,
            stamp_ns=said.timestamp * _NS_PER_MS,
            x=said.x,
            y=said.y,
            yaw=said.angle,
            linear_mps=said.linear_velocity,
            angular_radps=said.angular_velocity,
            ip=said.ip,
            area=said.area,
            battery=said.battery,
            mode=said.operating_mode,
            faults=said.faults,
        )
        self._intake.offer(Datagram(self._robot, said.timestamp, status.stamp_ns, status), key(self._robot, "status"))

    def response(self, data: bytes) -> Response | None:
        """The response in a document as it was found or published; None when there is nothing new in it."""
        if not self._is_new("response", data):
            return None
        where = key(self._robot, "response")
        try:
            said = _checked(GpssResponse, data)
        except DecodeError as error:
            self._intake.refuse("undecodable", f"{where}: {error}")
            return None
        sent = self._orders.answered(said.command_timestamp)
        if sent is None:
            self._intake.refuse("unknown_command", f"{where} answers {said.command_timestamp}, which was never sent")
            return None
        if sent.movement is not said.command:
            self._intake.refuse(
                "unknown_command",
                f"{where} answers {said.command} of {said.command_timestamp}, that was {sent.movement}",
            )
            return None
        now_ns = self._clock.now_ns()
        reached_ms = said.reached_ms
        if reached_ms is not None and not said.command_timestamp <= reached_ms <= now_ns // _NS_PER_MS + _AHEAD_MS:
            self._intake.refuse(
                "wrong_time", f"{where}: reached at {reached_ms}, commanded at {said.command_timestamp}"
            )
            return None
        answer = said.command_timestamp, reached_ms or 0
        if answer <= self._answered:
            return None  # an older answer that came late
        self._intake.counts["responses"] += 1
        self._answered = answer
        outcome = Outcome.ACCEPTED if reached_ms is None else Outcome.REACHED
        told = (outcome, sent.movement, _fixed_target(sent))
        if told == self._told:
            return None  # the same answer to a rewriting of the same command
        self._told = told
        moves = sent.movement is Movement.MOVE_TO
        return Response(
            robot=self._robot,
            command_order=sent.command.order,
            command_stamp_ns=sent.command.stamp_ns,
            stamp_ns=now_ns,
            outcome=outcome,
            movement=sent.movement,
            applied_speed_mps=sent.command.speed_mps if moves and reached_ms is None else 0.0,
            reached_ns=None if reached_ms is None else reached_ms * _NS_PER_MS,
        )

    def _is_new(self, name: Name, data: bytes) -> bool:
        if self._last.get(name) == data:
            return False
        self._last[name] = data
        self._intake.counts["received"] += 1
        return True


def _fixed_target(sent: Sent) -> Target | None:
    """Where the robot is to arrive; a carrot's place is not part of a task, it moves with every command."""
    fixed = sent.movement is Movement.ROTATE or (sent.movement is Movement.MOVE_TO and sent.command.final)
    return sent.command.target if fixed else None


def _checked(kind: type[M], data: bytes) -> M:
    if len(data) > LARGEST_DOCUMENT:
        raise DecodeError(f"longer than {LARGEST_DOCUMENT} bytes")
    return decode(kind, data)
