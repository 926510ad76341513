"""A robot that speaks GPSS over Redis: reads its command and its pose, drives, writes its status and its answers.

    GPSS_REDIS=redis://USER:PASSWORD@10.0.0.5:6380 python docs/examples/gpss_robot.py my-agv

`./lilliput token redis my-agv` makes USER and PASSWORD. Put your motors into `Base`.
"""

import json
import math
import os
import sys
import time

import redis
from redis.backoff import NoBackoff
from redis.retry import Retry

REACHED_M, LOCKED_M, TURN_ABOVE_DEG, GAIN, MOST_RADPS = 0.15, 0.35, 65.0, 0.0095, 1.0  # the report's controller
POSE_LIMIT_MS = 500


class Base:
    """The drive: holds a twist (m/s, rad/s) and says which one it really holds. This one is ideal, and stands nowhere."""

    twist = (0.0, 0.0)

    def drive(self, linear: float, angular: float) -> None:
        self.twist = (linear, angular)


def steer(x: float, y: float, angle: float, command: dict) -> tuple[float, float]:
    """The twist from this pose to the command's target, as the report's controller has it."""
    if command["command"] == "Rotate":
        error = math.remainder(command["final_angle"] - angle, math.tau)
        return 0.0, 0.0 if abs(error) < 0.03 else max(-MOST_RADPS, min(MOST_RADPS, 1.5 * error))
    dx, dy = command["x"] - x, command["y"] - y
    distance = math.hypot(dx, dy)
    error = math.degrees(math.remainder(math.atan2(dy, dx) - angle, math.tau)) if distance > LOCKED_M else 0.0
    if distance < REACHED_M:
        return 0.0, 0.0
    if abs(error) > TURN_ABOVE_DEG:
        return 0.0, math.copysign(MOST_RADPS, error)
    return command["speed"] * min(1.0, distance), max(-MOST_RADPS, min(MOST_RADPS, GAIN * error))


class Robot:
    """`step` it twenty times a second."""

    def __init__(self, name: str, client: redis.Redis, base: Base) -> None:
        self.name, self.redis, self.base, self.obeyed, self.answered = name, client, base, -1, None

    def step(self) -> None:
        now = time.time_ns() // 1_000_000
        command, pose = self.read("command"), self.read("pose")
        twist = where = None
        if pose is not None and now - pose["timestamp"] <= POSE_LIMIT_MS:
            way = self.base.twist[0] * (now - pose["timestamp"]) / 1000  # driven since the camera's picture was taken
            where = pose["x"] + way * math.cos(pose["angle"]), pose["y"] + way * math.sin(pose["angle"]), pose["angle"]
        if command is not None and command["sequence"] >= self.obeyed and now <= command["deadline"]:
            self.obeyed = command["sequence"]
            if command["command"] in ("MoveTo", "Rotate") and where is not None:
                twist = steer(*where, command)
                self.answer(command, now if twist == (0.0, 0.0) else "")
        self.base.drive(*(twist or (0.0, 0.0)))  # no command, an old one, Waiting or NoAction, no pose: stand still
        status = dict(zip(("x", "y", "angle"), where or (None, None, None), strict=True))
        status |= dict(zip(("linear_velocity", "angular_velocity"), self.base.twist, strict=True))
        self.write("status", {**status, "ip": "", "area": None, "timestamp": now})

    def answer(self, command: dict, reached: int | str) -> None:
        """Once per movement, and when its target is reached."""
        if (command["command"], reached == "") != self.answered:
            self.answered = command["command"], reached == ""
            answer = {"command": command["command"], "command_timestamp": command["timestamp"]}
            self.write("response", {**answer, "reached_timestamp": reached})

    def read(self, what: str) -> dict | None:
        return json.loads(self.redis.get(f"gpss:{self.name}:{what}") or "null")

    def write(self, what: str, document: dict) -> None:
        self.redis.set(f"gpss:{self.name}:{what}", json.dumps(document))


def main(base: Base) -> None:
    at_once = Retry(NoBackoff(), 0)  # to fail at once: a call that tries again for seconds would let the base roll on
    robot = Robot(sys.argv[1], redis.Redis.from_url(os.environ["GPSS_REDIS"], socket_timeout=0.2, retry=at_once), base)
    try:
        while True:
            try:
                robot.step()
            except redis.RedisError as error:  # nobody can tell it to stop any more
                base.drive(0.0, 0.0)
                print(error, file=sys.stderr)
            time.sleep(0.05)
    finally:
        base.drive(0.0, 0.0)


if __name__ == "__main__":
    main(Base())
