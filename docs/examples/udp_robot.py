"""A robot that connects over HTTP and UDP without our agent: registers, follows its commands, hears poses, sends statuses.

    LILLIPUT_SERVER=http://10.0.0.5:8000 LILLIPUT_TOKEN=... LILLIPUT_UDP_KEY=... python docs/examples/udp_robot.py my-robot

`./lilliput token issue my-robot --role robot --robot my-robot` makes the token. Put your motors into `Base`.
"""

import contextlib
import hmac
import json
import math
import os
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable
from urllib.parse import urlsplit

import httpx
from gpss_robot import Base, steer

HEADER = struct.Struct(">2sBBBBQQH")  # protocol/datagram.py
POSE, STATUS = 1, 2
LIMIT_NS = 500_000_000


class Robot:
    """The newest of everything that came in, and the loop that obeys it."""

    def __init__(self, name: str, api: httpx.Client, key: bytes) -> None:
        self.name, self.api, self.key = name, api, key
        self.stopped, self.command, self.pose, self.obeyed = True, None, None, (-1, -1)
        self.udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.udp.bind(("", 0))
        self.udp.settimeout(0.05)
        self.sequence, self.answered, self.newest = time.time_ns() // 1000, None, 0

    def register(self) -> None:
        """Every five seconds, or poses are no longer sent."""
        body = {"kind": "turtlebot", "udp_port": self.udp.getsockname()[1], "session": str(self.sequence)}
        while True:
            answer = self.api.post(f"/robots/{self.name}/registration", json=body).raise_for_status().json()
            # Looked up here: without a network that takes seconds, which the loop that drives does not have.
            host = socket.gethostbyname(urlsplit(str(self.api.base_url)).hostname)
            self.server = host, answer["robots_udp"]
            time.sleep(5)

    def follow(self) -> None:
        """Server-sent events: the emergency stop first, then commands; something at least every half second."""
        with self.api.stream("GET", f"/robots/{self.name}/commands", timeout=1.0) as stream:
            stream.raise_for_status()
            kind = ""
            for line in stream.iter_lines():
                name, _, value = line.partition(": ")
                if name == "event":
                    kind = value
                elif name == "data" and kind == "emergency_stop":
                    self.stopped = json.loads(value)["engaged"]
                elif name == "data" and kind == "command":
                    self.command = json.loads(value)

    def hear(self) -> None:
        """Takes the newest pose: signed, from the tracker, this robot's, in order and fresh."""
        data = self.udp.recv(2048)
        _, version, kind, signed, sender, sequence, stamp, size = HEADER.unpack_from(data)
        end = HEADER.size + sender + size
        if (version, kind, signed) != (1, POSE, 1) or data[HEADER.size : HEADER.size + sender] != b"tracker":
            return
        if not hmac.compare_digest(hmac.digest(self.key, data[:end], "sha256"), data[end:]):
            return
        pose = json.loads(data[HEADER.size + sender : end])
        if pose["vehicle"] == self.name and sequence > self.newest and time.time_ns() - stamp < 1_000_000_000:
            self.newest, self.pose = sequence, pose

    def decide(self, base: Base) -> tuple[float, float]:
        """The twist that is allowed now, which is none without a fresh command and a fresh pose."""
        now, command, pose = time.time_ns(), self.command, self.pose
        if self.stopped or command is None or pose is None or now - pose["stamp_ns"] > LIMIT_NS:
            return 0.0, 0.0
        order = command["epoch"], command["sequence"]
        if now > command["deadline_ns"] or order < self.obeyed:
            return 0.0, 0.0
        self.obeyed = order
        if command["movement"] == "Drive":
            return command["linear_mps"], command["angular_radps"]
        if command["movement"] not in ("MoveTo", "Rotate"):
            return 0.0, 0.0
        target = {"x": command["target"]["x"], "y": command["target"]["y"], "final_angle": command["target"]["yaw"]}
        way, yaw = base.twist[0] * (now - pose["stamp_ns"]) / 1e9, pose["yaw"]
        here = pose["x"] + way * math.cos(yaw), pose["y"] + way * math.sin(yaw), yaw
        twist = steer(*here, {**target, "command": command["movement"], "speed": command["speed_mps"]})
        self.answer(command, now if command["final"] and twist == (0.0, 0.0) else None)
        return twist

    def answer(self, command: dict, reached_ns: int | None) -> None:
        told = command["movement"], command["final"], reached_ns is None
        if told == self.answered:
            return
        self.answered = told
        order, now = [command["epoch"], command["sequence"]], time.time_ns()
        answer = {"robot": self.name, "command_order": order, "command_stamp_ns": command["stamp_ns"], "stamp_ns": now}
        answer |= {"movement": command["movement"], "applied_speed_mps": command["speed_mps"], "reached_ns": reached_ns}
        answer["outcome"] = "accepted" if reached_ns is None else "reached"
        threading.Thread(
            target=self.api.post, args=(f"/robots/{self.name}/responses",), kwargs={"json": answer}
        ).start()

    def report(self, base: Base) -> None:
        """A STATUS datagram."""
        pose, now = self.pose or {}, time.time_ns()
        self.sequence += 1
        status = {"robot": self.name, "sequence": self.sequence, "stamp_ns": now, "linear_mps": base.twist[0]}
        status |= {"angular_radps": base.twist[1], "x": pose.get("x"), "y": pose.get("y"), "yaw": pose.get("yaw")}
        text, name = json.dumps(status).encode(), self.name.encode()
        body = HEADER.pack(b"LP", 1, STATUS, 1, len(name), self.sequence, now, len(text)) + name + text
        self.udp.sendto(body + hmac.digest(self.key, body, "sha256"), self.server)


def for_ever(work: Callable[[], None]) -> None:
    """Again after each failure and each end: servers are restarted."""
    while True:
        try:
            work()
        except (httpx.HTTPError, OSError, KeyError, ValueError) as error:
            print(repr(error), file=sys.stderr)
        time.sleep(0.5)


def main(base: Base) -> None:
    headers = {"Authorization": f"Bearer {os.environ['LILLIPUT_TOKEN']}"}
    api = httpx.Client(base_url=f"{os.environ['LILLIPUT_SERVER']}/api", headers=headers, timeout=2.0)
    robot = Robot(sys.argv[1], api, bytes.fromhex(os.environ["LILLIPUT_UDP_KEY"]))
    for work in (robot.register, robot.follow):
        threading.Thread(target=for_ever, args=(work,), daemon=True).start()
    try:
        while True:
            with contextlib.suppress(OSError, ValueError, struct.error):  # silence, or bytes of others
                robot.hear()
            base.drive(*robot.decide(base))
            if hasattr(robot, "server"):
                with contextlib.suppress(OSError):  # no network: what comes in says when to stop
                    robot.report(base)
    finally:  # whatever ends this program, the base does not roll on
        base.drive(0.0, 0.0)


if __name__ == "__main__":
    main(Base())
