"""The script of the guide drives a robot; without the right to, nothing happens."""

import json
import os
import subprocess
import sys

import httpx
import pytest

from tests.e2e.system import ROOT, RunningSystem

ROBOT = "wifibot-14"
SCRIPT = ROOT / "docs/examples/drive.py"


def token(system: RunningSystem, role: str) -> str:
    answer = system.api.post("/tokens", json={"name": f"example-{role}", "role": role})
    assert answer.status_code == 201, answer.text
    return answer.json()["token"]


def run_script(system: RunningSystem, text: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, SCRIPT, ROBOT, "--server", system.url],
        env={**os.environ, "LILLIPUT_TOKEN": text},
        capture_output=True,
        text=True,
        timeout=150,
        check=False,
    )


def test_the_script_is_short_enough_to_read() -> None:
    assert len(SCRIPT.read_text().splitlines()) <= 60


def test_the_script_drives_the_robot_through_every_waypoint(system: RunningSystem) -> None:
    done = run_script(system, token(system, "operator"))
    assert done.returncode == 0, done.stdout + done.stderr
    robot = system.robot(ROBOT)
    assert robot["assignment"]["state"] == "done"
    truth = system.truth(ROBOT)
    assert (truth.x - 1.0) ** 2 + (truth.y - 2.0) ** 2 < 0.2**2


@pytest.mark.parametrize(("text", "status"), [("", 401), ("wrong", 401), ("viewer", 403)])
def test_without_the_right_token_nothing_changes(system: RunningSystem, text: str, status: int) -> None:
    def everything() -> str:
        paths = ("/waypoints", "/routes")
        parts = [system.api.get(path).raise_for_status().json() for path in paths]
        return json.dumps([parts, system.robot(ROBOT)["assignment"]], sort_keys=True)

    before = everything()
    secret = token(system, "viewer") if text == "viewer" else text
    done = run_script(system, secret)
    assert done.returncode != 0
    assert str(status) in done.stderr
    headers = {"Authorization": f"Bearer {secret}"} if secret else {}
    answer = httpx.put(f"{system.url}/api/robots/{ROBOT}/assignment", json={"route": "square"}, headers=headers)
    assert answer.status_code == status
    assert everything() == before
