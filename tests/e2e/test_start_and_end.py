"""The command of the README: what it prints, how fast it is, and that Ctrl-C leaves nothing behind."""

import signal
import socket
import time
from pathlib import Path

from protocol.lab import load_lab
from tests.e2e.system import lab_on_free_ports, running_system, wait_for
from tests.e2e.test_kill import alive


def test_ctrl_c_ends_everything_within_five_seconds_and_frees_the_ports(tmp_path: Path) -> None:
    lab_file = lab_on_free_ports(tmp_path)
    ports = load_lab(lab_file).ports
    with running_system(tmp_path, lab_file) as system:
        wait_for("every process runs", lambda: all(p.state == "running" for p in system.processes().values()))
        pids = [state.pid for state in system.processes().values() if state.pid is not None]
        began = time.monotonic()
        system.process.send_signal(signal.SIGINT)
        assert system.process.wait(10) == 0
        assert time.monotonic() - began < 5.0
        assert [pid for pid in pids if alive(pid)] == []
    for number, kind in (
        (ports.http, socket.SOCK_STREAM),
        (ports.scene, socket.SOCK_STREAM),
        (ports.robots_udp, socket.SOCK_DGRAM),
        (ports.lab_udp, socket.SOCK_DGRAM),
    ):
        with socket.socket(type=kind) as probe:
            probe.setsockopt(
                socket.SOL_SOCKET, socket.SO_REUSEADDR, 1
            )  # TIME_WAIT of closed connections is no listener
            probe.bind(("127.0.0.1", number))


def test_the_first_password_is_shown_once(tmp_path: Path) -> None:
    lab_file = lab_on_free_ports(tmp_path)
    with running_system(tmp_path, lab_file, only="server") as system:
        password = system.password
        assert system.api.get("/session").json()["role"] == "admin"
    with running_system(tmp_path, lab_file, password=password, only="server") as again:
        assert again.api.get("/session").json()["role"] == "admin"
        assert not any("Log in as" in line for line in again.output)


def test_a_new_lab_shows_driving_robots_that_take_other_orders_at_once(tmp_path: Path) -> None:
    with running_system(tmp_path, lab_on_free_ports(tmp_path, tours=True, light=True)) as system:
        system.wait_until_driving_is_possible()
        vehicles = [robot["id"] for robot in system.get("/robots")]
        assert len(vehicles) == 4
        for vehicle in vehicles:
            wait_for(f"{vehicle} drives", lambda vehicle=vehicle: abs(system.truth(vehicle).linear_mps) > 0.1, 20)
        body = {"id": "elsewhere", "area": "camp", "x": 2.0, "y": 1.3, "radius_m": 0.2}
        system.api.post("/waypoints", json=body).raise_for_status()
        system.api.post("/routes", json={"id": "elsewhere", "legs": [{"waypoint": "elsewhere"}]}).raise_for_status()
        system.api.put(f"/robots/{vehicles[0]}/assignment", json={"route": "elsewhere"}).raise_for_status()
        wait_for("it is there", lambda: system.robot(vehicles[0])["assignment"]["state"] == "done", 60)
