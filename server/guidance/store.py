"""Guidance's side of Redis: the lease that makes one guidance the active one, the snapshot, and saying what was decided.

All that an active guidance writes goes through one script that first looks whether the lease is still its own: one that was
held up, or whose lease ran out, writes nothing. Assignments are replaced only when they are still what was read.
"""

import logging
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, TypeVar, cast

import redis.asyncio
from msgspec import Meta, Struct
from pydantic import BaseModel

from protocol import keys
from protocol.bus import publication
from protocol.channels import (
    COMMANDS,
    EMERGENCY_STOP,
    EVENTS,
    GUIDANCE,
    LAB_INSTANCE,
    MANUAL,
    OBSTACLES,
    POSES,
    STATUSES,
    Channel,
)
from protocol.clock import Clock
from protocol.codec import decode, encode
from protocol.errors import DecodeError
from protocol.messages import Assignment, EmergencyStop, RobotSettings, Route, SpeedZone, Waypoint
from protocol.messages.base import Real, Whole
from server.guidance.snapshot import Outcome, Snapshot
from server.guidance.wording import Worded

M = TypeVar("M", bound=BaseModel | Struct)
_logger = logging.getLogger(__name__)

LEASE_S = 1.0
_STREAM_LENGTH = 10_000
_EPOCHS_BEGIN_S = 1_577_836_800
"""2020-01-01, from which the seconds are counted that are the least of a new epoch."""
_HIGHEST_CLAIM = 2**32
_HIGHEST_JUMP = 1000
"""An epoch that somebody claims is taken for nonsense when it is further ahead than this and no clock of the next hundred
years yields it. Clocks differ, and one that starts in 1970 must still believe the robots."""

_ACQUIRE = """
if redis.call('EXISTS', KEYS[1]) == 1 then return false end
local counter = tonumber(redis.call('GET', KEYS[2]) or '0') or 0
local epoch = math.max(counter, tonumber(ARGV[2])) + 1
epoch = math.max(epoch, tonumber(ARGV[3]))
redis.call('SET', KEYS[2], string.format('%.0f', epoch))
redis.call('SET', KEYS[1], string.format('%.0f', epoch), 'PX', ARGV[1])
return epoch
"""
_RELEASE = "if redis.call('GET', KEYS[1]) == ARGV[1] then return redis.call('DEL', KEYS[1]) end return 0"
# ARGV: epoch, lease in ms, then three groups, each after its count: channels (hash, topic, what to publish on it, how many
# messages, instance and data of each), assignments (robot, what it was, what it becomes), events (instance, data). Fields are
# set a thousand at a time: Lua's stack ends at some thousands.
_SAY = """
if redis.call('GET', KEYS[1]) ~= ARGV[1] then return 0 end
redis.call('PEXPIRE', KEYS[1], ARGV[2])
local at = 3
local function count() at = at + 1 return tonumber(ARGV[at - 1]) end
for _ = 1, count() do
  local hash, topic, said = ARGV[at], ARGV[at + 1], ARGV[at + 2]
  at = at + 3
  local left = count()
  while left > 0 do
    local some = math.min(left, 1000)
    redis.call('HSET', hash, unpack(ARGV, at, at + 2 * some - 1))
    at, left = at + 2 * some, left - some
  end
  redis.call('PUBLISH', topic, said)
end
for _ = 1, count() do
  if redis.call('HGET', KEYS[2], ARGV[at]) == ARGV[at + 1] then redis.call('HSET', KEYS[2], ARGV[at], ARGV[at + 2]) end
  at = at + 3
end
for _ = 1, count() do
  redis.call('XADD', KEYS[3], 'MAXLEN', '~', ARGV[at], '*', 'i', ARGV[at + 1], 'm', ARGV[at + 2])
  at = at + 3
end
return 1
"""


class HeardStatus(Struct, frozen=True):
    """Of a status what guidance reads, at a fifth of the time that all of it takes: the server has checked it as a whole before
    it came here, and each robot sends ten a second."""

    stamp_ns: Whole
    linear_mps: Real
    angular_radps: Real
    battery: Annotated[float, Meta(ge=0, le=1)] | None = None
    command_order: tuple[Whole, Whole] | None = None


