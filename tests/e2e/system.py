"""A whole Lilliput under test: `./lilliput up` in a folder of its own, on free ports, with the lab of the reports."""

import os
import re
import shutil
import signal
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar, cast

import httpx
import yaml
from redis import Redis

from launcher.redis_server import private_url
from protocol import keys
from protocol.channels import GROUND_TRUTH, LAB_INSTANCE, PROCESSES
from protocol.codec import decode
from protocol.messages import GroundTruth, ProcessState, TruePose
from protocol.settings import frames_folder

ROOT = Path(__file__).resolve().parents[2]
T = TypeVar("T")


def free_ports(count: int) -> list[int]:
    """Port numbers free for TCP and UDP at this moment."""
    taken: list[socket.socket] = []
    numbers: list[int] = []
    try:
        while len(numbers) < count:
            tcp, udp = socket.socket(), socket.socket(type=socket.SOCK_DGRAM)
            taken += [tcp, udp]
            tcp.bind(("127.0.0.1", 0))
            try:
                udp.bind(tcp.getsockname())
            except OSError:
                continue
            numbers.append(tcp.getsockname()[1])
    finally:
        for one in taken:
            one.close()
    return numbers


def lab_on_free_ports(
    folder: Path, source: Path = ROOT / "labs/gulliver.yaml", *, tours: bool = False, light: bool = False
) -> Path:
    """A copy of a lab file whose ports are free; without tours, so that robots stand still until a test drives them.
    `light` halves the cameras' resolution, has 10 frames a second and scanners that turn 10 times a second, which leaves two
    cores room for a browser beside."""
    lab = yaml.safe_load(source.read_text())
    for camera in lab["cameras"] if light else ():
        lens = camera["intrinsics"]
        camera.update(width=camera["width"] // 2, height=camera["height"] // 2, rate_hz=10)
        halved = {"fx": lens["fx"] / 2, "fy": lens["fy"] / 2, "cx": lens["cx"] / 2 - 0.25, "cy": lens["cy"] / 2 - 0.25}
        camera["intrinsics"] = {**lens, **halved}
    for vehicle in lab["vehicles"] if light else ():
        if "scanner" in vehicle:
            vehicle["scanner"] = {**vehicle["scanner"], "rate_hz": 10}
    lab["ports"] = dict(zip(("http", "robots_udp", "scene", "lab_udp"), free_ports(4), strict=True))
    if not tours:
        del lab["simulation"]["tours"]
    path = folder / "lab.yaml"
    path.write_text(yaml.safe_dump(lab))
    return path


def wait_for(what: str, probe: Callable[[], T | None], timeout_s: float = 20.0) -> T:
    """The first true answer of `probe`; AssertionError naming `what` when there is none in time."""
    deadline = time.monotonic() + timeout_s
    while True:
        answer = probe()
        if answer:
            return answer
        if time.monotonic() > deadline:
            raise AssertionError(f"not within {timeout_s:g} s: {what}")
        time.sleep(0.02)


@dataclass
class RunningSystem:
    """Handles on a running system: its address, password, Redis, and an API client logged in as its admin."""

    process: subprocess.Popen[str]
    state: Path
    url: str
    password: str
    output: list[str]
    redis_opened: bool = False
    api: httpx.Client = field(init=False)
    redis: Redis = field(init=False)

    def __post_init__(self) -> None:
        self.redis = Redis.from_url(private_url(self.state, opened=self.redis_opened))
        self.api = httpx.Client(base_url=f"{self.url}/api", headers={"X-Lilliput": "1"}, timeout=10)
        self.api.post("/session", json={"user": "admin", "password": self.password}).raise_for_status()

    def truth(self, vehicle: str) -> TruePose:
        """Where the vehicle truly is now."""
        raw = cast("bytes | None", self.redis.hget(keys.live(GROUND_TRUTH.name), LAB_INSTANCE))
        assert raw is not None, "the lab has not said anything yet"
        return decode(GroundTruth, raw).vehicles[vehicle]

    def processes(self) -> dict[str, ProcessState]:
        """What the supervisor says of each process."""
        raw = cast("dict[bytes, bytes]", self.redis.hgetall(keys.live(PROCESSES.name)))
        return {name.decode(): decode(ProcessState, data) for name, data in raw.items()}

    def robot(self, vehicle: str) -> dict[str, Any]:
        """The robot as the API shows it."""
        return self.get(f"/robots/{vehicle}")

    def get(self, path: str) -> Any:
        """What the API answers, also when it, or Redis behind it, is just being restarted."""

        def answer() -> httpx.Response | None:
            try:
                response = self.api.get(path)
            except httpx.TransportError:
                return None
            return None if response.status_code == 503 else response

        return wait_for(f"an answer to GET {path}", answer).raise_for_status().json()

    def wait_until_driving_is_possible(self, timeout_s: float = 60.0) -> None:
        """Every robot is online and localized, and the obstacle grid is there."""

        def ready() -> bool:
            robots = cast("list[dict[str, Any]]", self.api.get("/robots").raise_for_status().json())
            fresh = all(r["connection"] == "ONLINE" and r["pose"] and r["pose"]["age_s"] < 0.5 for r in robots)
            return bool(robots) and fresh

        wait_for("all robots online and localized", ready, timeout_s)

    def close(self) -> None:
        self.api.close()
        self.redis.close()


@contextmanager
def running_system(
    folder: Path,
    lab: Path | None = None,
    password: str | None = None,
    *,
    only: str | None = None,
    redis_opened: bool = False,
) -> Generator[RunningSystem]:
    """Starts everything, or `only` some, and waits for the console; ends it afterwards. `lab` None is the reports' room with
    light cameras; `password` is the admin's where the state folder has one already; `redis_opened` when the lab file has
    `ports.redis`."""
    lab = lab or lab_on_free_ports(folder, light=True)
    state = folder / "state"
    environment = {name: value for name, value in os.environ.items() if name not in ("REDIS_URL", "LILLIPUT_LAB")}
    process = subprocess.Popen(
        [ROOT / "lilliput", "up", "--lab", lab, "--state", state, *(("--only", only) if only else ())],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=environment,
        cwd=folder,
    )
    output: list[str] = []
    reader = threading.Thread(target=lambda: output.extend(process.stdout or ()), daemon=True)
    reader.start()
    system: RunningSystem | None = None
    try:
        url = _said(process, output, r"Console:\s+(\S+)")
        password = password or _said(process, output, r"password (\S+)")
        system = RunningSystem(process, state, url, password, output, redis_opened)
        yield system
    finally:
        if system is not None:
            system.close()
        process.send_signal(signal.SIGINT)
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        reader.join(5)
        if process.stdout is not None:
            process.stdout.close()
        shutil.rmtree(frames_folder(state), ignore_errors=True)  # a killed launcher cannot


def _said(process: subprocess.Popen[str], output: list[str], pattern: str, timeout_s: float = 90.0) -> str:
    def find() -> str | None:
        if process.poll() is not None:
            raise AssertionError(f"./lilliput up ended with {process.returncode}:\n{''.join(output)}")
        return next((found[1] for line in output if (found := re.search(pattern, line))), None)

    try:
        return wait_for(f"a line like {pattern!r}", find, timeout_s)
    except AssertionError as error:
        raise AssertionError(f"{error}\n{''.join(output)}") from error
