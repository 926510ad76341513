"""`./lilliput test`: every test there is, the quick ones first and the browser last.

The console's own tests (Vitest) run before pytest, so that pytest's summary is the last thing printed; when they fail,
pytest still runs, its summary repeats the failure and the exit status is 1. As many processes as there are cores, up to four,
share the tests; those that drive a whole system come last and alone (tests/alone.py). Arguments that name tests select only
those, in one process unless `-n` says otherwise.
"""

import argparse
import os
import subprocess
from pathlib import Path

from launcher.chromium import ensure_chromium
from launcher.output import progress
from launcher.paths import PYTHON, ROOT, WEB
from launcher.web_build import build_web, has_web, install_packages

WEB_FAILED = "LILLIPUT_WEB_TESTS_FAILED"
"""Tells tests/conftest.py to repeat in pytest's summary that the console's tests failed."""

SHARED = ("-n", "auto", "--maxprocesses", "4")
"""Each process has half a gigabyte, and a few long files are all that more than four would wait for."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.usage = "lilliput test [PYTEST ARGUMENTS]"


def run(arguments: argparse.Namespace) -> int:
    rest = [from_root(argument, Path.cwd()) for argument in arguments.rest]
    chosen = [argument for argument in rest if names_tests(argument)]
    web_ok = True
    if not chosen:
        web_ok = _run_web_tests()
    if not chosen or any("e2e" in Path(argument.split("::")[0]).parts for argument in chosen):
        build_web(WEB, progress)
        ensure_chromium()
    environment = {**os.environ} if web_ok else {**os.environ, WEB_FAILED: "1"}
    shared = () if chosen else SHARED
    done = subprocess.run([PYTHON, "-P", "-m", "pytest", *shared, *rest], cwd=ROOT, env=environment, check=False)
    return done.returncode or (0 if web_ok else 1)


def names_tests(argument: str) -> bool:
    """Whether a pytest argument is a path of tests (perhaps with `::test_name` behind it)."""
    path = ROOT / argument.split("::")[0]
    return not argument.startswith("-") and path.is_relative_to(ROOT / "tests") and path.exists()


def from_root(argument: str, cwd: Path) -> str:
    """A path as the user sees it from `cwd`, made absolute since pytest runs in the root; other arguments unchanged."""
    path, separator, name = argument.partition("::")
    if not path or path.startswith("-") or cwd == ROOT or not (cwd / path).exists():
        return argument
    return f"{(cwd / path).resolve()}{separator}{name}"


def _run_web_tests() -> bool:
    if not has_web(WEB):
        progress("no console tests: web/package.json is missing")
        return True
    node = install_packages(WEB, progress)
    environment = {**node.environment(), "CI": "1"}  # Vitest runs once instead of watching
    return subprocess.run(node.npm("test", "--silent"), cwd=WEB, env=environment, check=False).returncode == 0
