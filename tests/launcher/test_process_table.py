"""The process table: what a lab needs, and how it is chosen from."""

from dataclasses import replace
from pathlib import Path

import pytest

from launcher.environment import SystemSettings, child_environment, child_spec, server_url
from launcher.errors import UsageError
from launcher.paths import DEFAULT_LAB, PYTHON, ROOT
from launcher.processes import PROCESSES, expand, select
from protocol.channels import CHANNELS
from protocol.lab import Lab, Ros2Output, load_lab
from protocol.settings import Settings

SETTINGS = SystemSettings(
    lab=Path("/labs/a.yaml"),
    state=Path("/state"),
    redis_url="redis://r",
    host="127.0.0.1",
    http_port=8123,
    server_url="http://127.0.0.1:8123",
    udp_key="ab" * 32,
)


@pytest.fixture
def lab() -> Lab:
    return load_lab(DEFAULT_LAB)


def test_a_lab_gets_a_process_per_camera_and_simulated_vehicle(lab: Lab) -> None:
    processes = {process.name: process for process in expand(lab)}
    assert processes["camera-cam0"].argv == ("-m", "localization.camera", "cam0")
    assert {name for name in processes if name.startswith("camera-")} == {f"camera-{c.id}" for c in lab.cameras}
    assert {p.id for p in processes.values() if p.kind.name == "agent"} == {v.id for v in lab.vehicles}
    assert len(processes) == len(expand(lab)), "names are unique"


def test_without_anything_simulated_there_is_no_lab_process_and_no_agent(lab: Lab) -> None:
    real = lab.model_copy(
        update={
            "cameras": tuple(camera.model_copy(update={"source": "rtsp://c"}) for camera in lab.cameras),
            "vehicles": tuple(vehicle.model_copy(update={"driver": "ros2"}) for vehicle in lab.vehicles),
        }
    )
    kinds = {process.kind.name for process in expand(real)}
    assert {"lab", "agent"}.isdisjoint(kinds)
    assert {"camera", "tracker", "server"} <= kinds


def test_a_gpss_robot_gets_the_adapter_instead_of_an_agent_and_ros_poses_their_bridge(lab: Lab) -> None:
    assert {"gpss", "ros2"}.isdisjoint(process.kind.name for process in expand(lab))
    first, *others = lab.vehicles
    mixed = lab.model_copy(
        update={
            "vehicles": (first.model_copy(update={"driver": "gpss-redis"}), *others),
            "outputs": lab.outputs.model_copy(update={"ros2": Ros2Output(enabled=True)}),
        }
    )
    names = {process.name for process in expand(mixed)}
    assert {"gpss", "ros2"} <= names
    assert f"agent-{first.id}" not in names
    assert {f"agent-{vehicle.id}" for vehicle in others} <= names


def test_every_channel_is_produced_by_a_process_of_the_table() -> None:
    assert {channel.producer for channel in CHANNELS} <= {kind.name for kind in PROCESSES} | {"launcher"}


def test_processes_are_chosen_by_name_or_kind(lab: Lab) -> None:
    chosen = select(expand(lab), {"camera", "agent-wifibot-14"})
    assert [process.name for process in chosen] == [*(f"camera-{c.id}" for c in lab.cameras), "agent-wifibot-14"]


def test_an_unknown_name_is_refused_with_those_that_exist(lab: Lab) -> None:
    with pytest.raises(
        UsageError, match=r"no process is called camera-cam9, trakcer; this lab has redis, .*camera-cam0"
    ):
        select(expand(lab), {"camera-cam9", "trakcer", "server"})


def test_children_are_told_everything_through_their_environment(lab: Lab) -> None:
    agent = next(process for process in expand(lab) if process.kind.needs_token)
    spec = child_spec(agent, SETTINGS, token="t")
    assert spec.argv == (PYTHON, "-P", "-m", "agents", agent.id)
    expected = {
        "LILLIPUT_LAB": "/labs/a.yaml",
        "LILLIPUT_STATE": "/state",
        "LILLIPUT_HOST": "127.0.0.1",
        "LILLIPUT_HTTP_PORT": "8123",
        "LILLIPUT_SERVER": "http://127.0.0.1:8123",
        "LILLIPUT_UDP_KEY": "ab" * 32,
        "LILLIPUT_TOKEN": "t",
        "REDIS_URL": "redis://r",
        "OMP_NUM_THREADS": "1",
        "OPENCV_FOR_THREADS_NUM": "1",
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONPATH": str(ROOT),
    }
    assert expected.items() <= dict(spec.environment).items()


def test_a_token_in_the_environment_does_not_leak_to_processes_without_one() -> None:
    environment = child_environment(SETTINGS, token="", base={"LILLIPUT_TOKEN": "somebody's", "HOME": "/h"})
    assert "LILLIPUT_TOKEN" not in environment
    assert environment["HOME"] == "/h"


@pytest.mark.parametrize(
    ("host", "url"),
    [
        ("127.0.0.1", "http://127.0.0.1:1"),
        ("0.0.0.0", "http://127.0.0.1:1"),
        ("::", "http://[::1]:1"),
        ("fe80::1", "http://[fe80::1]:1"),
    ],
)
def test_agents_find_the_server_by_an_address_that_it_binds(host: str, url: str) -> None:
    assert server_url(host, 1) == url


def test_processes_started_together_share_a_run() -> None:
    together = child_environment(replace(SETTINGS, run="20251124T082145Z"), token="", base={})
    assert Settings.from_environment(together).run == "20251124T082145Z"
    assert "LILLIPUT_RUN" not in child_environment(SETTINGS, token="", base={})
    assert child_environment(SETTINGS, token="", base={"LILLIPUT_RUN": "given"})["LILLIPUT_RUN"] == "given"
