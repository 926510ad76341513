"""Every process is killed in turn while a route runs: it comes back, nothing configured is lost, no robot moves without a
fresh command, and the route finishes."""

import contextlib
import math
import os
import signal
import threading
import time
from pathlib import Path
from typing import Any, cast

import redis

from protocol import keys
from protocol.channels import COMMANDS, GROUND_TRUTH, LAB_INSTANCE
from protocol.codec import decode
from protocol.messages import Command, GroundTruth, Movement
from tests.e2e.system import RunningSystem, running_system, wait_for

ROBOT = "wifibot-14"
SPEED_MPS = 0.3
DEAD_MAN_S = 0.5
BRAKING_S = 0.7
"""After the dead-man's switch: the base's own delay, 0.8 m/s at 2 m/s^2, and the truth's own rate."""


class Watch:
    """Looks at truth and commands all the time and notes every instant at which a robot moved with no fresh command."""

    def __init__(self, system: RunningSystem) -> None:
        self._redis = system.redis
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._commanded: dict[str, tuple[int, float]] = {}
        self._last: GroundTruth | None = None
        self.violations: list[str] = []
        self.samples = 0

    def __enter__(self) -> "Watch":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join(5)

    def _run(self) -> None:
        while not self._stop.wait(0.02):
            with contextlib.suppress(redis.RedisError):  # it is one of those that are killed
                self._look()

    def _look(self) -> None:
        now = time.monotonic()
        commands = cast("dict[bytes, bytes]", self._redis.hgetall(keys.live(COMMANDS.name)))
        for raw in commands.values():
            command = decode(Command, raw)
            moving = command.movement in (Movement.MOVE_TO, Movement.ROTATE, Movement.DRIVE)
            if moving and self._commanded.get(command.robot, (0, 0.0))[0] != command.stamp_ns:
                self._commanded[command.robot] = (command.stamp_ns, now)
        raw_truth = cast("bytes | None", self._redis.hget(keys.live(GROUND_TRUTH.name), LAB_INSTANCE))
        if raw_truth is None:
            return
        truth = decode(GroundTruth, raw_truth)
        if time.time_ns() - truth.stamp_ns > 0.2e9:
            return  # the lab itself is the one that is down
        self.samples += 1
        before, self._last = self._last, truth
        if before is not None and truth.stamp_ns - before.stamp_ns > 0.5e9:
            self._judge_gap(before, truth)
        for vehicle, pose in truth.vehicles.items():
            idle_s = now - self._commanded.get(vehicle, (0, -math.inf))[1]
            if idle_s > DEAD_MAN_S + BRAKING_S and abs(pose.linear_mps) > 0.02:
                self.violations.append(f"{vehicle} at {pose.linear_mps:.2f} m/s, {idle_s:.2f} s after its last order")

    def _judge_gap(self, before: GroundTruth, after: GroundTruth) -> None:
        """While Redis or the lab was away nobody could be watched: a robot may have rolled on until its dead-man's switch
        stopped it, no farther."""
        for vehicle, pose in before.vehicles.items():
            way_m = math.dist((pose.x, pose.y), (after.vehicles[vehicle].x, after.vehicles[vehicle].y))
            if way_m > SPEED_MPS * (DEAD_MAN_S + BRAKING_S):
                self.violations.append(f"{vehicle} went {way_m:.2f} m while nobody could command it")


def prepare_route(system: RunningSystem) -> None:
    corners = [(1.0, 1.0), (5.8, 1.0), (5.8, 2.2), (1.0, 2.2)]
    for index, (x, y) in enumerate(corners):
        body = {"id": f"kill-{index}", "area": "camp", "x": x, "y": y, "radius_m": 0.2}
        system.api.put(f"/waypoints/kill-{index}", json=body).raise_for_status()
    legs = [{"waypoint": f"kill-{index}", "speed_mps": SPEED_MPS} for index in range(len(corners))]
    system.api.put("/routes/kill", json={"id": "kill", "legs": legs}).raise_for_status()


def configured(system: RunningSystem) -> dict[str, Any]:
    return {path: system.get(path) for path in ("/waypoints", "/routes", "/users")}


def test_killing_each_process_in_turn_loses_nothing_and_the_route_finishes(tmp_path: Path) -> None:
    with running_system(tmp_path) as system:
        system.wait_until_driving_is_possible()
        prepare_route(system)
        before = configured(system)
        system.api.put(f"/robots/{ROBOT}/assignment", json={"route": "kill"}).raise_for_status()
        with Watch(system) as watch:
            for name in sorted(system.processes()):
                wait_for(f"it drives, before {name} is killed", lambda: abs(system.truth(ROBOT).linear_mps) > 0.1, 30)
                kill_and_wait(system, name)
            assert configured(system) == before
            wait_for("the route is done", lambda: system.robot(ROBOT)["assignment"]["state"] == "done", timeout_s=180)
        assert watch.samples > 500
        assert watch.violations == []


def kill_and_wait(system: RunningSystem, name: str) -> None:
    old = system.processes()[name]
    assert old.pid is not None
    os.kill(old.pid, signal.SIGKILL)

    def back() -> bool:
        try:
            new = system.processes().get(name)
        except redis.RedisError:
            return False
        return (
            new is not None
            and new.state == "running"
            and new.pid not in (None, old.pid)
            and new.restarts > old.restarts
        )

    wait_for(f"{name} is restarted", back, timeout_s=20)


def test_killing_the_launcher_itself_leaves_no_process_behind(tmp_path: Path) -> None:
    with running_system(tmp_path) as system:
        pids = [state.pid for state in system.processes().values() if state.pid is not None]
        assert len(pids) > 10
        system.process.kill()
        wait_for("every process is gone", lambda: not any(alive(pid) for pid in pids), timeout_s=5)


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False
