"""The protective stop: what the scanner sees in the way of the robot stops it, whatever commands say (spec gpss, "What the report
wishes for": the robot's own scanner as a second safety layer).

Two fields, both of `agents.protection.field`: the protective one, which the robot sweeps until it stands if it brakes now, and
the warning one, wider, which it sweeps if it drives on for `warning_s` before. Anything in the warning field slows the robot,
which shortens the protective field; anything in the protective field stops it, and keeps it until the field of the speed that
is commanded has been clear for `clear_s`.
"""

import math

import numpy as np
from numpy.typing import NDArray

from agents.motion import STOP, Twist
from agents.pacing import CONTROL_RATE_HZ
from agents.protection.field import Outline, braking_sweep, in_the_way
from agents.protection.scan import EchoFilter, RangeScan
from protocol.lab import ROS2_DRIVER, Limits, ProtectiveFieldSpec, VehicleSpec
from protocol.messages import Reason, ReasonCode

Floats = NDArray[np.float64]
_HYSTERESIS_M = 0.05
"""A robot that was stopped needs so much more room to go on: a range that trembles at the border is no permission."""
_TAKEN_EVERY_S = 1.0 / CONTROL_RATE_HZ
"""A ROS 2 base's scans wait in DDS for the next round of the control loop, which is more of a reaction time."""
_NOTHING = np.empty((0, 2))


class ProtectiveGuard:
    """One robot's. Without scans it lets everything pass: that a scanner is silent is its driver's fault to tell."""

    def __init__(self, vehicle: VehicleSpec) -> None:
        self._spec: ProtectiveFieldSpec = vehicle.protective_field
        self._reaction_s = self._spec.reaction_s + (_TAKEN_EVERY_S if vehicle.driver == ROS2_DRIVER else 0.0)
        self._limits: Limits = vehicle.limits
        self._outline = Outline(vehicle.footprint)
        self._filter = EchoFilter(self._spec.neighbours)
        self._things: Floats = _NOTHING
        self._scanned_s = -math.inf
        self._going = STOP
        self._occupied_s: float | None = None
        self._text = ""

    def scan(self, scan: RangeScan, measured: Twist, now_s: float) -> bool:
        """Takes a turn of the scanner; whether the robot, which does `measured`, must stop at once."""
        self._things, self._scanned_s = self._filter.solid(scan), now_s
        return self._look((self._going, measured), 0.0, 0.0, now_s)

    def limit(self, wanted: Twist, measured: Twist, now_s: float) -> tuple[Twist, Reason | None]:
        """The twist that may be driven instead of `wanted`, and why when the robot must stand."""
        if wanted == STOP:
            self.halt()
            return STOP, None
        age_s = min(1.0, max(0.0, now_s - self._scanned_s))
        if self._occupied_s is not None:
            self._look((wanted, measured), age_s, _HYSTERESIS_M, now_s)
            if now_s - self._occupied_s < self._spec.clear_s:
                self._going = STOP
                return STOP, self._reason()
            self._occupied_s = None
        allowed = wanted
        if len(self._ahead(wanted, age_s + self._spec.warning_s, self._spec.warning_margin_m)):
            allowed = self._slowed(wanted)
        if self._look((allowed, measured), age_s, 0.0, now_s):
            self._going = STOP
            return STOP, self._reason()
        self._going = allowed
        return allowed, None

    def halt(self) -> None:
        """The robot stands, or is about to, for another reason."""
        self._going = STOP

    def _look(self, twists: tuple[Twist, ...], age_s: float, extra_m: float, now_s: float) -> bool:
        """Whether anything is in the protective field of one of these motions."""
        for twist in twists:
            found = self._ahead(twist, age_s, self._spec.margin_m + extra_m)
            if len(found):
                x, y = (float(value) for value in found[0])
                degrees = round(math.degrees(math.atan2(y, x)))
                side = (
                    "straight ahead" if degrees == 0 else f"{abs(degrees)} degrees {'left' if degrees > 0 else 'right'}"
                )
                self._occupied_s = now_s
                self._text = f"something {math.hypot(x, y):.2f} m from the robot's centre, {side}"
                return True
        return False

    def _ahead(self, twist: Twist, more_s: float, margin_m: float) -> Floats:
        """Things in the field of a motion that is held for so much longer than the reaction takes."""
        if not len(self._things) or twist == STOP:
            return _NOTHING
        sweep = braking_sweep(twist, self._limits, self._outline.radius_m, self._reaction_s + more_s)
        return in_the_way(self._things, self._outline, sweep, margin_m)

    def _slowed(self, twist: Twist) -> Twist:
        """The same curve, so slow that no point of the outline is faster than the warning field allows."""
        fastest = math.hypot(twist.linear_mps, twist.angular_radps * self._outline.radius_m)
        share = min(1.0, self._spec.slow_mps / fastest)
        return Twist(share * twist.linear_mps, share * twist.angular_radps)

    def _reason(self) -> Reason:
        return Reason(code=ReasonCode.PROTECTIVE_FIELD, text=self._text)
