"""Hands commands and the emergency stop to the robots' open streams; the newest wins, a slow robot misses old ones."""

import asyncio
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field

from protocol.messages import EmergencyStop


@dataclass(slots=True, eq=False)
class Feed:
    """What one stream has not sent yet, the command as JSON on one line; `woken` is set when there is something, or when all is
    over. While the stream is `idle`, everything of before is sent, and commands need not wake it where there is a way to
    `write` them directly: that says whether it took the event."""

    robot: str
    emergency_stop: EmergencyStop | None
    command: bytes | None
    woken: asyncio.Event = field(default_factory=asyncio.Event)
    idle: bool = False
    write: Callable[[bytes], bool] | None = None

    def take(self, command: bytes) -> None:
        """Has the stream send a command, instead of one that it has not sent yet."""
        if self.idle and self.write is not None and not self.woken.is_set() and self.write(command_event(command)):
            return
        self.command = command
        self.woken.set()


class CommandFeeds:
    """The open streams of all robots."""

    def __init__(self) -> None:
        self._feeds: set[Feed] = set()
        self._of_robot: dict[str, set[Feed]] = {}
        self._commands: dict[str, bytes] = {}
        self.emergency_stop: EmergencyStop | None = None
        self.closed = False

    @contextmanager
    def open(self, robot: str) -> Generator[Feed]:
        """A stream's feed, which begins with what is current."""
        feed = Feed(robot, self.emergency_stop, self._commands.get(robot))
        feed.woken.set()
        self._feeds.add(feed)
        of_robot = self._of_robot.setdefault(robot, set())
        of_robot.add(feed)
        try:
            yield feed
        finally:
            self._feeds.discard(feed)
            of_robot.discard(feed)

    def __len__(self) -> int:
        return len(self._feeds)

    def stop(self, stop: EmergencyStop) -> bool:
        """Whether what is known of the latch changed. What engages is believed; a release only with a greater epoch than
        the engagement's, as the robots hold it: one that was overtaken on the way releases nothing, and a clock that was
        set back does not matter. The epoch that is known never shrinks, and an engagement after a release has a greater one
        than that, as with the robots."""
        known = self.emergency_stop
        if known is not None:
            if not stop.engaged and (stop.epoch <= known.epoch if known.engaged else stop.epoch < known.epoch):
                return False
            least = known.epoch + 1 if stop.engaged and not known.engaged else known.epoch
            if stop.epoch < least:
                stop = stop.model_copy(update={"epoch": least})
            if stop == known:
                return False
        self.emergency_stop = stop
        for feed in self._feeds:
            feed.emergency_stop = stop
            feed.woken.set()
        return True

    def announced(self, stop: EmergencyStop) -> bool:
        """The same of what was announced: announcements may come late, and one with a smaller epoch tells of the past."""
        return stop.epoch >= self.epoch and self.stop(stop)

    @property
    def epoch(self) -> int:
        """The latch's greatest epoch so far, 0 before anything is known."""
        return 0 if self.emergency_stop is None else self.emergency_stop.epoch

    def command(self, robot: str, encoded: bytes) -> None:
        """The robot's newest command, as JSON."""
        if b"\n" in encoded or b"\r" in encoded:  # between fields, as in texts JSON escapes them
            encoded = encoded.replace(b"\n", b" ").replace(b"\r", b" ")
        self._commands[robot] = encoded
        for feed in self._of_robot.get(robot, ()):
            feed.take(encoded)

    def close(self) -> None:
        """Ends every stream."""
        self.closed = True
        for feed in self._feeds:
            feed.woken.set()


def command_event(encoded: bytes) -> bytes:
    """The server-sent event of a command that is JSON on one line."""
    return b"event: command\ndata: %b\n\n" % encoded
