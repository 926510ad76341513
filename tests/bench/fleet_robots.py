"""The load: a process that plays many robots over loopback. Each has a UDP socket of its own for its statuses, an open stream of
commands, and registers as often as the server asks for, at the rates and in the words of `agents`."""

import re
import resource
import select
import socket
import time
from array import array
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from multiprocessing.connection import Connection

from agents.agent import STATUS_RATE_HZ
from agents.link.registration import PERIOD_S
from agents.safety import COMMAND_LIMIT_S
from protocol.datagram import Sequencer
from tests.bench.fleet_lab import place
from tests.bench.fleet_robot import CommandReader, Reporter

_HOST = "127.0.0.1"
_CONNECT_S = 120.0
_AT_ONCE = 50
"""So many robots come up at the same time."""
_SLICE_S = 0.004
"""So long it waits for something to hear before it sends what is due."""
_RETRY_S = 0.5
"""After the server refused or hung up, as agents do at first."""
_PIECE = 65536
_WELCOME = re.compile(rb'"robots_udp":(\d+),.*"again_s":([0-9.]+)')


@dataclass(frozen=True, slots=True)
class Load:
    """Which robots to play (token by name), where the server is, and the key of datagrams."""

    tokens: Mapping[str, str] = field(repr=False)
    http_port: int
    key: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class Played:
    """What the robots met since they were told to count: statuses and registrations sent, how often the server refused one or
    ended a stream, the ages of commands on arrival (ms), how often a robot heard no fresh command for longer than its dead-man's
    limit, the time (s) and the processor time of this process (s). `sent` is since the start."""

    sent: int
    statuses: int
    registrations: int
    refused: int
    command_ms: "array[float]"
    starved: int
    seconds: float
    cpu_s: float


@dataclass(slots=True, eq=False)
class _Robot:
    name: str
    token: str
    reporter: Reporter
    udp: socket.socket
    stream: socket.socket | None = None
    reader: CommandReader = field(default_factory=CommandReader)
    registering: socket.socket | None = None
    answer: bytes = b""
    registered: bool = False
    heard_s: float = 0.0


def play(connection: Connection, load: Load) -> None:  # pragma: no cover  # runs in a process of its own
    """Sends None once all robots hear commands; then waits for `count`, `stop`, and answers with what was Played. Any text is
    what went wrong."""
    _, most_files = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most_files, most_files))  # each robot has up to three
    try:
        robots = Robots(load)
        robots.come_up()
        connection.send(None)
        robots.drive(connection.poll)
        connection.recv()
        robots.count()
        robots.drive(connection.poll)
        connection.recv()
        connection.send(robots.played())
    except (OSError, RuntimeError) as error:
        connection.send(f"the robots ended: {type(error).__name__}: {error}")


