"""The shell script, on a small project of its own: any working directory, once and again, clean stdout, clear refusals."""

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from launcher.paths import PYTHON, ROOT

PROJECT = """[project]
name = "small"
version = "0.1.0"
requires-python = ">=3.11"
[tool.uv]
package = false
"""
LOCK = """version = 1
revision = 3
requires-python = ">=3.11"

[[package]]
name = "small"
version = "0.1.0"
source = { virtual = "." }
"""
SHOW = """import json, os, sys
print(json.dumps({"argv": sys.argv[1:], "cwd": os.getcwd(), "prefix": sys.prefix, "safe": sys.flags.safe_path}))
sys.exit(7)
"""


def environment(**changes: str) -> dict[str, str]:
    """With `uv` on the PATH, so that no test needs a network; no trace of the environment that runs the tests."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("VIRTUAL_ENV", "PYTHON", "UV_"))}
    return {**kept, "PATH": f"{Path(PYTHON).parent}:{kept['PATH']}", **changes}


def start(script: Path | str, *arguments: str, cwd: Path, **changes: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(script), *arguments], cwd=cwd, env=environment(**changes), capture_output=True, text=True, timeout=120
    )


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with a space in its name, holding the script and a launcher that tells what it was given."""
    root = tmp_path / "a project"
    (root / "launcher").mkdir(parents=True)
    (root / "launcher" / "__init__.py").write_text("")
    (root / "launcher" / "__main__.py").write_text(SHOW)
    (root / "pyproject.toml").write_text(PROJECT)
    (root / "uv.lock").write_text(LOCK)
    shutil.copy(ROOT / "lilliput", root / "lilliput")
    return root


def test_the_first_start_tells_what_it_does_and_the_second_says_nothing(project: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "json.py").write_text("raise SystemExit('a file of the working directory was imported')")
    first = start(project / "lilliput", "up", "--lab", "my lab.yaml", "", cwd=elsewhere)
    assert first.returncode == 7
    expected = {"argv": ["up", "--lab", "my lab.yaml", ""], "cwd": str(elsewhere), "prefix": str(project / ".venv")}
    assert {**expected, "safe": True}.items() == json.loads(first.stdout).items()
    assert "making a Python environment" in first.stderr
    assert "installing the locked dependencies" in first.stderr

    began = time.monotonic()
    second = start(project / "lilliput", cwd=elsewhere)
    assert time.monotonic() - began < 3.0
    assert second.stderr == ""
    assert second.returncode == 7


def test_it_works_through_links_and_by_relative_paths(project: Path, tmp_path: Path) -> None:
    start(project / "lilliput", cwd=tmp_path)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "one").symlink_to(project / "lilliput")
    (tmp_path / "bin" / "two").symlink_to("one")
    for run in (
        start(tmp_path / "bin" / "two", cwd=tmp_path),
        start("./lilliput", cwd=project),
        start("../a project/lilliput", cwd=tmp_path / "bin"),
    ):
        assert (run.returncode, run.stderr) == (7, "")


def test_changed_dependencies_are_synced_again_and_a_moved_folder_is_made_anew(project: Path, tmp_path: Path) -> None:
    start(project / "lilliput", cwd=tmp_path)
    (project / "pyproject.toml").write_text(PROJECT + "# changed\n")
    changed = start(project / "lilliput", cwd=tmp_path)
    assert "installing the locked dependencies" in changed.stderr
    assert "making a Python environment" not in changed.stderr

    moved = project.rename(tmp_path / "moved")
    again = start(moved / "lilliput", cwd=tmp_path)
    assert "belongs to another folder" in again.stderr
    assert again.returncode == 7
    assert str(moved / ".venv") in again.stdout


def test_two_first_starts_at_once_prepare_once(project: Path) -> None:
    both = [
        subprocess.Popen(
            [str(project / "lilliput")],
            env=environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    said = [process.communicate(timeout=120) for process in both]
    assert [process.returncode for process in both] == [7, 7]
    assert sum(stderr.count("installing the locked dependencies") for _, stderr in said) == 1


def test_a_failed_sync_is_said_and_tried_again(project: Path, tmp_path: Path) -> None:
    (project / "uv.lock").write_text("not a lock file")
    failed = start(project / "lilliput", cwd=tmp_path)
    assert failed.returncode == 1
    assert "could not install the dependencies" in failed.stderr
    assert failed.stdout == ""
    (project / "uv.lock").write_text(LOCK)
    assert start(project / "lilliput", cwd=tmp_path).returncode == 7


@pytest.fixture
def tools(tmp_path: Path) -> Path:
    """A PATH with the usual commands and no Python."""
    folder = tmp_path / "tools"
    folder.mkdir()
    for name in ("sh", "cat", "cksum", "dirname", "readlink", "awk", "head", "mv", "rm", "env"):
        found = shutil.which(name)
        assert found is not None
        (folder / name).symlink_to(found)
    return folder


def test_without_python_it_says_what_to_install(project: Path, tools: Path) -> None:
    refused = start(project / "lilliput", cwd=project, PATH=str(tools))
    assert refused.returncode == 1
    assert "there is no python3; install it (Debian: apt-get install python3 python3-venv)" in refused.stderr
    assert not (project / ".venv").exists()


def test_an_old_python_is_named_with_its_version(project: Path, tools: Path) -> None:
    old = tools / "python3"
    old.write_text('#!/bin/sh\ncase "$*" in *platform*) echo 3.9.2 ;; *) exit 1 ;; esac\n')
    old.chmod(0o755)
    refused = start(project / "lilliput", cwd=project, PATH=str(tools))
    assert refused.returncode == 1
    assert "Python 3.11 or newer is needed, but python3 is 3.9.2" in refused.stderr


def test_a_python_without_venv_is_named(project: Path, tools: Path) -> None:
    bare = tools / "python3"
    real = Path(sys.base_prefix) / "bin" / "python3"
    bare.write_text(f'#!/bin/sh\ncase "$*" in *ensurepip*) exit 1 ;; esac\nexec "{real}" "$@"\n')
    bare.chmod(0o755)
    refused = start(project / "lilliput", cwd=project, PATH=str(tools))
    assert refused.returncode == 1
    assert "no venv or ensurepip module" in refused.stderr
    assert "apt-get install python3-venv" in refused.stderr
