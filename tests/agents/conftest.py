"""An agent between server, base and camera, for the tests of the agent end to end."""

from collections.abc import AsyncIterator

import pytest

from tests.agents.agent_world import World


@pytest.fixture
async def world() -> AsyncIterator[World]:
    world = World()
    await world.start()
    try:
        yield world
    finally:
        await world.stop()
