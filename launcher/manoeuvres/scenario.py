"""What a traffic scene consists of: zones, and vehicles with their ways and starts."""

from dataclasses import dataclass, field

from protocol.lab import ZoneSpec

WIFIBOT = ((-0.15, -0.16), (0.15, -0.16), (0.15, 0.16), (-0.15, 0.16))
"""Outline of the reports' vehicle (m, seen from its rotation centre)."""


@dataclass(frozen=True, slots=True)
class Entrant:
    """A vehicle of a scene: it is put at `start_m` of its way at `at_s`, driving at its full speed, and is through at `goal_m`,
    where it leaves the scene. Its time is measured between the two."""

    robot: str
    way: tuple[tuple[float, float], ...]
    start_m: float
    goal_m: float
    at_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Scenario:
    """`speed_mps`, accelerations in m/s^2. `priority`: robots in the order in which a scene's description lets them go first,
    if it does (empty: as they come)."""

    name: str
    zones: tuple[ZoneSpec, ...]
    entrants: tuple[Entrant, ...]
    speed_mps: float
    acceleration_mps2: float = 0.5
    deceleration_mps2: float = 3.0
    outline: tuple[tuple[float, float], ...] = field(default=WIFIBOT)
    priority: tuple[str, ...] = ()

    def alone(self, robot: str) -> "Scenario":
        """The same with that vehicle only: its free flow."""
        only = tuple(entrant for entrant in self.entrants if entrant.robot == robot)
        return Scenario(
            f"{self.name}-{robot}",
            self.zones,
            only,
            self.speed_mps,
            self.acceleration_mps2,
            self.deceleration_mps2,
            self.outline,
        )
