"""docker-compose.yml and Dockerfile describe the same system as the process table does."""

import re
from typing import Any, cast

import pytest
import yaml

from launcher.paths import DEFAULT_LAB, ROOT
from launcher.processes import REDIS, expand
from launcher.redis_server import redis_argv
from protocol.lab import load_lab
from protocol.settings import Settings

COMPOSE = cast("dict[str, Any]", yaml.safe_load((ROOT / "docker-compose.yml").read_text()))
SERVICES = cast("dict[str, dict[str, Any]]", COMPOSE["services"])
PROCESSES = {process.name: process for process in expand(load_lab(DEFAULT_LAB))}
OURS = sorted(SERVICES.keys() - {REDIS})


def test_there_is_one_service_per_process_of_the_table() -> None:
    assert sorted(SERVICES) == sorted(PROCESSES)


@pytest.mark.parametrize("name", OURS)
def test_a_service_runs_the_process_it_is_named_after(name: str) -> None:
    service = SERVICES[name]
    assert service["command"] == ["run", name]
    assert service["restart"] == PROCESSES[name].kind.restart
    assert REDIS in service["depends_on"]


@pytest.mark.parametrize("name", OURS)
def test_a_service_is_told_what_the_process_needs(name: str) -> None:
    environment = {key: _default(str(value)) for key, value in SERVICES[name]["environment"].items()}
    settings = Settings.from_environment(environment)
    assert settings.lab.name == DEFAULT_LAB.name
    assert settings.redis_url.startswith("redis://")
    mounted = [str(volume).split(":")[1] for volume in SERVICES[name]["volumes"]]
    assert str(settings.state) in mounted, "secrets are shared through the state folder"


def test_redis_keeps_its_data_as_the_private_one_does() -> None:
    command = SERVICES[REDIS]["command"]
    private = redis_argv(ROOT, ROOT)
    for option in ("--appendonly", "--appendfsync", "--save"):
        assert command[command.index(option) + 1] == private[private.index(option) + 1]
    assert any(str(volume).endswith(":/data") for volume in SERVICES[REDIS]["volumes"])
    assert command[command.index("--bind") + 1] == "127.0.0.1"


def test_named_volumes_are_declared() -> None:
    used = {str(volume).split(":")[0] for service in SERVICES.values() for volume in service["volumes"]}
    assert used == set(COMPOSE["volumes"])


def test_the_image_contains_every_package_and_starts_the_launcher() -> None:
    lines = (ROOT / "Dockerfile").read_text().splitlines()
    copied = {line.split()[1] for line in lines if line.startswith("COPY ") and not line.startswith("COPY --")}
    packages = {path.parent.name for path in ROOT.glob("*/__init__.py")}
    assert packages <= copied
    assert "labs" in copied
    assert 'ENTRYPOINT ["/app/.venv/bin/python", "-P", "-m", "launcher"]' in lines
    assert any(line.startswith("USER ") for line in lines), "nothing runs as root"


def test_the_image_is_made_of_official_images_with_the_locked_uv() -> None:
    text = (ROOT / "Dockerfile").read_text()
    images = re.findall(r"^FROM (\S+)|--from=(\S+)", text, re.MULTILINE)
    stages = set(re.findall(r"^FROM \S+ AS (\S+)", text, re.MULTILINE))
    assert {(base or copied).partition(":")[0] for base, copied in images} - stages == {"node", "python"}
    locked = re.search(r'^name = "uv"\nversion = "(.+)"$', (ROOT / "uv.lock").read_text(), re.MULTILINE)
    assert locked is not None
    assert f" uv=={locked[1]}\n" in text


def _default(value: str) -> str:
    """`${NAME:-default}` as compose resolves it when NAME is not set."""
    return value.partition(":-")[2].rstrip("}") if value.startswith("${") else value
