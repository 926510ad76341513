"""What guidance may be told about itself; every default has its reason here (spec gpss, "The operator's side")."""

from dataclasses import dataclass

CONTROLLER_REACHED_M = 0.15
"""The robot's controller counts a target as reached within this distance (spec gpss, the report's table)."""
CONTROLLER_LOCK_M = 0.35
"""Within this distance of its target the robot's controller no longer steers."""


@dataclass(frozen=True, slots=True)
class GuidanceParameters:
    """Lengths in metres, times in seconds.

    - `look_ahead_m`: how far ahead of the robot the temporary waypoint runs: more than the controller's lock radius.
    - `pass_beyond_m`: how far past a waypoint the temporary waypoint may run until the robot has been within its radius,
      so that the controller neither stops nor stops steering before it.
    - `pose_margin_m`: what is taken off a waypoint's radius for the error of the pose.
    - `yaw_tolerance_rad`: how well a waypoint's heading is to be met.
    - `settle_s`: how long a robot may take to come to rest where it arrived; and, at rest elsewhere, to be sent there again.
    - `corner_mps2`: how gently a robot is slowed down before a corner.
    - `clearance_m`: what must remain between the robot's front and an obstacle after it has stopped.
    - `reaction_s`: from an obstacle's appearance to the beginning of braking: camera 0.07, raster 0.15, guidance 0.1,
      network 0.05, motors 0.03, and a reserve.
    - `clear_for_s`: how long a box must have been clear before the robot drives on.
    - `unseen_share`: the share of a box that no camera sees at which the robot waits. Well below what a lost camera hides,
      above the part of the floor that the robot itself hides from a camera aside (its roof's parallax).
    - `manual_lost_hold_s`: how long a robot on a route waits after the hand on its stick was lost instead of letting go.
    - `forget_robot_s`: a robot not seen for longer stands for nothing any more (the cameras then show it as an obstacle).
    - `detour_look_ahead_m`: how far ahead the temporary waypoint runs on a detour: the nearer, the less of a bend is cut; more
      than the controller's lock radius all the same.
    - `detour_mps`: the speed on a detour, at most.
    - `retry_s`: how long after a vain search for a way around the next one begins.
    - `searches_per_cycle`: how many ways around are searched for in one cycle at most; the others have their turn in the next.
    - `zone_mps2`: how gently a robot is slowed down before a zone with a speed limit, and `zone_lead_s`: how much earlier, for
      what command, motors and the pose are late.
    """

    rate_hz: float = 10.0
    command_lifetime_s: float = 0.5
    look_ahead_m: float = 0.8
    pass_beyond_m: float = 0.35
    pose_margin_m: float = 0.03
    yaw_tolerance_rad: float = 0.05
    settle_s: float = 2.5
    corner_mps2: float = 0.3
    clearance_m: float = 0.3
    reaction_s: float = 0.5
    clear_for_s: float = 0.3
    unseen_share: float = 0.6
    own_margin_m: float = 0.06
    forget_robot_s: float = 10.0
    no_progress_s: float = 20.0
    deadlock_s: float = 2.0
    manual_lost_hold_s: float = 3.0
    detour_look_ahead_m: float = 0.45
    detour_mps: float = 0.4
    retry_s: float = 3.0
    searches_per_cycle: int = 1
    zone_mps2: float = 0.3
    zone_lead_s: float = 0.3

    def __post_init__(self) -> None:
        if not self.look_ahead_m > CONTROLLER_LOCK_M:
            raise ValueError(
                f"a look-ahead of {self.look_ahead_m} m does not steer: robots lock their heading within "
                f"{CONTROLLER_LOCK_M} m of a target"
            )
        if not 0 < self.rate_hz <= 50:
            raise ValueError(f"guidance runs at 0 to 50 Hz, not {self.rate_hz}")

    def reached_within_m(self, radius_m: float) -> float:
        """How near the measured pose must come for a robot to have truly been within `radius_m` of a waypoint."""
        return radius_m - min(self.pose_margin_m, radius_m / 5)