class Robots:
    """All of them on one loop; statuses are spread evenly over time, as robots that know nothing of each other send them."""

    def __init__(self, load: Load) -> None:
        self._load = load
        self._epoll = select.epoll()
        self._by_socket: dict[int, Callable[[], None]] = {}
        self._robots: list[_Robot] = []
        self._later: deque[tuple[float, Callable[[], None]]] = deque()
        self._sent = 0
        self._begun_s = self._registered_s = time.monotonic()
        self._next_status = self._next_registration = 0
        self._again_s = PERIOD_S
        self.count()

    def count(self) -> None:
        """Counts from now on."""
        self._sent_before, self._registrations, self._refused, self._starved = self._sent, 0, 0, 0
        self._command_ms: array[float] = array("d")
        self._counting_s, self._cpu_s = time.monotonic(), time.process_time()

    def played(self) -> Played:
        """Since `count`."""
        seconds, cpu = time.monotonic() - self._counting_s, time.process_time() - self._cpu_s
        statuses = self._sent - self._sent_before
        return Played(
            self._sent,
            statuses,
            self._registrations,
            self._refused,
            self._command_ms,
            self._starved,
            seconds,
            cpu,
        )

    def come_up(self) -> None:
        """Connects and registers all, some at a time. RuntimeError when one does not hear of its server in time."""
        waiting: list[_Robot] = []
        deadline_s = time.monotonic() + _CONNECT_S
        names = list(self._load.tokens)
        while names or waiting:
            while names and len(waiting) < _AT_ONCE:
                waiting.append(self._connected(names.pop(0), len(self._load.tokens)))
            self._hear(0.05)
            waiting = [robot for robot in waiting if not (robot.reader.told and robot.registered)]
            if time.monotonic() > deadline_s:
                raise RuntimeError(f"{waiting[0].name} is not connected after {_CONNECT_S:g} s")
        self._begun_s = self._registered_s = time.monotonic()
        for robot in self._robots:
            robot.heard_s = self._begun_s

    def drive(self, told: Callable[[], bool]) -> None:
        """Sends and hears until `told`."""
        while not told():
            until_s = time.monotonic() + 0.1
            while time.monotonic() < until_s:
                self._hear(_SLICE_S)
                self._send_due()

    def _send_due(self) -> None:
        now_s, robots = time.monotonic(), self._robots
        due = int((now_s - self._begun_s) * STATUS_RATE_HZ * len(robots))
        while self._next_status < due:
            robot = robots[self._next_status % len(robots)]
            robot.udp.send(robot.reporter.datagram(time.time_ns()))
            self._next_status += 1
            self._sent += 1
        due = int((now_s - self._registered_s) / self._again_s * len(robots))
        while self._next_registration < due:
            robot = robots[self._next_registration % len(robots)]
            if robot.registering is None:
                self._register(robot)
            self._next_registration += 1

    def _hear(self, timeout_s: float) -> None:
        for descriptor, _ in self._epoll.poll(timeout_s):
            hear = self._by_socket.get(descriptor)
            if hear is not None:
                hear()
        while self._later and self._later[0][0] <= time.monotonic():
            self._later.popleft()[1]()

    def _connected(self, name: str, count: int) -> _Robot:
        udp = socket.socket(type=socket.SOCK_DGRAM)
        udp.bind((_HOST, 0))
        number = len(self._robots)
        reporter = Reporter(name, *place(number, count), self._load.key, Sequencer(time.time_ns()).next())
        robot = _Robot(name, self._load.tokens[name], reporter, udp)
        self._follow(robot)
        self._register(robot)
        self._robots.append(robot)
        return robot

    def _follow(self, robot: _Robot) -> None:
        """Opens its stream of commands."""
        robot.stream, robot.reader = self._opened(), CommandReader()
        self._watch(robot.stream, lambda: self._hear_stream(robot))
        robot.stream.sendall(_request("GET", robot.name, "commands", robot.token))

    def _register(self, robot: _Robot) -> None:
        """On a connection of its own: the server closes one that was silent for as long as registrations are apart."""
        body = b'{"kind":"wifibot","udp_port":%d,"session":"bench"}' % robot.udp.getsockname()[1]
        robot.registering, robot.answer = self._opened(), b""
        self._watch(robot.registering, lambda: self._hear_answer(robot))
        robot.registering.sendall(_request("POST", robot.name, "registration", robot.token, body))
        self._registrations += 1

    def _opened(self) -> socket.socket:
        return socket.create_connection((_HOST, self._load.http_port), _CONNECT_S)

    def _watch(self, opened: socket.socket, hear: Callable[[], None]) -> None:
        self._by_socket[opened.fileno()] = hear
        self._epoll.register(opened, select.EPOLLIN)

    def _dropped(self, opened: socket.socket, again: Callable[[], None] | None) -> None:
        """Closes it; what comes `again` comes in a moment."""
        del self._by_socket[opened.fileno()]
        self._epoll.unregister(opened)
        opened.close()
        if again is not None:
            self._refused += 1
            self._later.append((time.monotonic() + _RETRY_S, again))

    def _hear_stream(self, robot: _Robot) -> None:
        assert robot.stream is not None
        data = _received(robot.stream)
        if not data or data.startswith(b"HTTP/1.1 5"):
            self._dropped(robot.stream, lambda: self._follow(robot))
            return
        orders = robot.reader.take(data)
        if not orders:
            return
        now_ns, now_s = time.time_ns(), time.monotonic()
        for order in orders:
            self._command_ms.append((now_ns - order.stamp_ns) / 1e6)
        newest = orders[-1]
        if now_s - robot.heard_s > COMMAND_LIMIT_S or now_ns > newest.deadline_ns:
            self._starved += 1
        robot.heard_s = now_s
        robot.reporter.order, robot.reporter.heard_ns = newest, now_ns

    def _hear_answer(self, robot: _Robot) -> None:
        assert robot.registering is not None
        data = _received(robot.registering)
        robot.answer += data
        found = _WELCOME.search(robot.answer)
        if found is None and data and not robot.answer.startswith(b"HTTP/1.1 5"):
            return
        again = None if found is not None or robot.registered else lambda: self._register(robot)
        self._dropped(robot.registering, again)
        robot.registering = None
        if found is None and robot.registered:
            self._refused += 1
        elif found is not None and not robot.registered:
            robot.udp.connect((_HOST, int(found[1])))
            robot.registered = True
            self._again_s = float(found[2])


def _received(opened: socket.socket) -> bytes:
    """Empty when the server has closed it."""
    try:
        return opened.recv(_PIECE)
    except ConnectionResetError:
        return b""


def _request(method: str, robot: str, what: str, token: str, body: bytes = b"") -> bytes:
    head = f"{method} /api/robots/{robot}/{what} HTTP/1.1\r\nHost: {_HOST}\r\nAuthorization: Bearer {token}\r\n"
    if body:
        head += f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n"
    return head.encode() + b"\r\n" + body
