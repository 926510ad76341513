"""`up` as people use it: bad input is refused before anything starts, and nothing is left behind."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

import pytest
import redis

from launcher.paths import DEFAULT_LAB, ROOT
from launcher.redis_server import redis_url, socket_path
from protocol.bus import SyncBus
from protocol.channels import PROCESSES


def environment(**more: str) -> dict[str, str]:
    kept = {key: value for key, value in os.environ.items() if key != "REDIS_URL" and not key.startswith("LILLIPUT_")}
    return {**kept, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1", **more}


def up(*arguments: str, **more: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-P", "-m", "launcher", "up", *arguments],
        env=environment(**more),
        capture_output=True,
        text=True,
        timeout=30,
    )


@contextmanager
def running(state: Path) -> Generator[subprocess.Popen[str]]:
    """A system of Redis alone, which answers."""
    argv = [sys.executable, "-P", "-m", "launcher", "up", "--only", "redis", "--state", str(state)]
    process = subprocess.Popen(argv, env=environment(), stderr=subprocess.PIPE, text=True)
    with process:
        try:
            wait_for_redis(state)
            yield process
        finally:
            process.kill()


def wait_for_redis(state: Path) -> None:
    deadline = time.monotonic() + 20
    client = redis.Redis.from_url(redis_url(socket_path(state)))
    with client:
        while time.monotonic() < deadline:
            try:
                client.ping()
            except redis.ConnectionError:
                time.sleep(0.01)
            else:
                return
    raise AssertionError("Redis did not come up")


def stat(pid: int | str) -> tuple[str, int]:
    """State letter and parent of a process; ("", 0) when there is none."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return "", 0
    return fields[0], int(fields[1])


def children(pid: int) -> list[int]:
    """The processes that a process started."""
    return [int(f.name) for f in Path("/proc").iterdir() if f.name.isdigit() and stat(f.name)[1] == pid]


def wait_until_gone(pids: list[int], limit_s: float) -> None:
    deadline = time.monotonic() + limit_s
    while any(stat(pid)[0] not in ("", "Z") for pid in pids):
        assert time.monotonic() < deadline, "something was left behind"
        time.sleep(0.01)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_everything_within_5_s(tmp_path: Path, number: signal.Signals) -> None:
    with running(tmp_path) as system:
        started = children(system.pid)
        assert started
        start = time.monotonic()
        system.send_signal(number)
        assert system.wait(10) == 0
        assert time.monotonic() - start < 5.0
        wait_until_gone(started, limit_s=0.0)
        assert system.stderr is not None
        assert system.stderr.read().splitlines()[-1] == "everything has ended"
    assert not socket_path(tmp_path).exists()


def test_kill_9_leaves_nothing_behind_and_the_next_start_works(tmp_path: Path) -> None:
    with running(tmp_path) as system:
        started = children(system.pid)
        assert started
        system.kill()
        wait_until_gone(started, limit_s=5.0)
    with running(tmp_path) as system:
        system.send_signal(signal.SIGINT)
        assert system.wait(10) == 0


def test_a_second_system_on_the_same_state_is_refused(tmp_path: Path) -> None:
    with running(tmp_path) as system:
        second = up("--only", "redis", "--state", str(tmp_path))
        assert second.returncode == 2
        assert second.stderr == (
            f"lilliput: a system already runs on {tmp_path} (process {system.pid}): "
            "stop it, or give this one another --state\n"
        )
        assert system.poll() is None
        system.send_signal(signal.SIGTERM)
        system.wait(10)


def test_the_states_of_the_processes_are_on_the_bus_and_redis_is_restarted(tmp_path: Path) -> None:
    with running(tmp_path) as system:
        bus = SyncBus.connect(redis_url(socket_path(tmp_path)))

        def state(restarts: int) -> int:
            deadline = time.monotonic() + 15
            while time.monotonic() < deadline:
                found = bus.latest_all(PROCESSES).get("redis")
                if found and found.pid and found.state == "running" and found.restarts == restarts:
                    return found.pid
                time.sleep(0.01)
            raise AssertionError("not published")

        first = state(restarts=0)
        os.kill(first, signal.SIGKILL)
        assert state(restarts=1) != first
        bus.close()
        system.send_signal(signal.SIGINT)
        assert system.wait(10) == 0
        assert system.stderr is not None
        assert "redis: killed by signal 9 (SIGKILL)" in system.stderr.read()


def test_a_port_in_use_is_named_with_the_way_out(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        refused = up("--http-port", str(port), "--state", str(tmp_path))
    assert refused.returncode == 2
    assert refused.stderr == (
        f"lilliput: TCP port {port} (the console) is in use by another program: give another with --http-port\n"
    )
    assert not (tmp_path / "redis").exists(), "nothing was started"


def test_a_port_of_the_lab_file_in_use_is_named_with_its_key(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        lab = tmp_path / "lab.yaml"
        lab.write_text(f"{without_ports(DEFAULT_LAB.read_text())}\nports: {{lab_udp: {port}}}\n")
        refused = up("--lab", str(lab), "--only", "lab", "--state", str(tmp_path / "state"))
    assert refused.returncode == 2
    assert f"UDP port {port} (the simulated lab) is in use by another program: change ports.lab_udp" in refused.stderr


def without_ports(text: str) -> str:
    """The lab file's text without its ports, which stand on one line."""
    return "\n".join(line for line in text.splitlines() if not line.startswith("ports:"))


def test_a_bad_lab_file_is_refused_with_its_lines(tmp_path: Path) -> None:
    lab = tmp_path / "lab.yaml"
    lab.write_text(
        "name: x\nareas:\n  - {id: a, outline: [[0, 0], [1, 0], [1, 1]], colour: red}\nfloor_tags: {size_m: 1, poses: {}}\n"
    )
    refused = up("--lab", str(lab), "--state", str(tmp_path / "state"))
    assert refused.returncode == 2
    assert f"{lab}:3: areas[0].colour: unknown key" in refused.stderr
    assert not (tmp_path / "state").exists()
    missing = up("--lab", str(tmp_path / "none.yaml"))
    assert missing.returncode == 2
    assert "none.yaml" in missing.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--http-port", "0"], "1 to 65535"),
        (["--http-port", "x"], "--http-port"),
        (["--only", "camera-cam99"], "no process is called camera-cam99"),
        (["--only", ","], "--only needs"),
        (["--host", "203.0.113.1"], "cannot listen on 203.0.113.1"),
    ],
)
def test_bad_arguments_are_refused(tmp_path: Path, arguments: list[str], words: str) -> None:
    refused = up(*arguments, "--state", str(tmp_path))
    assert refused.returncode == 2
    assert words in refused.stderr
    assert "Traceback" not in refused.stderr


def test_a_state_folder_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    blocker = tmp_path / "file"
    blocker.write_text("")
    refused = up("--only", "redis", "--state", str(blocker / "state"))
    assert refused.returncode == 1
    assert "cannot write in the state folder" in refused.stderr


def test_a_bad_datagram_key_is_refused(tmp_path: Path) -> None:
    refused = up("--only", "redis", "--state", str(tmp_path), LILLIPUT_UDP_KEY="secret")
    assert refused.returncode == 2
    assert "LILLIPUT_UDP_KEY must hold at least 32 hexadecimal digits" in refused.stderr


def test_a_redis_of_ones_own_that_is_away_is_said(tmp_path: Path) -> None:
    refused = up("--only", "tracker", "--state", str(tmp_path), REDIS_URL="redis://127.0.0.1:1/0")
    assert refused.returncode == 1
    assert "Redis at redis://127.0.0.1:1/0 does not answer" in refused.stderr
