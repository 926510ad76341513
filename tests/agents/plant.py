"""A small kinematic vehicle for the tests of the robot's side: limited accelerations, wheels that lie a little."""

import math
from dataclasses import dataclass, field

from agents.drivers import OdometryReading
from agents.motion import STOP, Twist, clip
from geometry import SE2
from protocol.lab import Limits
from protocol.messages import TrackedPose

LIMITS = Limits(speed_mps=0.8, yaw_rate_radps=1.0, acceleration_mps2=0.5, braking_mps2=2.0, yaw_acceleration_radps2=4.0)


@dataclass
class Plant:
    """The truth (`pose`, T_map_robot) and what the wheels make of it (`odometry`, T_odom_robot)."""

    pose: SE2
    limits: Limits = LIMITS
    distance_scale: float = 1.0
    turn_scale: float = 1.0
    odometry: SE2 = field(default_factory=SE2.identity)
    twist: Twist = STOP
    setpoint: Twist = STOP

    def step(self, dt_s: float) -> None:
        brakes = abs(self.setpoint.linear_mps) < abs(self.twist.linear_mps)
        slope = self.limits.braking_mps2 if brakes else self.limits.acceleration_mps2
        self.twist = Twist(
            _approach(self.twist.linear_mps, self.setpoint.linear_mps, slope * dt_s),
            _approach(
                self.twist.angular_radps, self.setpoint.angular_radps, self.limits.yaw_acceleration_radps2 * dt_s
            ),
        )
        v, w = self.twist.linear_mps * dt_s, self.twist.angular_radps * dt_s
        self.pose = self.pose @ SE2.exp(v, 0.0, w)
        self.odometry = self.odometry @ SE2.exp(v * self.distance_scale, 0.0, w * self.turn_scale)

    def restart_base(self) -> None:
        self.odometry, self.twist, self.setpoint = SE2.identity(), STOP, STOP

    def reading(self, stamp_ns: int, session: str = "a", front_range_m: float | None = None) -> OdometryReading:
        return OdometryReading(stamp_ns, session, self.odometry, self.twist, front_range_m)


def tracked(
    vehicle: str,
    pose: SE2,
    stamp_ns: int,
    covariance: tuple[float, float, float, float, float, float] = (1e-5, 0.0, 0.0, 1e-5, 0.0, 1e-5),
) -> TrackedPose:
    return TrackedPose(
        vehicle=vehicle,
        stamp_ns=stamp_ns,
        x=pose.x,
        y=pose.y,
        yaw=pose.yaw,
        vx=0.0,
        vy=0.0,
        yaw_rate=0.0,
        covariance=covariance,
        cameras=("cam0",),
        area="camp",
    )


def distance(pose: SE2, x: float, y: float) -> float:
    return math.hypot(pose.x - x, pose.y - y)


def _approach(value: float, target: float, step: float) -> float:
    return value + clip(target - value, -step, step)
