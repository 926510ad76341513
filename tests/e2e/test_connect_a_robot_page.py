"""docs/connect-a-robot.md is true: its three robots, described by its own YAML and let in by its own commands, drive routes in
one running system: one over HTTP and UDP, one that knows only Redis and the report's JSON, one that knows only ROS 2's topics."""

import ast
import contextlib
import math
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import redis
import yaml
from cyclonedds.domain import DomainParticipant
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from redis.backoff import NoBackoff
from redis.retry import Retry

from launcher.redis_server import private_url, socket_path
from tests.e2e.system import ROOT, RunningSystem, free_ports, running_system, wait_for
from tests.loopback_dds import domain_of_this_run, stay_on_loopback
from tests.ros2_types import RELIABLE, StampedPose

PAGE = (ROOT / "docs/connect-a-robot.md").read_text()
UDP, GPSS, ROS = "my-robot", "my-agv", "my-ros-robot"
LANES = {UDP: 0.45, GPSS: 1.15, ROS: 1.85}
START_X, END_X = 0.6, 2.0
NEEDED = "server,intake,guidance,camera,tracker,calibrator,mapper,gpss,ros2"


def page_yaml() -> dict[str, Any]:
    """The page's YAML, all of it, as one lab file's part."""
    merged: dict[str, Any] = {"vehicles": []}
    for text in re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL):
        part = yaml.safe_load(text)
        if isinstance(part, list):
            merged["vehicles"] += part
        else:
            merged |= part
    return merged


def command_of_page(beginning: str) -> list[str]:
    """The words of the page's command line that begins so."""
    (line,) = {line.strip() for line in PAGE.splitlines() if line.strip().startswith(beginning)}
    return shlex.split(line)


def describe(folder: Path) -> tuple[Path, Path, int]:
    """The lab with the page's robots; the same for the simulated lab, which moves all of them; the latter's port."""
    http, robots_udp, scene, lab_udp, redis_port = free_ports(5)
    page = page_yaml()
    lab: dict[str, Any] = {
        "name": "ways-in",
        "areas": [{"id": "camp", "outline": [[-0.1, -0.1], [2.9, -0.1], [2.9, 2.4], [-0.1, 2.4]]}],
        "cameras": [
            {
                "id": "cam0",
                "area": "camp",
                "source": "sim",
                "width": 960,
                "height": 720,
                "rate_hz": 10,
                "intrinsics": {"fx": 640.0, "fy": 640.0, "cx": 480.0, "cy": 360.0},
            }
        ],
        "floor_tags": {
            "size_m": 0.16,
            "poses": {0: [0.0, 0.0, 0.0], 1: [2.7, 0.0, 0.0], 2: [0.0, 2.3, 0.0], 3: [2.7, 2.3, 0.0]},
        },
        "vehicles": page["vehicles"],
        "outputs": {"ros2": {**page["outputs"]["ros2"], "domain": domain_of_this_run()}},
        "ports": {
            "http": http,
            "robots_udp": robots_udp,
            "scene": scene,
            "lab_udp": lab_udp,
            **{name: redis_port for name in page["ports"] if name == "redis"},
        },
        "simulation": {
            "mounts": {"cam0": {"position": [1.4, 1.15, 3.0]}},
            "starts": {robot: [START_X, y, 0.0] for robot, y in LANES.items()},
        },
    }
    for vehicle in lab["vehicles"]:
        if "ros2" in vehicle:
            vehicle["ros2"]["domain"] = domain_of_this_run()
    described, moved = folder / "lab.yaml", folder / "simulated.yaml"
    described.write_text(yaml.safe_dump(lab))
    lab["vehicles"] = [
        {key: value for key, value in vehicle.items() if key != "ros2"} | {"driver": "sim"}
        for vehicle in lab["vehicles"]
    ]
    moved.write_text(yaml.safe_dump(lab))
    return described, moved, lab_udp


