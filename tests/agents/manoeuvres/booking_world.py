"""Robots that book areas over a network which does what it likes: loses, doubles, delays and reorders messages, and robots that
begin anew and remember nothing. The smallest world in which bookings can go wrong; time stands still in it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from protocol.messages.zones import AreaUse, ZoneMessage

KEPT = 3
"""Of a robot's messages so many may still arrive, in any order, as often as the network likes."""


@dataclass(slots=True)
class Vehicle:
    """A robot's booking (or a mutant of it), its life's number, and the areas that its body is in."""

    booking: Any
    life: int = 0
    inside: set[str] = field(default_factory=set[str])
    said: list[ZoneMessage] = field(default_factory=list[ZoneMessage])
    claims: int = 0


class BookingWorld:
    """`wants` has, by robot, the areas of its passage in their order. Every action does nothing where it makes no sense."""

    def __init__(self, kind: type, wants: Sequence[tuple[str, ...]]) -> None:
        self.kind = kind
        self.wants = {f"r{index}": areas for index, areas in enumerate(wants)}
        self.vehicles = {robot: Vehicle(kind(robot, 1000)) for robot in self.wants}

    def act(self, action: tuple[str, str, str, int]) -> None:
        """(what, robot, other robot, number); AssertionError when an area is then used twice."""
        what, robot, other, number = action
        getattr(self, f"_{what}")(self.vehicles[robot], robot, other, number)
        self.check()

    def check(self) -> None:
        for area in {area for areas in self.wants.values() for area in areas}:
            users = [robot for robot, vehicle in self.vehicles.items() if area in vehicle.inside]
            assert len(users) <= 1, f"{area} is used by {users}"

    def _claim(self, vehicle: Vehicle, robot: str, other: str, number: int) -> None:
        if not vehicle.booking.claims and not vehicle.inside:
            vehicle.booking.claim(self.wants[robot], number)
            vehicle.claims += 1

    def _withdraw(self, vehicle: Vehicle, robot: str, other: str, number: int) -> None:
        for claim in list(vehicle.booking.claims):
            if not claim.begun:
                vehicle.booking.withdraw(claim)

    def _acknowledge(self, vehicle: Vehicle, robot: str, other: str, number: int) -> None:
        vehicle.booking.acknowledge()

    def _say(self, vehicle: Vehicle, robot: str, other: str, number: int) -> None:
        uses = {area: AreaUse(area, 0.0, 1.0) for area in self.wants[robot]}
        vehicle.said = [*vehicle.said[1 - KEPT :], vehicle.booking.message(uses)]

    def _deliver(self, vehicle: Vehicle, robot: str, other: str, number: int) -> None:
        if robot != other and number < len(vehicle.said):
            self.vehicles[other].booking.hear(vehicle.said[number], 0.0)

    def _enter(self, vehicle: Vehicle, robot: str, other: str, number: int) -> None:
        """A robot acknowledges, asks all others, and goes into its next area when it may. It is not there before it is out of the
        last, which would be on the safe side."""
        vehicle.booking.acknowledge()
        for claim in vehicle.booking.claims:
            standing = vehicle.booking.standing(claim, set(self.wants), 0.0)
            following = [area for area in claim.areas if area not in claim.entered]
            if following and standing.open(following[0]):
                claim.enter(following[0])
                vehicle.inside.add(following[0])

    def _leave(self, vehicle: Vehicle, robot: str, other: str, number: int) -> None:
        for claim in list(vehicle.booking.claims):
            if claim.entered:
                area = min(claim.entered, key=self.wants[robot].index)
                vehicle.inside.discard(area)
                vehicle.booking.leave(claim, area)
                return

    def _crash(self, vehicle: Vehicle, robot: str, other: str, number: int) -> None:
        """Its mind begins anew where the robot is. One inside areas says so with its first word, as the coordinator does."""
        vehicle.life += 1
        vehicle.booking = self.kind(robot, 1000 + 1000 * vehicle.life)
        if vehicle.inside:
            order = self.wants[robot]
            first = min(order.index(area) for area in vehicle.inside)
            claim = vehicle.booking.claim(order[first:], number)
            for area in vehicle.inside:
                claim.enter(area)

    def settle(self, rounds: int = 80) -> set[str]:
        """From now on everybody hears everybody, and goes on: who is not through after that. A robot leaves an area when it is in
        its next, so it waits where it is."""
        waiting = set(self.wants)
        for _ in range(rounds):
            for robot in sorted(waiting):
                self.act(("claim", robot, robot, 0))
            for robot in self.wants:
                self.act(("say", robot, robot, 0))
                for other in self.wants:
                    self.act(("deliver", robot, other, len(self.vehicles[robot].said) - 1))
            for robot in self.wants:
                self.act(("enter", robot, robot, 0))
                last = self.wants[robot][-1]
                if len(self.vehicles[robot].inside) > 1 or self.vehicles[robot].inside == {last}:
                    self.act(("leave", robot, robot, 0))
                    if not self.vehicles[robot].inside:
                        waiting.discard(robot)
        return waiting
