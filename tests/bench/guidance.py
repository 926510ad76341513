"""How long a cycle of guidance takes, for ten, a hundred, a thousand robots that all drive: the pure core, and its messages."""

import argparse
import math
import random
import statistics
import time
from dataclasses import dataclass

import numpy as np
from msgspec import structs

from launcher.errors import UsageError
from launcher.output import Result, progress
from launcher.paths import DEFAULT_LAB
from mapping.grid import FloorGrid
from protocol.channels import LAB_INSTANCE
from protocol.lab import Area, Lab, VehicleSpec, load_lab
from protocol.messages import (
    Assignment,
    AssignmentState,
    FloorRaster,
    Leg,
    Movement,
    Route,
    Status,
    TrackedPose,
    Waypoint,
)
from server.guidance.fleet import Guidance
from server.guidance.snapshot import Snapshot

START_NS = 1_700_000_000_000_000_000
ROBOTS = (10, 100, 1000)
PLOT_M = (4.0, 3.0)
"""Each robot drives around in a part of the hall of its own, beside those of the others."""
SIDE_M = (2.8, 1.8)
SPEED_MPS = 0.3
PERIOD_S = 0.1
PALLETS_SHARE = 0.05
"""Of the robots, one has something on its way."""
_WARM_UP = 5


@dataclass(frozen=True, slots=True)
class Hall:
    """A floor with robots on loops of their own, and pallets on some of those."""

    lab: Lab
    corners: dict[str, tuple[float, float]]
    raster: FloorRaster

    @classmethod
    def of(cls, robots: int, seed: int) -> "Hall":
        chance = random.Random(seed)  # figures, not secrets
        columns = math.ceil(math.sqrt(robots * PLOT_M[1] / PLOT_M[0]))
        rows = math.ceil(robots / columns)
        width, depth = columns * PLOT_M[0], rows * PLOT_M[1]
        model = load_lab(DEFAULT_LAB)
        wifibot = model.vehicle("wifibot-14")
        vehicles = tuple(_vehicle(wifibot, number) for number in range(robots))
        area = Area(id="hall", outline=((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)))
        lab = model.model_copy(update={"areas": (area,), "vehicles": vehicles, "zones": ()})
        corners = {
            vehicle.id: ((number % columns) * PLOT_M[0] + 0.6, (number // columns) * PLOT_M[1] + 0.6)
            for number, vehicle in enumerate(vehicles)
        }
        grid = FloorGrid.covering((0.0, 0.0, width, depth))
        occupied = np.zeros_like(grid.occupied)
        for name in chance.sample(sorted(corners), round(PALLETS_SHARE * robots)):
            x, y = corners[name]
            column, row = round((x + SIDE_M[0] / 2) / grid.cell_m), round((y + SIDE_M[1]) / grid.cell_m)
            occupied[row - 4 : row + 4, column - 4 : column + 4] = True
        raster = grid.with_cells(occupied, np.ones_like(occupied)).to_raster(LAB_INSTANCE, START_NS)
        return cls(lab, corners, raster)

    def waypoints(self) -> dict[str, Waypoint]:
        found: dict[str, Waypoint] = {}
        for name, (x, y) in self.corners.items():
            for number, (dx, dy) in enumerate(((1, 0), (1, 1), (0, 1), (0, 0))):
                place = f"{name}-{number}"
                found[place] = Waypoint(id=place, area="hall", x=x + dx * SIDE_M[0], y=y + dy * SIDE_M[1])
        return found

    def routes(self) -> dict[str, Route]:
        return {
            name: Route(id=name, legs=tuple(Leg(waypoint=f"{name}-{number}") for number in range(4)), loop=True)
            for name in self.corners
        }

    def pose(self, name: str, way_m: float, stamp_ns: int) -> TrackedPose:
        """On the loop, so many metres from its beginning."""
        x, y = self.corners[name]
        length, depth = SIDE_M
        left = way_m % (2 * (length + depth))
        for side, (dx, dy, yaw) in zip(
            (length, depth, length, depth), ((1, 0, 0.0), (0, 1, math.pi / 2), (-1, 0, math.pi), (0, -1, -math.pi / 2)),
            strict=True,
        ):  # fmt: skip
            if left <= side:
                x, y = x + dx * left, y + dy * left
                covariance = (1e-5, 0.0, 0.0, 1e-5, 0.0, 1e-4)
                vx, vy = SPEED_MPS * dx, SPEED_MPS * dy
                return TrackedPose(name, stamp_ns, x, y, yaw, vx, vy, 0.0, covariance, ("cam0",), "hall")
            x, y, left = x + dx * side, y + dy * side, left - side
        raise AssertionError("a loop has four sides")


@dataclass(frozen=True, slots=True)
class Cycles:
    """Milliseconds of each cycle, the encoding of what it says included; the share of robots that were told to drive."""

    cycle_ms: list[float]
    driving_share: float


def measure(robots: int, cycles: int, seed: int) -> Cycles:
    """Guides a hall of robots that obey perfectly, for so many cycles. A robot stands where it was told to wait."""
    hall = Hall.of(robots, seed)
    guidance = Guidance(hall.lab)
    waypoints, routes = hall.waypoints(), hall.routes()
    chance = random.Random(seed)
    ways = {name: chance.uniform(0.0, 2 * sum(SIDE_M)) for name in hall.corners}
    assignments = {name: _assigned(name, way) for name, way in ways.items()}
    cycle_ms, driving = list[float](), 0
    for cycle in range(_WARM_UP + cycles):
        now_ns = START_NS + round(cycle * PERIOD_S * 1e9)
        snapshot = Snapshot(
            now_ns=now_ns,
            now_s=cycle * PERIOD_S,
            poses={name: hall.pose(name, way, now_ns) for name, way in ways.items()},
            statuses={name: _status(name, now_ns) for name in ways},
            obstacles=structs.replace(hall.raster, stamp_ns=now_ns),
            waypoints=waypoints,
            routes=routes,
            assignments=assignments,
        )
        began = time.perf_counter()
        outcome = guidance.cycle(snapshot, epoch=1)
        cycled = time.perf_counter()
        if cycle >= _WARM_UP:
            cycle_ms.append(1e3 * (cycled - began))
        for change in outcome.changes:
            assignments[change.after.robot] = change.after
        for name, command in outcome.commands.items():
            if command.movement is Movement.MOVE_TO:
                ways[name] += SPEED_MPS * PERIOD_S
                driving += cycle >= _WARM_UP
    return Cycles(cycle_ms, driving / (robots * cycles))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--cycles", type=int, default=100, metavar="N", help="cycles measured (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of where robots and pallets are")


def run(arguments: argparse.Namespace) -> Result:
    if arguments.cycles < 1:
        raise UsageError("--cycles must be at least 1")
    figures: dict[str, float] = {}
    for robots in ROBOTS:
        progress(f"{robots} robots")
        found = measure(robots, arguments.cycles, arguments.seed)
        figures[f"robots_{robots}_cycle_median_ms"] = round(statistics.median(found.cycle_ms), 2)
        figures[f"robots_{robots}_cycle_p95_ms"] = round(_p95(found.cycle_ms), 2)
        figures[f"robots_{robots}_driving_share"] = round(found.driving_share, 3)
    settings = {"cycles": arguments.cycles, "seed": arguments.seed, "pallets_share": PALLETS_SHARE}
    return Result("guidance", figures, {}, settings)


def _p95(values: list[float]) -> float:
    return sorted(values)[min(len(values) - 1, math.ceil(0.95 * len(values)) - 1)]


def _vehicle(model: VehicleSpec, number: int) -> VehicleSpec:
    return model.model_copy(update={"id": f"r{number:04d}", "tag": model.tag.model_copy(update={"id": number})})


def _assigned(name: str, way_m: float) -> Assignment:
    """On the leg on which the robot begins."""
    length, depth = SIDE_M
    marks = (length, length + depth, 2 * length + depth)
    leg = sum(way_m >= mark for mark in marks)
    return Assignment(
        id=name,
        robot=name,
        route=name,
        state=AssignmentState.RUNNING,
        leg=leg,
        laps=1,
        started_ns=START_NS,
        changed_ns=START_NS,
    )


def _status(name: str, now_ns: int) -> Status:
    return Status(robot=name, sequence=1, stamp_ns=now_ns, linear_mps=SPEED_MPS, angular_radps=0.0)
