"""What the robot answers to commands (spec gpss, "Response"): once when something else is obeyed, reached or refused, not to
every rewriting of the same command."""

from agents.control import task_of
from agents.safety import Verdict
from protocol.lab import VehicleSpec
from protocol.messages import Command, Movement, Outcome, Reason, Response

_MOVES = (Movement.MOVE_TO, Movement.ROTATE, Movement.DRIVE)


class Answers:
    """Collects responses until they are taken."""

    def __init__(self, vehicle: VehicleSpec) -> None:
        self._vehicle = vehicle
        self._last: object = None
        self._expired_told = False
        self._refused_epoch = -1
        self._responses: list[Response] = []

    def arrived(self, command: Command, verdict: Verdict, now_ns: int) -> None:
        """What an older guidance says is refused once per epoch, what comes too late once in a row."""
        if verdict is Verdict.OLD_EPOCH and command.epoch > self._refused_epoch:
            self._refused_epoch = command.epoch
            self._respond(command, Outcome.REFUSED, now_ns, "a newer guidance is in charge")
        elif verdict is Verdict.EXPIRED and not self._expired_told:
            self._expired_told = True
            late_s = (now_ns - command.deadline_ns) / 1e9
            self._respond(command, Outcome.REFUSED, now_ns, f"came {late_s:.2f} s after its deadline")
        elif verdict is Verdict.OBEYED:
            self._expired_told = False

    def decided(self, command: Command | None, stop: Reason | None, reached: bool, now_ns: int) -> None:
        """`command` is the fresh one, if any; `stop` is why the robot holds still on its own account."""
        if command is None:
            self._last = None
            return
        if stop is None:
            outcome, text = (Outcome.REACHED if reached else Outcome.ACCEPTED), ""
        elif command.movement in _MOVES:
            outcome, text = Outcome.REFUSED, f"{stop.code}: {stop.text}"
        else:
            return  # it is to stand, and stands
        speed = round(command.speed_mps, 1) if command.movement is Movement.MOVE_TO else 0.0
        answer = (task_of(command), speed, outcome, None if stop is None else stop.code)
        if answer != self._last:
            self._last = answer
            self._respond(command, outcome, now_ns, text)

    def take(self) -> tuple[Response, ...]:
        """What is to be sent, oldest first."""
        taken, self._responses = tuple(self._responses), []
        return taken

    def _respond(self, command: Command, outcome: Outcome, now_ns: int, text: str) -> None:
        self._responses.append(
            Response(
                robot=self._vehicle.id,
                command_order=command.order,
                command_stamp_ns=command.stamp_ns,
                stamp_ns=now_ns,
                outcome=outcome,
                movement=command.movement,
                applied_speed_mps=0.0 if outcome is Outcome.REFUSED else self._applied_speed(command),
                reached_ns=now_ns if outcome is Outcome.REACHED else None,
                reason=text,
            )
        )

    def _applied_speed(self, command: Command) -> float:
        """The speed set-point after clipping to what the vehicle can do, m/s."""
        asked = abs(command.linear_mps) if command.movement is Movement.DRIVE else command.speed_mps
        moves = command.movement in (Movement.MOVE_TO, Movement.DRIVE)
        return min(asked, self._vehicle.limits.speed_mps) if moves else 0.0
