"""Commands between the bus and the streams."""

import asyncio

from protocol.clock import SystemClock
from server.live.feeds import CommandFeeds
from server.live.handing_out import HandingOut

ROBOTS = [f"robot-{number}" for number in range(250)]


async def test_what_is_superseded_before_it_could_go_out_is_left_out() -> None:
    """As when a server cannot keep up: newer commands arrive while the older ones go out, a hundred at a time."""
    feeds, sent, rounds = CommandFeeds(), list[tuple[str, bytes]](), 0

    class Clock(SystemClock):
        async def sleep(self, seconds: float) -> None:
            nonlocal rounds
            rounds += 1
            if rounds == 1:
                handing_out.take(dict.fromkeys(ROBOTS, b"new"))
            await asyncio.sleep(seconds)

    def note(robot: str, encoded: bytes) -> None:
        sent.append((robot, encoded))

    feeds.command = note
    handing_out = HandingOut(feeds, Clock())
    handing_out.take(dict.fromkeys(ROBOTS, b"old"))
    task = asyncio.create_task(handing_out.run())
    for _ in range(20):
        await asyncio.sleep(0)
    task.cancel()
    newest = dict(sent)
    assert newest == dict.fromkeys(ROBOTS, b"new")
    assert sum(command == b"old" for _, command in sent) == 100, "what went out before the newer ones came, and no more"
    assert [robot for robot, _ in sent[:250]] == ROBOTS, "who waits keeps the place in the queue"
