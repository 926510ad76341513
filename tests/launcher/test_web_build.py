"""Building the console: when its sources changed and only then, with whichever Node.js there is."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher import node as node_module
from launcher.errors import LauncherError
from launcher.node import Node, find_node
from launcher.paths import ROOT
from launcher.web_build import build_web, hash_sources, install_packages

PACKAGE = {
    "name": "small",
    "version": "1.0.0",
    "private": True,
    "scripts": {"build": "node build.mjs"},
}
LOCK = {
    "name": "small",
    "version": "1.0.0",
    "lockfileVersion": 3,
    "packages": {"": {"name": "small", "version": "1.0.0"}},
}
BUILD = """import {mkdirSync, appendFileSync, writeFileSync, rmSync, readFileSync} from "node:fs"
appendFileSync("../builds", "x")
rmSync("dist", {recursive: true, force: true})
mkdirSync("dist")
writeFileSync("dist/index.html", readFileSync("index.html"))
"""


ENDLESS_BUILD = """import {spawn} from "node:child_process"
import {renameSync, writeFileSync} from "node:fs"
const child = spawn("sleep", ["300"])
writeFileSync("../pids.part", `${process.ppid} ${process.pid} ${child.pid}`)
renameSync("../pids.part", "../pids")
"""


@pytest.fixture
def web(tmp_path: Path) -> Path:
    folder = tmp_path / "web"
    (folder / "src").mkdir(parents=True)
    (folder / "package.json").write_text(json.dumps(PACKAGE))
    (folder / "package-lock.json").write_text(json.dumps(LOCK))
    (folder / "build.mjs").write_text(BUILD)
    (folder / "index.html").write_text("<p>1</p>")
    return folder


def builds(web: Path) -> int:
    path = web.parent / "builds"
    return len(path.read_text()) if path.exists() else 0


def test_it_is_built_once_and_again_when_a_source_changed(web: Path) -> None:
    told: list[str] = []
    assert build_web(web, told.append)
    assert any(line.startswith("building the console") for line in told)
    told.clear()
    assert build_web(web, told.append)
    assert (builds(web), told) == (1, [])
    (web / "index.html").write_text("<p>2</p>")
    build_web(web, told.append)
    assert builds(web) == 2
    assert (web / "dist" / "index.html").read_text() == "<p>2</p>"
    assert not any("packages" in line for line in told), "the packages did not change"


def test_it_is_built_again_when_the_result_is_gone(web: Path) -> None:
    build_web(web, lambda line: None)
    shutil.rmtree(web / "dist")
    build_web(web, lambda line: None)
    assert builds(web) == 2


def test_a_failed_build_says_why_and_is_tried_again(web: Path) -> None:
    (web / "build.mjs").write_text("throw new Error('no such import')")
    for _ in range(2):
        with pytest.raises(LauncherError, match="building the console failed") as failed:
            build_web(web, lambda line: None)
        assert "no such import" in str(failed.value)


@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGTERM, 128 + signal.SIGTERM), (signal.SIGINT, -signal.SIGINT)]
)
def test_an_interrupted_build_leaves_no_process_behind(web: Path, number: signal.Signals, status: int) -> None:
    (web / "build.mjs").write_text(ENDLESS_BUILD)
    program = "import sys, pathlib, launcher.web_build as w; w.build_web(pathlib.Path(sys.argv[1]), print)"
    building = subprocess.Popen(
        [sys.executable, "-c", program, web], cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    pids = web.parent / "pids"
    eventually(pids.exists, "the build began")
    running = [int(pid) for pid in pids.read_text().split()]
    assert all(map(alive, running))
    building.send_signal(number)
    assert building.wait(20) == status
    eventually(lambda: not any(map(alive, running)), "npm, node and what they started have ended")


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def eventually(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < deadline, f"not in time: {what}"
        time.sleep(0.02)


def test_a_build_that_leaves_nothing_is_said(web: Path) -> None:
    (web / "build.mjs").write_text("")
    with pytest.raises(LauncherError, match=r"no web/dist/index\.html"):
        build_web(web, lambda line: None)


def test_without_a_console_it_says_so(tmp_path: Path) -> None:
    told: list[str] = []
    assert not build_web(tmp_path, told.append)
    assert told == ["no console to build: web/package.json is missing"]


def test_without_a_lock_file_nothing_is_installed(web: Path) -> None:
    (web / "package-lock.json").unlink()
    with pytest.raises(LauncherError, match=r"package-lock\.json is missing"):
        install_packages(web, lambda line: None)


def test_the_hash_is_of_names_and_contents_of_sources_alone(web: Path) -> None:
    first = hash_sources(web)
    (web / "node_modules").mkdir()
    (web / "node_modules" / "x.js").write_text("1")
    (web / "dist").mkdir()
    assert hash_sources(web) == first
    (web / "src" / "a.ts").write_text("1")
    second = hash_sources(web)
    (web / "src" / "a.ts").rename(web / "src" / "b.ts")
    assert len({first, second, hash_sources(web)}) == 3


def test_the_environments_own_node_serves_when_the_machine_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/no/such/folder")
    node = find_node()
    assert node.folder.name == "node"
    monkeypatch.setenv("PATH", "/usr/bin:/bin")
    for argv in (node.npm("--version"), [str(node.folder / "npx"), "--version"], ["node", "--version"]):
        done = subprocess.run(argv, env=node.environment(), capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == f"v{node.version}", "the scripts that npm starts find the same Node.js"


def test_an_old_node_is_passed_over(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name, says in (("node", "v18.20.4"), ("npm", "10.0.0")):
        (tmp_path / name).write_text(f"#!/bin/sh\necho {says}\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}/bin")
    assert find_node().folder != tmp_path
    monkeypatch.setattr(node_module, "_wheel_folder", lambda: None)
    with pytest.raises(LauncherError, match=r"needs Node\.js 20\.19 or newer"):
        find_node()


def test_node_is_first_on_the_path() -> None:
    assert Node(Path("/n"), "20.19.0").environment()["PATH"].startswith("/n:")
