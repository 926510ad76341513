"""The ways to the server one by one: backoff, the queue of responses, statuses that do not fit."""

import asyncio
import logging

import httpx
import pytest

from agents.link import Introduction, Registrar, ResponseQueue, RobotSocket, Welcome, bind_host, server_host
from agents.link.backoff import Backoff, Trouble
from agents.link.responses import CAPACITY
from protocol.clock import SimulatedClock, SystemClock
from protocol.codec import decode
from protocol.datagram import TRACKER, Datagram, pack, unpack
from protocol.messages import Movement, Outcome, Reason, ReasonCode, Response, Status, TrackedPose
from tests.agents.waiting import until

ROBOT = "wifibot-14"


def response(number: int) -> Response:
    return Response(
        robot=ROBOT,
        command_order=(1, number),
        command_stamp_ns=1,
        stamp_ns=2,
        outcome=Outcome.ACCEPTED,
        movement=Movement.WAITING,
    )


class Answers:
    """Answers requests with the status codes in turn, the last one for ever; 0 means that the connection fails."""

    def __init__(self, *codes: int, body: str = "{}") -> None:
        self.requests: list[httpx.Request] = []
        self._codes = list(codes)
        self._body = body

    def client(self) -> httpx.AsyncClient:
        return httpx.AsyncClient(base_url="http://server", transport=httpx.MockTransport(self._answer))

    def _answer(self, request: httpx.Request) -> httpx.Response:
        self.requests.append(request)
        code = self._codes.pop(0) if len(self._codes) > 1 else self._codes[0]
        if code == 0:
            raise httpx.ConnectError("refused")
        return httpx.Response(code, text=self._body)

    def delivered(self) -> list[int]:
        return [decode(Response, request.content).command_order[1] for request in self.requests]


def test_backoff_doubles_from_a_tenth_to_two_seconds() -> None:
    backoff = Backoff()
    assert [round(backoff.next_s(), 1) for _ in range(7)] == [0.1, 0.2, 0.4, 0.8, 1.6, 2.0, 2.0]
    backoff.reset()
    assert backoff.next_s() == 0.1


