"""The agent of one robot: connects the pilot to the server, the tracker and the base (docs/architecture.md, "The order of a
robot"). It is also the example of how a robot takes part:

1. open a UDP socket; register it over HTTP, again every 5 s and after each reconnection;
2. follow the stream of commands; keep still until its first event says that the emergency stop is released;
3. take poses from the UDP socket, odometry and scans from the driver; stop at once for what is in the protective field;
4. twenty times a second, decide on a twist and send it to the base, zero included;
5. ten times a second, send a status by UDP; when something else is obeyed or a target is reached, post a response.
"""

import asyncio
import logging
import secrets
from contextlib import AsyncExitStack, suppress
from dataclasses import dataclass, field

from agents.consistency_log import ConsistencyLog
from agents.control import CONTROLLERS, controller_name
from agents.drivers import Driver, DriverError
from agents.estimation import DEFAULT_ESTIMATOR, ESTIMATORS
from agents.link import (
    CommandStream,
    Introduction,
    Registrar,
    ResponseQueue,
    RobotSocket,
    StopListener,
    Welcome,
    bind_host,
    make_client,
    server_host,
    stop_host,
)
from agents.link.backoff import Backoff, Trouble
from agents.motion import STOP
from agents.pacing import CONTROL_RATE_HZ, Pacer
from agents.pilot import Pilot
from agents.protection import RangeScan
from agents.safety import ODOMETRY_LIMIT_S, Verdict
from protocol.clock import Clock
from protocol.lab import Lab, VehicleSpec
from protocol.messages import Command, EmergencyStop, Movement, Status, TrackedPose

STATUS_RATE_HZ = 10.0
STARTING_S = 5.0
"""A base that has not spoken this early is still starting: no fault yet."""
_logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class AgentConfig:
    """Which robot, in which lab, under which server; `controller` (None: the lab file's, or the default) and `estimator`
    are names of their registries."""

    lab: Lab
    vehicle: VehicleSpec
    server_url: str
    token: str = field(repr=False)
    udp_key: bytes | None = field(default=None, repr=False)
    controller: str | None = None
    estimator: str = DEFAULT_ESTIMATOR


