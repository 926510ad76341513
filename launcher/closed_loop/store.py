"""What Redis holds in the closed loop, as far as guidance reads and writes it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from protocol.messages import (
    Assignment,
    AssignmentState,
    EmergencyStop,
    FloorRaster,
    Leg,
    Route,
    Status,
    TrackedPose,
    Waypoint,
)
from server.guidance.snapshot import AssignmentChange, Snapshot


@dataclass(slots=True)
class SimulatedStore:
    """The newest of what lives, and what is durable. While `up` is false nobody reads or writes."""

    up: bool = True
    poses: dict[str, TrackedPose] = field(default_factory=dict[str, TrackedPose])
    statuses: dict[str, Status] = field(default_factory=dict[str, Status])
    obstacles: FloorRaster | None = None
    emergency_stop: EmergencyStop = field(default_factory=lambda: EmergencyStop(engaged=False))
    waypoints: dict[str, Waypoint] = field(default_factory=dict[str, Waypoint])
    routes: dict[str, Route] = field(default_factory=dict[str, Route])
    assignments: dict[str, Assignment] = field(default_factory=dict[str, Assignment])
    epoch: int = 0

    def assign(
        self, robot: str, points: Sequence[tuple[float, float]], speed_mps: float, now_ns: int, *, loop: bool = False
    ) -> None:
        """Gives the robot a route over the points (m, map frame)."""
        names = [f"{robot}-{index}" for index in range(len(points))]
        for name, (x, y) in zip(names, points, strict=True):
            self.waypoints[name] = Waypoint(id=name, area="any", x=x, y=y, radius_m=0.2)
        legs = tuple(Leg(waypoint=name, speed_mps=speed_mps) for name in names)
        self.routes[robot] = Route(id=robot, legs=legs, loop=loop)
        self.assignments[robot] = Assignment(
            id=f"{robot}-{now_ns}",
            robot=robot,
            route=robot,
            state=AssignmentState.RUNNING,
            started_ns=now_ns,
            changed_ns=now_ns,
        )

    def snapshot(self, now_ns: int, now_s: float) -> Snapshot:
        return Snapshot(
            now_ns=now_ns,
            now_s=now_s,
            poses=dict(self.poses),
            statuses=dict(self.statuses),
            emergency_stop=self.emergency_stop,
            obstacles=self.obstacles,
            waypoints=self.waypoints,
            routes=self.routes,
            assignments=dict(self.assignments),
        )

    def change(self, changes: Sequence[AssignmentChange]) -> None:
        """Replaces assignments that nobody else changed meanwhile."""
        for change in changes:
            if self.assignments.get(change.before.robot) == change.before:
                self.assignments[change.before.robot] = change.after
