"""Two driven wheels on one axle (TurtleBot 4): what they do is what the vehicle does, less the slip of each."""

from geometry import SE2
from lab.kinematics.kinematics import Chance, Measured, Motion, approached, rolled
from protocol.lab import Limits, SimulatedDrive, VehicleSpec

WHEEL_INSET = 0.9
"""Half the track width as a share of half the footprint's width."""


class TwistMotors:
    """Motors that follow a twist within the vehicle's accelerations."""

    def __init__(self, limits: Limits) -> None:
        self.linear_mps = 0.0
        self.angular_radps = 0.0
        self._limits = limits

    def follow(self, target: tuple[float, float], step_s: float) -> None:
        limits = self._limits
        self.linear_mps = approached(
            self.linear_mps, target[0], limits.acceleration_mps2 * step_s, limits.braking_mps2 * step_s
        )
        turn = limits.yaw_acceleration_radps2 * step_s
        self.angular_radps = approached(self.angular_radps, target[1], turn, turn)

    def stop(self) -> None:
        self.linear_mps = self.angular_radps = 0.0


class DifferentialDrive:
    """`half_track_m` is half the distance at which the wheels act; readings are the ways (m) of the left and right wheel."""

    def __init__(self, spec: VehicleSpec, drive: SimulatedDrive, half_track_m: float) -> None:
        self.half_track_m = half_track_m
        self._drive = drive
        self._motors = TwistMotors(spec.limits)

    def plan(
        self, pose: SE2, target: tuple[float, float], chance: Chance, step_s: float, turn_share: float = 1.0
    ) -> Motion:
        """`turn_share`: how much of the turn of the wheels becomes one of the vehicle."""
        self._motors.follow(target, step_s)
        half, drive = self.half_track_m, self._drive
        v, w = self._motors.linear_mps, self._motors.angular_radps
        left, right = (v - w * half) * step_s, (v + w * half) * step_s
        true_left = left * (1.0 - drive.slip * chance.slip[0])
        true_right = right * (1.0 - drive.slip * chance.slip[1])
        way, turn = (true_left + true_right) / 2.0, (true_right - true_left) / (2.0 * half) * turn_share
        return Motion(
            pose=rolled(pose, way, turn),
            way_m=way,
            turn_rad=turn,
            rolled_m=(abs(true_left) + abs(true_right)) / 2.0,
            encoders=(
                left * drive.left_scale * (1.0 + drive.noise * chance.noise[0]),
                right * drive.right_scale * (1.0 + drive.noise * chance.noise[1]),
            ),
        )

    def commit(self, motion: Motion, step_s: float) -> Measured:
        left, right = motion.encoders
        way, turn = (left + right) / 2.0, (right - left) / (2.0 * self.half_track_m)
        return Measured(way, turn, way / step_s, turn / step_s)

    def stall(self) -> None:
        self._motors.stop()


def half_track_of(spec: VehicleSpec) -> float:
    """Half the distance between the wheels (m): they stand a little inside the outline."""
    return WHEEL_INSET * max(abs(y) for _, y in spec.footprint)
