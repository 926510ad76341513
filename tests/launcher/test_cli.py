"""The command line: one line and status 2 for bad use, clean stdout for `--json`, nothing imported that is not needed."""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

from launcher.cli import main
from launcher.commands.test import SHARED, from_root, names_tests
from launcher.errors import LauncherError, UsageError
from launcher.output import Result
from launcher.paths import ROOT
from launcher.processes import PROCESSES
from launcher.registry import COMMANDS, Command
from protocol.version import project_version


def lilliput(*arguments: str, cwd: Path = ROOT, **environment: str) -> subprocess.CompletedProcess[str]:
    """The launcher in a process of its own, without the shell script before it."""
    return subprocess.run(
        [sys.executable, "-P", "-m", "launcher", *arguments],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        text=True,
        timeout=60,
    )


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """A command called `probe` whose `run` a test can replace."""

    def add_arguments(parser: argparse.ArgumentParser) -> None:
        parser.add_argument("--n", type=int)

    def run(arguments: argparse.Namespace) -> int:
        return arguments.n

    module = ModuleType("launcher.commands.probe")
    module.__dict__.update(add_arguments=add_arguments, run=run)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    return module


PROBE = (Command("probe", "for tests"),)


@pytest.mark.usefixtures("command")
def test_the_status_is_the_commands_own() -> None:
    assert main(["probe", "--n", "7"], PROBE) == 7


@pytest.mark.parametrize(
    ("error", "status"), [(LauncherError("no disk; free some"), 1), (UsageError("no such file"), 2)]
)
def test_an_error_is_one_line_on_stderr(
    command: ModuleType, capsys: pytest.CaptureFixture[str], error: LauncherError, status: int
) -> None:
    def fail(arguments: argparse.Namespace) -> int:
        raise error

    command.__dict__["run"] = fail
    assert main(["probe"], PROBE) == status
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == f"lilliput: {error}\n"


@pytest.mark.parametrize("argv", [["nonsense"], ["probe", "--unknown"], ["probe", "--n", "many"], ["probe", "extra"]])
def test_bad_use_is_one_line_that_says_how_to_go_on(
    command: ModuleType, capsys: pytest.CaptureFixture[str], argv: list[str]
) -> None:
    assert main(argv, PROBE) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert "--help" in captured.err


def test_without_a_command_the_help_is_shown_and_the_status_is_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert "usage: lilliput" in capsys.readouterr().out


def test_help_names_every_command_and_imports_none() -> None:
    shown = lilliput("--help")
    assert shown.returncode == 0
    assert all(f" {command.name} " in shown.stdout for command in COMMANDS)
    code = """
import sys
from launcher.cli import main
main(["--help"])
sys.exit(any(name in sys.modules for name in ("cv2", "numpy", "redis", "launcher.commands.up")))
"""
    assert subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(ROOT)}).returncode == 0


@pytest.mark.parametrize("name", [command.name for command in COMMANDS])
def test_every_command_explains_itself(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([name, "--help"]) == 0
    assert name in capsys.readouterr().out


def test_the_help_of_run_lists_the_processes_and_when_there_is_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--help"]) == 0
    shown = [line.split(maxsplit=1) for line in capsys.readouterr().out.partition("processes and when")[2].splitlines()]
    assert ["camera-ID", "one per camera"] in shown
    assert len(shown) == 1 + len(PROCESSES)


def test_the_rest_reaches_a_command_unparsed(command: ModuleType) -> None:
    seen: list[str] = []

    def run(arguments: argparse.Namespace) -> int:
        seen.extend(arguments.rest)
        return 0

    command.__dict__["run"] = run
    assert main(["probe", "-k", "foo", "--", "-x"], (Command("probe", "for tests", takes_rest=True),)) == 0
    assert seen == ["-k", "foo", "--", "-x"]


def test_a_reader_that_goes_away_is_no_crash() -> None:
    shown = subprocess.run(
        f"{sys.executable} -P -m launcher --help | true",
        shell=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert "Traceback" not in shown.stderr


def test_json_output_is_exactly_one_object() -> None:
    result = Result("tracking", {"position_error_median_mm": 3.25}, {"position_error_median_mm": 4.0}, {"seconds": 30})
    assert json.loads(result.as_json()) == {
        "name": "tracking",
        "figures": {"position_error_median_mm": 3.25},
        "published": {"position_error_median_mm": 4.0},
        "settings": {"seconds": 30},
        "version": project_version(),
    }
    with pytest.raises(ValueError, match="JSON"):
        Result("broken", {"error_mm": float("nan")}).as_json()


def test_text_output_has_a_line_per_figure() -> None:
    lines = Result("tracking", {"error_mm": 3.25, "frames": 12}, {"error_mm": 4.0}).as_text().splitlines()
    assert lines == ["tracking", "  error_mm  3.25   (published: 4)", "  frames    12"]


def test_paths_of_tests_are_those_that_the_user_sees(tmp_path: Path) -> None:
    here = ROOT / "tests" / "launcher"
    assert from_root("test_cli.py::test_x", here) == f"{here / 'test_cli.py'}::test_x"
    assert from_root("tests/launcher", ROOT) == "tests/launcher"
    assert from_root("-x", here) == "-x"
    assert from_root("no_such_test.py", here) == "no_such_test.py"
    assert names_tests("tests/launcher/test_cli.py::test_x")
    assert not names_tests("launcher"), "a word after -k that happens to be a folder"
    assert not names_tests("--tb=short")


@pytest.mark.parametrize(
    ("rest", "passed_on"),
    [
        ([], [*SHARED]),
        (["-k", "estop"], [*SHARED, "-k", "estop"]),
        (["-n", "0", "--pdb"], [*SHARED, "-n", "0", "--pdb"]),  # pytest takes the last one
        (["tests/geometry", "-x"], ["tests/geometry", "-x"]),
    ],
)
def test_processes_share_the_tests_unless_some_are_named(
    rest: list[str], passed_on: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[list[str]] = []

    def start(command: list[str], **_: object) -> "subprocess.CompletedProcess[str]":
        started.append(command)
        return subprocess.CompletedProcess(command, 0)

    def well(*_: object) -> bool:
        return True

    for name in ("_run_web_tests", "build_web", "ensure_chromium"):
        monkeypatch.setattr(f"launcher.commands.test.{name}", well)
    monkeypatch.setattr("launcher.commands.test.subprocess.run", start)
    monkeypatch.chdir(ROOT)
    assert main(["test", *rest]) == 0
    (command,) = started
    assert command[command.index("pytest") + 1 :] == passed_on