class Agent:
    """`run` until cancelled; whatever ends it, the last set-point is zero."""

    def __init__(self, config: AgentConfig, driver: Driver, clock: Clock) -> None:
        vehicle = config.vehicle
        controller = CONTROLLERS[controller_name(vehicle, config.controller)](vehicle)
        self.pilot = Pilot(config.lab, vehicle, ESTIMATORS[config.estimator](), controller)
        self.socket = RobotSocket(vehicle.id, config.udp_key, clock, self._on_pose)
        self._config = config
        self._driver = driver
        driver.watch_scans(self._on_scan)
        self._clock = clock
        self._server_host = server_host(config.server_url)
        self._base_trouble = Trouble(_logger, "base")
        self._order_trouble = Trouble(_logger, "refused commands")
        self._started_s = clock.monotonic_s()
        self._base_heard = False

    async def run(self) -> None:
        """For ever. OSError when no UDP socket can be opened."""
        config, robot = self._config, self._config.vehicle.id
        async with AsyncExitStack() as stack:
            port = await self.socket.open(bind_host(self._server_host))
            stack.callback(self.socket.close)
            client = await stack.enter_async_context(make_client(config.server_url, config.token))
            introduction = Introduction(kind=config.vehicle.kind, udp_port=port, session=secrets.token_hex(8))
            registrar = Registrar(client, robot, introduction, self._clock, self._on_welcome)
            stream = CommandStream(
                client,
                robot,
                self._clock,
                on_open=registrar.again,
                on_command=self._on_command,
                on_emergency_stop=self._on_emergency_stop,
            )
            responses = ResponseQueue(client, robot, self._clock)
            stops = StopListener(config.udp_key, self._clock, self._on_emergency_stop, self._status)
            stack.push_async_callback(self._driver.close)
            _logger.info("%s listens on UDP port %d, server %s", robot, port, config.server_url)
            with suppress(DriverError):  # said and tried again below
                await self._driver.connect()
            async with asyncio.TaskGroup() as tasks:
                tasks.create_task(self._keep_connected())
                tasks.create_task(self._control(responses))
                tasks.create_task(registrar.run())
                tasks.create_task(stream.run())
                tasks.create_task(responses.run())
                tasks.create_task(self._report())
                tasks.create_task(stops.run(stop_host(self._server_host), config.lab.ports.stop_udp))

    async def _keep_connected(self) -> None:
        """Connects the driver, and again whenever it lost the base."""
        backoff = Backoff()
        while True:
            try:
                await self._driver.connect()
                backoff.reset()
                await self._clock.sleep(0.5)
            except DriverError as error:
                self._base_trouble.note(str(error))
                await self._clock.sleep(backoff.next_s())

    async def _control(self, responses: ResponseQueue) -> None:
        """The control loop: the only place, but for stops at once and the end, that sends set-points."""
        pacer = Pacer(self._clock, CONTROL_RATE_HZ)
        while True:
            self._read_base()
            decision = self.pilot.decide(self._clock.now_ns(), self._clock.monotonic_s())
            try:
                self._driver.send_twist(decision.twist)
            except DriverError as error:
                self.pilot.odometry_failed(str(error))
            for response in decision.responses:
                responses.put(response)
            overruns = pacer.overruns
            await pacer.wait()
            if pacer.overruns > overruns:
                _logger.debug("control loop late, %d times so far", pacer.overruns)

    def _read_base(self) -> None:
        try:
            reading = self._driver.read_odometry(ODOMETRY_LIMIT_S)
        except DriverError as error:
            if self._base_heard or self._clock.monotonic_s() - self._started_s > STARTING_S:
                self._base_trouble.note(str(error))
            self.pilot.odometry_failed(str(error))
            return
        self._base_heard = True
        self.pilot.battery(self._driver.battery())
        faults = self._driver.faults()
        if faults:
            self._base_trouble.note(faults[0])
        else:
            self._base_trouble.over()
        self.pilot.odometry(reading, faults)

    async def _report(self) -> None:
        pacer = Pacer(self._clock, STATUS_RATE_HZ)
        consistency = ConsistencyLog(self.pilot, self._clock.monotonic_s())
        while True:
            self.socket.send_status(self._status(self.socket.next_sequence()))
            consistency.look(self._clock.monotonic_s())
            await pacer.wait()

    def _status(self, sequence: int) -> Status:
        trouble = self._base_trouble.text
        return self.pilot.status(
            sequence,
            self._clock.now_ns(),
            self._clock.monotonic_s(),
            ip=self.socket.address,
            battery=self._driver.battery(),
            faults=() if trouble is None else (trouble,),
        )

    def _on_pose(self, pose: TrackedPose) -> None:
        self.pilot.camera_pose(pose, self._clock.now_ns(), self._clock.monotonic_s())

    def _on_command(self, command: Command) -> None:
        verdict = self.pilot.command(command, self._clock.now_ns(), self._clock.monotonic_s())
        match verdict:
            case Verdict.OLD_EPOCH:
                self._order_trouble.note(
                    f"a guidance of epoch {command.epoch} still commands, a newer one has taken over; restart this agent if"
                    " the epochs have started over"
                )
            case Verdict.EXPIRED:
                self._order_trouble.note("commands come after their deadline; do the clocks of robot and server agree?")
            case Verdict.FOREIGN:
                self._order_trouble.note(f"commands for {command.robot} come here")
            case Verdict.OBEYED if command.movement in (Movement.WAITING, Movement.NO_ACTION):
                self._stop_now()  # without waiting for the next round
            case _:
                pass

    def _on_emergency_stop(self, event: EmergencyStop) -> None:
        """Stops at once; the control loop then keeps on commanding zero."""
        if self.pilot.emergency_stop(event):
            _logger.warning("emergency stop: %s", event.reason or event.by or "engaged")
            self._stop_now()

    def _on_scan(self, scan: RangeScan) -> None:
        """Stops at once for what is in the protective field; the control loop says why and keeps on commanding zero."""
        if self.pilot.scan(scan, self._clock.monotonic_s()):
            self._stop_now()

    def _stop_now(self) -> None:
        try:
            self._driver.send_twist(STOP)
        except DriverError as error:
            self._base_trouble.note(str(error))

    async def _on_welcome(self, welcome: Welcome) -> None:
        await self.socket.send_to(self._server_host, welcome.robots_udp)