def test_trouble_is_logged_when_it_changes(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    trouble = Trouble(logging.getLogger("test"), "commands")
    for text in ("away", "away", "refused", "refused"):
        trouble.note(text)
    trouble.over()
    trouble.over()
    assert caplog.messages == ["commands: away", "commands: refused", "commands: works again"]


async def test_responses_arrive_in_order_though_attempts_fail() -> None:
    answers, clock = Answers(0, 503, 200), SimulatedClock()
    queue = ResponseQueue(answers.client(), ROBOT, clock)
    task = asyncio.create_task(queue.run())
    for number in range(3):
        queue.put(response(number))
    await clock.advance(1.0)
    task.cancel()
    assert answers.delivered() == [0, 0, 0, 1, 2]
    assert queue.dropped == 0


async def test_a_response_that_the_server_will_never_take_does_not_block_the_others() -> None:
    answers, clock = Answers(422, 200), SimulatedClock()
    queue = ResponseQueue(answers.client(), ROBOT, clock)
    task = asyncio.create_task(queue.run())
    queue.put(response(0))
    queue.put(response(1))
    await clock.advance(1.0)
    task.cancel()
    assert answers.delivered() == [0, 1]
    assert queue.dropped == 1


async def test_a_full_queue_drops_the_oldest_and_counts() -> None:
    answers, clock = Answers(0), SimulatedClock()
    queue = ResponseQueue(answers.client(), ROBOT, clock)
    for number in range(CAPACITY + 10):
        queue.put(response(number))
    assert queue.dropped == 10
    task = asyncio.create_task(queue.run())
    await clock.advance(0.01)
    task.cancel()
    assert answers.delivered() == [10]


async def test_registers_every_five_seconds_and_when_asked() -> None:
    answers, clock = Answers(200, body='{"robots_udp": 2020, "pose_rate_hz": 15, "news": 1}'), SimulatedClock()
    welcomes: list[Welcome] = []

    async def on_welcome(welcome: Welcome) -> None:
        welcomes.append(welcome)

    introduction = Introduction(kind="wifibot", udp_port=4000, session="s")
    registrar = Registrar(answers.client(), ROBOT, introduction, clock, on_welcome)
    task = asyncio.create_task(registrar.run())
    await clock.advance(0.1)
    assert len(answers.requests) == 1
    await clock.advance(5.0)
    assert len(answers.requests) == 2
    registrar.again()
    await clock.advance(0.1)
    assert len(answers.requests) == 3
    task.cancel()
    assert {welcome.robots_udp for welcome in welcomes} == {2020}
    assert answers.requests[0].url.path == "/api/robots/wifibot-14/registration"


@pytest.mark.parametrize(
    ("code", "body", "delay_s"), [(401, "{}", 5.0), (403, "{}", 5.0), (500, "{}", 0.1), (200, '{"robots_udp": 0}', 0.1)]
)
async def test_registration_is_tried_again(code: int, body: str, delay_s: float) -> None:
    answers, clock = Answers(code, body=body), SimulatedClock()

    async def on_welcome(welcome: Welcome) -> None:
        raise AssertionError(welcome)

    introduction = Introduction(kind="wifibot", udp_port=4000, session="s")
    registrar = Registrar(answers.client(), ROBOT, introduction, clock, on_welcome)
    task = asyncio.create_task(registrar.run())
    await clock.advance(delay_s * 0.9)
    assert len(answers.requests) == 1
    await clock.advance(delay_s * 0.2)
    assert len(answers.requests) == 2
    assert registrar.trouble.text
    task.cancel()


class Receiver(asyncio.DatagramProtocol):
    def __init__(self) -> None:
        self.received: list[bytes] = []

    def datagram_received(self, data: bytes, addr: tuple[str | int, int]) -> None:
        self.received.append(data)


async def test_a_status_too_long_for_a_datagram_goes_without_its_texts() -> None:
    receiver = Receiver()
    transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(
        lambda: receiver, local_addr=("127.0.0.1", 0)
    )
    robot_socket = RobotSocket(ROBOT, None, SystemClock(), lambda pose: None)
    await robot_socket.open("127.0.0.1")
    wide = Status(
        robot=ROBOT,
        sequence=1,
        stamp_ns=1,
        linear_mps=0.0,
        angular_radps=0.0,
        faults=("\N{SNOWMAN}" * 120,) * 4,
        stopped_by=Reason(code=ReasonCode.EMERGENCY_STOP, text="\N{SNOWMAN}" * 200),
    )
    robot_socket.send_status(wide)  # nobody said where to yet
    await robot_socket.send_to("127.0.0.1", transport.get_extra_info("sockname")[1])
    assert robot_socket.address == "127.0.0.1"
    robot_socket.send_status(wide)
    await until(lambda: receiver.received, "the status")
    status = unpack(receiver.received[0]).message
    assert isinstance(status, Status)
    assert status.stopped_by == Reason(code=ReasonCode.EMERGENCY_STOP)
    assert status.faults == ()
    robot_socket.close()
    transport.close()
    await asyncio.sleep(0)


def posed(clock: SimulatedClock, sequence: int, *, sender: str = TRACKER, sent_s_ago: float = 0.0) -> bytes:
    """A POSE of the robot, captured just now whatever its envelope says."""
    pose = TrackedPose(
        ROBOT, clock.now_ns(), 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, (1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4), ("cam0",)
    )
    return pack(Datagram(sender, sequence, clock.now_ns() - round(sent_s_ago * 1e9), pose))


def test_poses_count_when_the_tracker_sent_them_just_now() -> None:
    clock, taken = SimulatedClock(), list[TrackedPose]()
    robot_socket = RobotSocket(ROBOT, None, clock, taken.append)
    for data in (
        posed(clock, 1, sent_s_ago=5.0),
        posed(clock, 2, sent_s_ago=-5.0),
        posed(clock, 3, sender="wifibot-15"),
        posed(clock, 4, sender=ROBOT),
    ):
        robot_socket.datagram_received(data, ("127.0.0.1", 9))
    assert taken == []
    assert str(robot_socket.counts) == "0 poses; ignored: 2 unexpected, 1 old, 1 future"
    robot_socket.datagram_received(posed(clock, 1), ("127.0.0.1", 9))
    assert len(taken) == 1, "what was refused does not count as seen"
    assert robot_socket.counts.poses == 1


def test_the_socket_listens_where_poses_come_from() -> None:
    assert bind_host(server_host("http://127.0.0.1:8000")) == "127.0.0.1"
    assert bind_host(server_host("http://localhost:8000")) == "127.0.0.1"
    assert bind_host(server_host("http://[::1]:8000")) == "::1"
    assert bind_host(server_host("https://lab.example")) == "0.0.0.0"
    for wrong in ("lab.example:8000", "ftp://lab", "http://", ""):
        with pytest.raises(ValueError, match="http://HOST:PORT"):
            server_host(wrong)
