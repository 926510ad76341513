"""The simulated floor at a fixed step: vehicles, people and pallets, contacts, and the truth about all of them.

Deterministic: the same lab, seed and inputs give the same truth. It knows no wall clock; whoever steps it decides whether it
runs slower or faster than real time, and its stamps count on from `start_ns`.
"""

import math
import zlib
from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from shapely.geometry import Polygon

from geometry import SE2
from lab.contacts import Body, ContactCounter, blocks, overlap_m2
from lab.objects import PlacedObject
from lab.ranging import RANGE_MAX_M, front_range_m
from lab.scanning import SimulatedScannerHead, outline_segments
from lab.snapshot import Snapshot, VehicleSnapshot
from lab.vehicle import SimulatedVehicle
from lab.walls import WALL, Walls
from protocol.lab import Lab
from protocol.messages import GroundTruth, Odometry, Scan, SimulatedObject, TruePose

START_NS = 1_700_000_000_000_000_000


class World:
    """The floor of a lab. Its vehicles are those whose driver is `sim`; `seed` None takes the lab description's."""

    def __init__(
        self, lab: Lab, seed: int | None = None, *, start_ns: int = START_NS, session: str = "simulated"
    ) -> None:
        self.lab = lab
        self.seed = lab.simulation.seed if seed is None else seed
        self.session = session
        self.step_s = lab.simulation.step_s
        self._step_ns = round(self.step_s * 1e9)
        self._stamp_ns = start_ns
        self._elapsed_s = 0.0
        self._contacts = ContactCounter()
        self._objects: dict[str, PlacedObject] = {}
        self._vehicles: dict[str, SimulatedVehicle] = {}
        self._scanners: dict[str, SimulatedScannerHead] = {}
        self._walls = Walls(lab.simulation.walls)
        for spec in lab.vehicles:
            if spec.driver == "sim":
                rng = np.random.default_rng([self.seed, zlib.crc32(spec.id.encode())])
                start = lab.simulation.starts.get(spec.id)
                pose = SE2(*start) if start else _free_spot(lab, list(self._vehicles.values()))
                self._vehicles[spec.id] = SimulatedVehicle(spec, lab.simulation.drive, pose, rng)
                if spec.scanner is not None:
                    rng = np.random.default_rng([self.seed, zlib.crc32(f"scanner of {spec.id}".encode())])
                    self._scanners[spec.id] = SimulatedScannerHead(spec.scanner, lab.simulation.scanner, rng)

    @property
    def stamp_ns(self) -> int:
        """The world's time."""
        return self._stamp_ns

    @property
    def vehicle_ids(self) -> tuple[str, ...]:
        return tuple(self._vehicles)

    @property
    def object_ids(self) -> tuple[str, ...]:
        return tuple(self._objects)

    def step(self) -> None:
        """Moves everything on by `step_s`."""
        self._elapsed_s += self.step_s
        self._stamp_ns += self._step_ns
        for vehicle_id, vehicle in self._vehicles.items():
            motion = vehicle.plan(self._elapsed_s, self.step_s)
            moves = motion.pose != vehicle.pose
            if moves and self._blocked(vehicle_id, vehicle, motion.pose, self._others(vehicle_id)):
                vehicle.stall()
            else:
                vehicle.commit(motion, self.step_s)
        for object_id, placed in self._objects.items():
            if placed.walks:
                pose = placed.plan(self.step_s)
                if self._blocked(object_id, placed, pose, self._vehicles.items()):
                    placed.wait()
                else:
                    placed.commit(pose, self.step_s)
        self._contacts.release_parted()

    def run(self, seconds: float) -> None:
        """Steps through `seconds` of the world's time (rounded to whole steps)."""
        for _ in range(round(seconds / self.step_s)):
            self.step()

    def skip_to(self, stamp_ns: int) -> None:
        """Sets the world's time without anything happening, as after a suspended computer or a corrected clock."""
        self._stamp_ns = stamp_ns

    def set_drive(self, vehicle: str, linear_mps: float, angular_radps: float) -> None:
        """Gives a base a twist to hold. KeyError for an unknown vehicle, ValueError for a twist that is not finite."""
        self._vehicle(vehicle).set_drive(linear_mps, angular_radps, self._elapsed_s)

    def odometry(self, vehicle: str) -> Odometry:
        """What the base reports now. KeyError for an unknown vehicle."""
        base = self._vehicle(vehicle)
        front_m = max(x for x, _ in base.spec.footprint)
        reach = front_m + RANGE_MAX_M
        near = (
            other.footprint_at(other.pose)
            for _, other in self._others(vehicle)
            if base.pose.distance_to(other.pose) < reach + other.radius_m
        )
        return Odometry(
            vehicle=vehicle,
            session=self.session,
            stamp_ns=self._stamp_ns,
            x=base.odometry.x,
            y=base.odometry.y,
            yaw=base.odometry.yaw,
            linear_mps=base.measured_linear_mps,
            angular_radps=base.measured_angular_radps,
            battery=base.battery,
            range_front_m=front_range_m(base.pose, front_m, near, base.range_noise),
        )

    @property
    def scanners(self) -> Mapping[str, SimulatedScannerHead]:
        """The scanners by vehicle."""
        return self._scanners

    def scan(self, vehicle: str) -> Scan:
        """One turn of the vehicle's scanner, now. KeyError for a vehicle that has none."""
        return self.scan_with(self._scanners[vehicle], vehicle)

    def scan_with(self, scanner: SimulatedScannerHead, vehicle: str) -> Scan:
        """One turn of another scanner in the place of the vehicle's own, now."""
        base, reach = self._vehicle(vehicle), scanner.reach_m()
        outlines = [
            outline_segments(other.pose.apply(other.outline))
            for _, other in self._others(vehicle)
            if base.pose.distance_to(other.pose) < reach + other.radius_m
        ]
        return Scan(
            vehicle=vehicle,
            stamp_ns=self._stamp_ns,
            angle_min=scanner.spec.angle_min_rad,
            angle_increment=scanner.spec.angle_increment_rad,
            ranges_mm=scanner.turn(base.pose, np.vstack([self._walls.segments, *outlines])),
        )

    def truth(self) -> GroundTruth:
        """The true poses and the contacts since the start."""
        return GroundTruth(
            stamp_ns=self._stamp_ns,
            vehicles={
                name: TruePose(v.pose.x, v.pose.y, v.pose.yaw, v.linear_mps, v.angular_radps)
                for name, v in self._vehicles.items()
            },
            contacts=self._contacts.count,
        )

    def snapshot(self) -> Snapshot:
        """This instant for renderers."""
        return Snapshot(
            self._stamp_ns,
            tuple(
                VehicleSnapshot(name, v.pose.x, v.pose.y, v.pose.yaw, v.linear_mps, v.angular_radps)
                for name, v in self._vehicles.items()
            ),
            tuple(placed.snapshot() for placed in self._objects.values()),
        )

    def object_outlines(self) -> list[Polygon]:
        """The outlines of people and pallets on the map (m)."""
        return [placed.footprint_at(placed.pose) for placed in self._objects.values()]

    def place(self, vehicle: str, pose: SE2) -> None:
        """Lifts a vehicle to a pose; it stands still there, its odometry notices nothing. KeyError for an unknown one."""
        base = self._vehicle(vehicle)
        base.pose = pose
        base.stall()
        self._note_overlaps(vehicle, base)

    def put(self, item: SimulatedObject) -> None:
        """Puts an object down; one of the same id is replaced."""
        self.remove(item.id)
        placed = PlacedObject(item)
        self._objects[item.id] = placed
        for vehicle_id, vehicle in self._vehicles.items():
            if overlap_m2(placed, placed.pose, vehicle) > 0.0:
                self._contacts.touch(item.id, placed, vehicle_id, vehicle)

    def remove(self, object_id: str) -> bool:
        """Takes an object away; False when there was none."""
        self._contacts.forget(object_id)
        return self._objects.pop(object_id, None) is not None

    def _vehicle(self, vehicle: str) -> SimulatedVehicle:
        try:
            return self._vehicles[vehicle]
        except KeyError:
            known = ", ".join(self._vehicles) or "none"
            raise KeyError(f"no simulated vehicle {vehicle!r} (there are: {known})") from None

    def _others(self, vehicle_id: str) -> Iterator[tuple[str, SimulatedVehicle | PlacedObject]]:
        for name, vehicle in self._vehicles.items():
            if name != vehicle_id:
                yield name, vehicle
        yield from self._objects.items()

    def _blocked(self, body_id: str, body: Body, pose: SE2, others: Iterable[tuple[str, Body]]) -> bool:
        blocked = self._walls.block(body, pose)
        if blocked:
            self._contacts.touch(body_id, body, WALL, self._walls)
        for other_id, other in others:
            if blocks(body, pose, other):
                self._contacts.touch(body_id, body, other_id, other)
                blocked = True
        return blocked

    def _note_overlaps(self, vehicle_id: str, vehicle: SimulatedVehicle) -> None:
        for other_id, other in self._others(vehicle_id):
            if overlap_m2(vehicle, vehicle.pose, other) > 0.0:
                self._contacts.touch(vehicle_id, vehicle, other_id, other)


def _free_spot(lab: Lab, standing: list[SimulatedVehicle]) -> SE2:
    """Where a vehicle without a described start stands: the first spot of a 1 m raster inside an area with nobody near."""
    min_x, min_y, max_x, max_y = lab.bounds()
    for y in np.arange(min_y + 0.75, max_y, 1.0):
        for x in np.arange(min_x + 0.75, max_x, 1.0):
            spot = SE2(float(x), float(y), 0.0)
            inside = lab.area_at(spot.x, spot.y) is not None
            if inside and all(math.dist((spot.x, spot.y), (v.pose.x, v.pose.y)) > 0.9 for v in standing):
                return spot
    raise ValueError("no room left on the floor: give the vehicles starts in simulation.starts")
