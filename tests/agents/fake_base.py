"""A simulated base that speaks DRIVE, ODOMETRY and SCAN on the loopback (docs/architecture.md, "The simulated base")."""

import asyncio
import secrets
import struct

from agents.motion import STOP, Twist
from geometry import SE2
from protocol.clock import SystemClock
from protocol.datagram import Datagram, ReplayGuard, Sequencer, Verdict, pack, unpack
from protocol.errors import DecodeError
from protocol.messages import DriveSetpoint, Odometry, Scan
from tests.agents.plant import LIMITS, Plant

PERIOD_S = 0.02
WATCHDOG_S = 0.3


class FakeBase(asyncio.DatagramProtocol):
    """`setpoints` are (monotonic s, twist) as they came in; `last_motion_s` is when it last really moved; its scanner looks
    straight ahead with five beams and sees nothing unless `ranges_mm` says so."""

    def __init__(self, vehicle: str, start: SE2, key: bytes | None = None) -> None:
        self.vehicle = vehicle
        self.key = key
        self.plant = Plant(start, LIMITS.model_copy(update={"acceleration_mps2": 2.0}))  # saves the tests' time
        self.session = secrets.token_hex(4)
        self.setpoints: list[tuple[float, Twist]] = []
        self.last_motion_s = 0.0
        self.range_front_m: float | None = None
        self.ranges_mm = [0] * 5
        self.scans = True
        self.port = 0
        self.refused = 0
        self.clock = SystemClock()
        self._guard = ReplayGuard()
        self._sequencer = Sequencer(self.clock.now_ns())
        self._agent: tuple[str | int, int] | None = None
        self._transport: asyncio.DatagramTransport | None = None
        self._task: asyncio.Task[None] | None = None

    async def start(self, port: int = 0) -> None:
        loop = asyncio.get_running_loop()
        self._transport, _ = await loop.create_datagram_endpoint(lambda: self, local_addr=("127.0.0.1", port))
        self.port = self._transport.get_extra_info("sockname")[1]
        self._task = asyncio.create_task(self._run())

    async def stop(self) -> None:
        if self._task is not None:
            self._task.cancel()
            await asyncio.wait({self._task})
        if self._transport is not None:
            self._transport.close()
        await asyncio.sleep(0)

    def restart(self) -> None:
        """The base's computer restarts: odometry begins again at zero."""
        self.session = secrets.token_hex(4)
        self.plant.restart_base()

    def datagram_received(self, data: bytes, addr: tuple[str | int, int]) -> None:
        try:
            datagram = unpack(data, self.key)
        except DecodeError:
            self.refused += 1
            return
        message = datagram.message
        fresh = self._guard.check(datagram, self.clock.now_ns()) is Verdict.FRESH
        if not isinstance(message, DriveSetpoint) or message.vehicle != self.vehicle or not fresh:
            self.refused += 1
            return
        self._agent = addr
        self.plant.setpoint = Twist(message.linear_mps, message.angular_radps)
        self.setpoints.append((self.clock.monotonic_s(), self.plant.setpoint))

    def say(self, *, vehicle: str = "", key: bytes | None = None, sequence: int | None = None, x: float = 0.0) -> None:
        """Sends one odometry now; with arguments, one that is not what it should be."""
        assert self._transport is not None
        if self._agent is None:
            return
        plant = self.plant
        odometry = Odometry(
            vehicle=vehicle or self.vehicle,
            session=self.session,
            stamp_ns=self.clock.now_ns(),
            x=x or plant.odometry.x,
            y=plant.odometry.y,
            yaw=plant.odometry.yaw,
            linear_mps=plant.twist.linear_mps,
            angular_radps=plant.twist.angular_radps,
            battery=0.9,
            range_front_m=self.range_front_m,
        )
        number = self._sequencer.next() if sequence is None else sequence
        self._transport.sendto(pack(Datagram("lab", number, odometry.stamp_ns, odometry), key or self.key), self._agent)

    def say_scan(self) -> None:
        """Sends one turn of the scanner now: beams 0.02 rad apart."""
        assert self._transport is not None
        if self._agent is None:
            return
        stamp_ns = self.clock.now_ns()
        scan = Scan(self.vehicle, stamp_ns, -0.04, 0.02, struct.pack(">5H", *self.ranges_mm))
        self._transport.sendto(pack(Datagram("lab", self._sequencer.next(), stamp_ns, scan), self.key), self._agent)

    async def _run(self) -> None:
        last_s = self.clock.monotonic_s()
        while True:
            await asyncio.sleep(PERIOD_S)
            now_s = self.clock.monotonic_s()
            if self.setpoints and now_s - self.setpoints[-1][0] > WATCHDOG_S:
                self.plant.setpoint = STOP
            self.plant.step(now_s - last_s)
            last_s = now_s
            if self.plant.twist != STOP:
                self.last_motion_s = now_s
            self.say()
            if self.scans:
                self.say_scan()
