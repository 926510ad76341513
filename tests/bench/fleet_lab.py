"""A lab for many robots: a hall of theirs, one per square metre and a half, on ports that are free."""

import json
import math
import socket
from pathlib import Path

import yaml

from launcher.paths import DEFAULT_LAB
from protocol.lab import Lab, load_lab

_PITCH_M = 1.5
AREA = "hall"


def write_fleet_lab(folder: Path, robots: int) -> tuple[Path, Lab]:
    """A lab file with that many robots of the reports' first kind, without cameras, and what it says. ValueError for none."""
    if robots < 1:
        raise ValueError(f"a fleet has at least one robot, not {robots}")
    first = load_lab(DEFAULT_LAB).vehicles[0]
    model = first.model_dump(mode="json", exclude_none=True, exclude={"id", "tag"})
    width = _PITCH_M * math.ceil(math.sqrt(robots))
    http, robots_udp, scene = _free_ports(3)
    lab = {
        "name": "fleet",
        "areas": [{"id": AREA, "outline": [[0.0, 0.0], [width, 0.0], [width, width], [0.0, width]]}],
        "floor_tags": {"size_m": 0.16, "poses": {}},
        "ports": {"http": http, "robots_udp": robots_udp, "scene": scene},
    }
    # The rest by hand: what all robots share is written once, as people write lab files, else reading it takes seconds.
    tag = f"size_m: {first.tag.size_m}, height_m: {first.tag.height_m}"
    shared = json.dumps(model)[1:-1]
    vehicles = [f"  - &robot {{id: {_name(0)}, tag: {{id: 0, {tag}}}, {shared}}}"]
    vehicles += [f"  - {{<<: *robot, id: {_name(n)}, tag: {{id: {n}, {tag}}}}}" for n in range(1, robots)]
    path = folder / "fleet.yaml"
    path.write_text(yaml.safe_dump(lab) + "\n".join(["vehicles:", *vehicles, ""]))
    return path, load_lab(path)


def _name(number: int) -> str:
    return f"robot-{number:04d}"


def place(number: int, robots: int) -> tuple[float, float]:
    """Where in the hall a robot stands (m)."""
    row, column = divmod(number, math.ceil(math.sqrt(robots)))
    return _PITCH_M * (column + 0.5), _PITCH_M * (row + 0.5)


def _free_ports(count: int) -> list[int]:
    """Free for TCP and for UDP at this moment."""
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
            numbers.append(int(tcp.getsockname()[1]))
    finally:
        for one in taken:
            one.close()
    return numbers
