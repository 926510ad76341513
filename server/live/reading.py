"""Reads everything that a view needs from Redis at once, for an answer to a single request."""

from contextlib import suppress
from typing import Any, cast

from protocol import keys
from protocol.bus import Bus
from protocol.channels import (
    COMMANDS,
    GUIDANCE,
    INTAKE,
    LAB_INSTANCE,
    MANUAL,
    POSES,
    REGISTRATIONS,
    RESPONSES,
    STATUSES,
)
from protocol.codec import decode
from protocol.errors import DecodeError
from protocol.messages import CameraExtrinsics, Response
from server.repositories.documents import Store
from server.repositories.emergency_stop import read_emergency_stop
from server.repositories.plan import ASSIGNMENTS
from server.repositories.robot_settings import ROBOT_SETTINGS
from server.views.health import losses
from server.views.robots import FleetState

_PAGE = 500


async def read_fleet(bus: Bus, now_ns: int) -> FleetState:
    """The newest of everything about robots. BusUnavailableError or redis' own while Redis is out of reach."""
    store = Store(bus.redis)
    return FleetState(
        poses=await bus.latest_all(POSES),
        statuses=await bus.latest_all(STATUSES),
        registrations=await bus.latest_all(REGISTRATIONS),
        commands=await bus.latest_all(COMMANDS),
        guidance=await bus.latest_all(GUIDANCE),
        manual=await bus.latest_all(MANUAL),
        assignments=await store.all(ASSIGNMENTS),
        settings=await store.all(ROBOT_SETTINGS),
        losses=losses((await bus.latest_all(INTAKE)).get(LAB_INSTANCE), now_ns),
        emergency_stop=await read_emergency_stop(store),
    )


async def read_responses(bus: Bus, robot: str, count: int) -> list[Response]:
    """The newest responses of one robot, oldest first; damaged ones are left out. All robots' are in one stream."""
    found: list[Response] = []
    end = b"+"
    while len(found) < count:
        entries = cast("list[Any]", await bus.redis.xrevrange(keys.stream(RESPONSES.name), max=end, count=_PAGE))
        for entry_id, fields in entries:
            if fields.get(b"i") == robot.encode() and len(found) < count:
                with suppress(DecodeError, KeyError):
                    found.append(decode(Response, fields[b"m"]))
            end = b"(" + entry_id
        if len(entries) < _PAGE:
            break
    return found[::-1]


async def read_extrinsics(bus: Bus) -> dict[str, CameraExtrinsics]:
    """Every camera's calibration; damaged ones are left out."""
    raw = cast("dict[bytes, bytes]", await bus.redis.hgetall(keys.EXTRINSICS))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
    found: dict[str, CameraExtrinsics] = {}
    for name, data in raw.items():
        try:
            found[name.decode(errors="replace")] = decode(CameraExtrinsics, data)
        except DecodeError:
            continue
    return found