class GuidanceStore:
    """What guidance reads and writes. Every method raises redis-py's errors while Redis is out of reach."""

    def __init__(self, client: redis.asyncio.Redis, clock: Clock) -> None:
        self._redis = client
        self._clock = clock
        self._acquire = client.register_script(_ACQUIRE)
        self._release = client.register_script(_RELEASE)
        self._say = client.register_script(_SAY)
        self._decoded: dict[str, dict[str, tuple[bytes, Any]]] = {}
        self._assignments: Mapping[str, bytes] = {}

    async def acquire(self, above: int) -> int | None:
        """Becomes the active guidance: the new epoch, greater than every earlier one and than `above`; None while another
        one is active. It is no less than the seconds since 2020 either, so that epochs grow also when Redis has lost all
        that it knew of them."""
        seconds = max(0, self._clock.now_ns() // 1_000_000_000 - _EPOCHS_BEGIN_S)
        got = await self._acquire(
            keys=[keys.GUIDANCE_LEASE, keys.GUIDANCE_EPOCH], args=[round(LEASE_S * 1000), above, seconds]
        )
        return None if got is None else int(cast("int", got))

    async def release(self, epoch: int) -> None:
        """Gives the lease back if it is still that epoch's, so that a stand-by need not wait for it to run out."""
        await self._release(keys=[keys.GUIDANCE_LEASE], args=[epoch])

    async def snapshot(self) -> Snapshot:
        """Everything that guidance reads, in one round trip. What does not decode is left out with a line in the log; an
        emergency stop that cannot be read counts as engaged."""
        pipeline = self._redis.pipeline(transaction=False)
        channels = (POSES, STATUSES, MANUAL, EMERGENCY_STOP, OBSTACLES)
        hashes = (keys.WAYPOINTS, keys.ROUTES, keys.ASSIGNMENTS, keys.ROBOT_SETTINGS, keys.SPEED_ZONES)
        for key in (*(keys.live(channel.name) for channel in channels), *hashes):
            pipeline.hgetall(key)  # pyright: ignore[reportUnusedCoroutine]  # queued
        raw = cast("list[dict[bytes, bytes]]", await pipeline.execute())
        poses, statuses, manual, stop, obstacles, waypoints, routes, assignments, settings, zones = raw
        self._assignments = {name.decode(errors="replace"): data for name, data in assignments.items()}
        stops = self._live(EMERGENCY_STOP, stop)
        latch = stops.get(LAB_INSTANCE)
        if latch is None and LAB_INSTANCE.encode() in stop:
            latch = EmergencyStop(engaged=True, reason="its record cannot be read")
        return Snapshot(
            now_ns=self._clock.now_ns(),
            now_s=self._clock.monotonic_s(),
            poses=self._live(POSES, poses),
            statuses=self._decode(STATUSES.name, HeardStatus, statuses),
            manual=self._live(MANUAL, manual),
            emergency_stop=latch,
            obstacles=self._live(OBSTACLES, obstacles).get(LAB_INSTANCE),
            waypoints=self._decode(keys.WAYPOINTS, Waypoint, waypoints),
            routes=self._decode(keys.ROUTES, Route, routes),
            assignments=self._decode(keys.ASSIGNMENTS, Assignment, assignments),
            settings=self._decode(keys.ROBOT_SETTINGS, RobotSettings, settings),
            speed_zones=self._decode(keys.SPEED_ZONES, SpeedZone, zones),
        )

    async def highest_epoch(self, snapshot: Snapshot) -> int:
        """The highest epoch that was commanded or that a robot says it obeyed; nonsense does not count."""
        counter = await self._redis.get(keys.GUIDANCE_EPOCH)
        commands = cast("dict[bytes, bytes]", await self._redis.hgetall(keys.live(COMMANDS.name)))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
        known = int(counter or 0)
        said = [command.epoch for command in self._live(COMMANDS, commands).values()]
        return max([known, *newer_epochs([*said, *obeyed_epochs(snapshot)], known)])

    async def say(self, outcome: Outcome, epoch: int) -> bool:
        """Publishes, all or nothing, and renews the lease; False when the lease is no longer that epoch's."""
        live: list[bytes | str | int] = []
        channels: tuple[tuple[Channel[Any], Mapping[str, BaseModel]], ...]
        channels = ((COMMANDS, outcome.commands), (GUIDANCE, outcome.states))
        said = [(channel, _encoded(messages)) for channel, messages in channels if messages]
        for channel, messages in said:
            live += [keys.live(channel.name), *publication(channel, messages), len(messages)]
            live += [part for entry in messages.items() for part in entry]
        changes: list[bytes | str] = []
        for change in outcome.changes:
            robot = change.before.robot
            changes += [robot, self._assignments.get(robot, b""), encode(change.after)]
        events: list[bytes | str | int] = []
        for event in outcome.events:
            events += [_STREAM_LENGTH, LAB_INSTANCE, encode(event)]
        args = [epoch, round(LEASE_S * 1000), len(said), *live]
        args += [len(changes) // 3, *changes, len(events) // 3, *events]
        done = await self._say(keys=[keys.GUIDANCE_LEASE, keys.ASSIGNMENTS, keys.stream(EVENTS.name)], args=args)
        return done == 1

    def _live(self, channel: Channel[M], raw: dict[bytes, bytes]) -> dict[str, M]:
        return self._decode(channel.name, channel.message, raw)

    def _decode(self, what: str, kind: type[M], raw: dict[bytes, bytes]) -> dict[str, M]:
        """Decodes only what changed since the last time."""
        known, fresh = self._decoded.get(what, {}), dict[str, tuple[bytes, Any]]()
        for name_bytes, data in raw.items():
            name = name_bytes.decode(errors="replace")
            before = known.get(name)
            if before is not None and before[0] == data:
                fresh[name] = before
                continue
            try:
                fresh[name] = (data, decode(kind, data))
            except DecodeError as error:
                fresh[name] = (data, None)
                _logger.warning("ignored %s of %s: %s", what, name, error)
        self._decoded[what] = fresh
        return {name: cast("M", message) for name, (_, message) in fresh.items() if message is not None}


def _encoded(messages: Mapping[str, BaseModel]) -> Mapping[str, bytes]:
    if isinstance(messages, Worded):
        return messages.encoded
    return {name: encode(message) for name, message in messages.items()}


def obeyed_epochs(snapshot: Snapshot) -> list[int]:
    """The epochs of the newest commands that robots say they accepted."""
    return [status.command_order[0] for status in snapshot.statuses.values() if status.command_order is not None]


def newer_epochs(epochs: Iterable[int], than: int) -> list[int]:
    """Those that are newer, and not so much newer that they cannot be."""
    return [epoch for epoch in epochs if than < epoch <= max(_HIGHEST_CLAIM, than + _HIGHEST_JUMP)]
