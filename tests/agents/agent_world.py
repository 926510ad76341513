"""Server, base, camera and guidance around a real agent, over real sockets on the loopback."""

import asyncio
import socket
from collections.abc import Callable

from agents.agent import Agent, AgentConfig
from agents.drivers import SimDriver, SimDriverConfig
from agents.motion import STOP
from geometry import SE2
from protocol.clock import SystemClock
from protocol.lab import load_lab
from protocol.messages import Command
from tests.agents.fake_base import FakeBase
from tests.agents.fake_server import FakeServer
from tests.agents.orders import Orders
from tests.agents.plant import tracked
from tests.agents.waiting import until

ROBOT = "wifibot-14"
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as _probe:
    _probe.bind(("127.0.0.1", 0))
    _FREE_PORT = int(_probe.getsockname()[1])
_SHIPPED = load_lab("labs/gulliver.yaml")
LAB = _SHIPPED.model_copy(update={"ports": _SHIPPED.ports.model_copy(update={"stop_udp": _FREE_PORT})})
KEY = b"a shared key of the whole lab"


class World:
    """Server, base, camera, guidance and the agent between them. `order` is what the guidance says; None: silence."""

    def __init__(self) -> None:
        self.clock = SystemClock()
        self.server = FakeServer(ROBOT, key=KEY)
        self.base = FakeBase(ROBOT, SE2(1.0, 1.0, 0.0), KEY)
        self.orders = Orders(ROBOT)
        self.order: Callable[[int], Command] | None = None
        self.camera_works = True
        self.last_command_s = 0.0
        self.agent: Agent | None = None
        self._tasks: list[asyncio.Task[None]] = []

    async def start(self, token: str = "secret") -> None:
        await self.base.start()
        await self.server.start()
        await self.start_agent(token)
        self._tasks += [asyncio.create_task(self._camera()), asyncio.create_task(self._guidance())]

    async def start_agent(self, token: str = "secret") -> None:
        vehicle = LAB.vehicle(ROBOT)
        config = SimDriverConfig("127.0.0.1", self.base.port, ROBOT, vehicle.limits, KEY, vehicle.scanner)
        driver = SimDriver(config, self.clock)
        self.agent = Agent(AgentConfig(LAB, vehicle, self.server.url, token, KEY), driver, self.clock)
        self._agent_task = asyncio.create_task(self.agent.run())
        self._tasks.append(self._agent_task)

    async def stop_agent(self) -> None:
        self._agent_task.cancel()
        await asyncio.wait({self._agent_task})

    async def stop(self) -> None:
        for task in self._tasks:
            task.cancel()
        for result in await asyncio.gather(*self._tasks, return_exceptions=True):
            if isinstance(result, Exception):
                raise result
        await self.server.stop()
        await self.base.stop()

    async def _camera(self) -> None:
        while True:
            stamp_ns, pose = self.clock.now_ns(), self.base.plant.pose
            await asyncio.sleep(1 / 15)
            if self.camera_works and self.server.registrations:
                self.server.send_pose(tracked(ROBOT, pose, stamp_ns))

    async def _guidance(self) -> None:
        while True:
            if self.order is not None and self.server.streams:
                self.server.send(self.order(self.clock.now_ns()))
                self.last_command_s = self.clock.monotonic_s()
            await asyncio.sleep(0.1)

    def go(self, x: float = 7.0, y: float = 1.0, speed: float = 0.4) -> None:
        self.order = lambda now_ns: self.orders.move_to(now_ns, x, y, speed=speed)

    @property
    def speed(self) -> float:
        return abs(self.base.plant.twist.linear_mps)

    async def moving(self) -> None:
        await until(lambda: self.speed > 0.25, "the robot drives")

    async def still(self) -> None:
        await until(lambda: self.base.plant.twist == STOP, "the robot stands")

    def first_zero_after(self, instant_s: float) -> float | None:
        return next((at for at, twist in self.base.setpoints if at >= instant_s and twist == STOP), None)