@dataclass
class WaysIn:
    """The running system, and how to run programs beside it."""

    system: RunningSystem
    lab: Path
    environment: dict[str, str]

    def lilliput(self, words: Sequence[str]) -> str:
        done = subprocess.run(
            [ROOT / "lilliput", *words, "--lab", self.lab, "--state", self.system.state],
            capture_output=True,
            text=True,
            env={name: value for name, value in os.environ.items() if name != "REDIS_URL"},
            timeout=60,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    @contextlib.contextmanager
    def program(self, *words: str, **environment: str) -> Generator[subprocess.Popen[bytes]]:
        process = subprocess.Popen(
            [sys.executable, *words], cwd=ROOT, env={**os.environ, **self.environment, **environment}
        )
        try:
            yield process
            assert process.poll() is None, f"{words} ended with {process.returncode}"
        finally:
            process.terminate()
            process.wait(10)

    def drive(self, robot: str) -> None:
        """Gives it a route along its lane."""
        y = LANES[robot]
        for name, x in ((f"{robot}-a", 1.3), (f"{robot}-b", END_X)):
            waypoint = {"id": name, "area": "camp", "x": x, "y": y, "radius_m": 0.2}
            self.system.api.put(f"/waypoints/{name}", json=waypoint).raise_for_status()
        legs = [{"waypoint": f"{robot}-{end}", "speed_mps": 0.4} for end in "ab"]
        self.system.api.put(f"/routes/{robot}", json={"id": robot, "legs": legs}).raise_for_status()
        self.system.api.put(f"/robots/{robot}/assignment", json={"route": robot}).raise_for_status()

    def explain(self) -> str:
        """What the console says of the robots, for a test that fails."""
        views = {robot: self.system.robot(robot) for robot in LANES}
        return "; ".join(
            f"{robot}: {view['state']} {view['reason']} {view['assignment']}" for robot, view in views.items()
        )

    @contextlib.contextmanager
    def explained(self) -> Generator[None]:
        try:
            yield
        except AssertionError as error:
            raise AssertionError(f"{error}: {self.explain()}") from error

    def moving(self) -> set[str]:
        return {robot for robot in LANES if abs(self.system.truth(robot).linear_mps) > 0.02}


@pytest.fixture(scope="module")
def ways(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WaysIn]:
    """Everything running, the three robots connected as the page says."""
    stay_on_loopback()
    folder = tmp_path_factory.mktemp("ways")
    described, moved, lab_udp = describe(folder)
    with contextlib.ExitStack() as stack:
        system = stack.enter_context(running_system(folder, described, only=NEEDED, redis_opened=True))
        key = (system.state / "udp.key").read_text().strip()
        ways = WaysIn(
            system,
            described,
            {
                "LILLIPUT_SERVER": system.url,
                "LILLIPUT_UDP_KEY": key,
                "LILLIPUT_LAB": str(described),
                "LILLIPUT_STATE": str(system.state),
                "PYTHONPATH": str(ROOT),
                "LAB_UDP_PORT": str(lab_udp),
            },
        )
        url = private_url(system.state, opened=True)
        stack.enter_context(ways.program("-m", "lab", LILLIPUT_LAB=str(moved), REDIS_URL=url))
        _connect(ways, stack)
        system.wait_until_driving_is_possible()
        yield ways


def _connect(ways: WaysIn, stack: contextlib.ExitStack) -> None:
    token = ways.lilliput(command_of_page("./lilliput token issue my-robot ")[1:])
    example = ("-m", "tests.e2e.example_robot")
    stack.enter_context(ways.program(*example, "docs/examples/udp_robot.py", UDP, LILLIPUT_TOKEN=token))
    user, password = ways.lilliput(command_of_page("./lilliput token redis my-agv")[1:]).split()
    port = yaml.safe_load(ways.lab.read_text())["ports"]["redis"]
    stack.enter_context(
        ways.program(
            *example,
            "docs/examples/gpss_robot.py",
            GPSS,
            GPSS_REDIS=f"redis://{user}:{password}@127.0.0.1:{port}",
            LILLIPUT_UDP_KEY=ways.environment["LILLIPUT_UDP_KEY"],
        )
    )
    token = ways.lilliput(command_of_page("./lilliput token issue my-ros-robot ")[1:])
    domain = str(domain_of_this_run())
    stack.enter_context(ways.program("-m", "tests.e2e.dds_robot", ROS, "my_ros_robot", domain))
    stack.enter_context(ways.program("-m", "agents", ROS, LILLIPUT_TOKEN=token))


def test_all_three_drive_their_routes_and_an_emergency_stop_holds_them(ways: WaysIn) -> None:
    system = ways.system
    for robot in LANES:
        ways.drive(robot)
    with ways.explained():
        wait_for("all three drive", lambda: ways.moving() == LANES.keys())
    system.api.post("/estop", json={"reason": "test"}).raise_for_status()
    wait_for("all three stand", lambda: not ways.moving(), 1.5)
    held = {robot: system.truth(robot).x for robot in LANES}
    time.sleep(0.7)  # longer than any command lives
    assert {robot: system.truth(robot).x for robot in LANES} == pytest.approx(held, abs=0.005)
    assert all(x < END_X - 0.2 for x in held.values())
    system.api.request("DELETE", "/estop", json={"confirm": True}).raise_for_status()

    def states() -> dict[str, str]:
        return {robot: system.robot(robot)["assignment"]["state"] for robot in LANES}

    with ways.explained():
        wait_for("all three arrive", lambda: set(states().values()) == {"done"}, 40.0)
    for robot, y in LANES.items():
        truth = system.truth(robot)
        assert math.hypot(truth.x - END_X, truth.y - y) < 0.25, robot
    for robot in (UDP, GPSS):
        answers = system.get(f"/robots/{robot}/responses?count=100")
        reached = [answer for answer in answers if answer["outcome"] == "reached"]
        assert reached, robot
        assert all(answer["reached_ns"] is None for answer in answers if answer["outcome"] == "accepted")


def test_each_tracked_pose_is_a_ros_topic(ways: WaysIn) -> None:
    participant = DomainParticipant(domain_of_this_run())
    tags = {vehicle["id"]: vehicle["tag"]["id"] for vehicle in page_yaml()["vehicles"]}
    for robot in LANES:
        reader: DataReader[StampedPose] = DataReader(
            participant, Topic(participant, f"rt/robot_{tags[robot]}/pose", StampedPose), qos=RELIABLE
        )
        (message,) = wait_for(f"the pose of {robot}", lambda reader=reader: reader.take(N=1))
        truth, position = ways.system.truth(robot), message.pose.pose.position
        assert message.header.frame_id == "map"
        assert math.hypot(position.x - truth.x, position.y - truth.y) < 0.03


def test_the_gpss_example_is_short_and_knows_nothing_of_ours() -> None:
    text = (ROOT / "docs/examples/gpss_robot.py").read_text()
    assert len(text.splitlines()) < 100
    imported = {
        name.split(".")[0]
        for node in ast.walk(ast.parse(text))
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else []
        )
    }
    assert imported <= sys.stdlib_module_names | {"redis"}


def test_the_page_names_what_there_is() -> None:
    for path in re.findall(r"`((?:docs|agents|protocol|server|localization)/[\w/.]+\.\w+)`", PAGE):
        assert (ROOT / path).exists(), path


def test_redis_lets_nobody_in_without_a_password(ways: WaysIn) -> None:
    port = yaml.safe_load(ways.lab.read_text())["ports"]["redis"]
    addresses: list[dict[str, Any]] = [{"port": port}, {"unix_socket_path": str(socket_path(ways.system.state))}]
    for address in addresses:
        with redis.Redis(**address, retry=Retry(NoBackoff(), 0)) as stranger, pytest.raises(redis.AuthenticationError):
            stranger.ping()


def test_a_gpss_robot_is_let_in_again_when_redis_was_started_anew(ways: WaysIn) -> None:
    system = ways.system
    pid = system.processes()["redis"].pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    killed_ns = time.time_ns()

    def heard() -> bool:
        status = system.robot(GPSS)["status"]
        return status is not None and status["stamp_ns"] > killed_ns

    wait_for("a status of the robot in the new Redis", heard)
