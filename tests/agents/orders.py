"""Builds commands for the tests of the robot's side."""

import itertools

from protocol.messages import Command, Movement, Reason, ReasonCode, Target

VALID_NS = 500_000_000


class Orders:
    """A guidance's voice: commands of one epoch, numbered."""

    def __init__(self, robot: str, epoch: int = 1) -> None:
        self.robot = robot
        self.epoch = epoch
        self._numbers = itertools.count(1)

    def move_to(
        self, now_ns: int, x: float, y: float, *, yaw: float | None = None, speed: float = 0.3, final: bool = True
    ) -> Command:
        return self._command(now_ns, Movement.MOVE_TO, Target(x=x, y=y, yaw=yaw), speed=speed, final=final)

    def rotate(self, now_ns: int, yaw: float) -> Command:
        return self._command(now_ns, Movement.ROTATE, Target(x=0.0, y=0.0, yaw=yaw))

    def waiting(self, now_ns: int) -> Command:
        return self._command(now_ns, Movement.WAITING)

    def drive(self, now_ns: int, linear: float, angular: float = 0.0) -> Command:
        return self._command(now_ns, Movement.DRIVE, linear=linear, angular=angular)

    def _command(
        self,
        now_ns: int,
        movement: Movement,
        target: Target | None = None,
        *,
        speed: float = 0.0,
        final: bool = False,
        linear: float = 0.0,
        angular: float = 0.0,
    ) -> Command:
        return Command(
            robot=self.robot,
            epoch=self.epoch,
            sequence=next(self._numbers),
            stamp_ns=now_ns,
            deadline_ns=now_ns + VALID_NS,
            movement=movement,
            reason=Reason(code=ReasonCode.ROUTE),
            target=target,
            speed_mps=speed,
            final=final,
            linear_mps=linear,
            angular_radps=angular,
        )
