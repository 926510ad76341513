"""The newest messages of all channels as the hub keeps them: as they came, and decoded only when somebody looks. With many robots
and nobody at the console nearly all of them are superseded unread."""

import logging
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import msgspec

from protocol.bus import ReceivedRaw
from protocol.channels import COMMANDS, Channel
from protocol.codec import UNDECODABLE, decode
from protocol.errors import DecodeError

_logger = logging.getLogger(__name__)


class _Order(msgspec.Struct):
    """What makes a command one, at a fifth of the time that checking all of it takes."""

    robot: str
    epoch: int
    sequence: int
    stamp_ns: int
    deadline_ns: int


_ORDERS = msgspec.json.Decoder(_Order)


class _Holder(msgspec.Struct):
    stop_epoch: int | None = None


_HOLDERS = msgspec.json.Decoder(_Holder)
_HOLDS_NONE = b'"stop_epoch":null'


class NewestMessages:
    """By channel name and instance. What does not decode changes nothing, but for a line in the log."""

    def __init__(self, channels: Iterable[Channel[Any]]) -> None:
        self._decoded: dict[str, dict[str, Any]] = {}
        self._waiting: dict[str, dict[str, bytes]] = {}
        self._channels = {channel.name: channel for channel in channels}
        for name in self._channels:
            self._decoded[name], self._waiting[name] = {}, {}

    def take(self, received: ReceivedRaw) -> None:
        """Keeps them for when somebody looks."""
        self._waiting[received.channel.name].update(received.messages)

    def replace(self, channel: Channel[Any], messages: dict[str, Any]) -> None:
        """Makes these the whole of a channel."""
        self._decoded[channel.name] = messages

    def of(self, channel: Channel[Any]) -> Mapping[str, Any]:
        """The newest that was decoded, by instance; `catch_up` before."""
        return self._decoded[channel.name]

    def stamps(self) -> dict[str, dict[str, int]]:
        """When they were made (ns; 0 where a message does not say), by channel name and instance; `catch_up` before."""
        return {
            name: {instance: int(getattr(message, "stamp_ns", 0)) for instance, message in messages.items()}
            for name, messages in self._decoded.items()
        }

    def catch_up(self, channel: Channel[Any], changed: Callable[[Any, Any], object] | None = None) -> None:
        """Decodes what has come since. `changed` is told of each message with the one before, None for the first."""
        decoded, waiting = self._decoded[channel.name], self._waiting[channel.name]
        self._waiting[channel.name] = {}
        for instance, data in waiting.items():
            message = decoded_or_none(channel, instance, data)
            if message is None:
                continue
            if changed is not None:
                changed(decoded.get(instance), message)
            decoded[instance] = message


def decoded_or_none(channel: Channel[Any], instance: str, data: bytes) -> Any:
    """None, and a line in the log, for what does not decode."""
    try:
        return decode(channel.message, data)
    except DecodeError as error:
        _logger.warning("ignored a message on %s of %s: %s", channel.name, instance, error)
        return None


def orders(messages: Mapping[str, bytes]) -> dict[str, bytes]:
    """The commands among them, by robot. One that comes alone is looked at whole. Of many at once, which guidance alone says, all
    of the JSON is read but not every field: the robots check each for themselves."""
    found: dict[str, bytes] = {}
    for robot, data in messages.items():
        if len(messages) == 1:
            command = decoded_or_none(COMMANDS, robot, data)
            if command is not None:
                found[command.robot] = data
            continue
        try:
            found[_ORDERS.decode(data).robot] = data
        except UNDECODABLE as error:
            _logger.warning("ignored a message on %s of %s: %s", COMMANDS.name, robot, error)
    return found


def held_stop(status: bytes) -> int | None:
    """The epoch of the emergency stop that a robot's status says it holds; None for none, and for what does not decode."""
    if _HOLDS_NONE in status:  # as nearly always; within texts, JSON has its quotes escaped
        return None
    try:
        return _HOLDERS.decode(status).stop_epoch
    except UNDECODABLE:
        return None
