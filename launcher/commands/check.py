"""`./lilliput check`: everything that must hold before a change is shared, one timed step after the other.

A failed step does not end the run; the summary names them all. `--fast` is what the pre-commit hook runs.
"""

import argparse
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from launcher.api_types import GENERATED_TYPES, generate_api_types
from launcher.errors import LauncherError
from launcher.output import Result, print_result, progress
from launcher.paths import PYTHON, ROOT, WEB, script
from launcher.web_build import has_web, install_packages


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a step ended: `problem` is empty when all is well, `note` says why a step had nothing to do."""

    problem: str = ""
    note: str = ""


@dataclass(frozen=True, slots=True)
class Step:
    """One thing to look at."""

    name: str
    look: Callable[[], Outcome]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--fast", action="store_true", help="only format and lint of the Python sources")
    parser.add_argument("--json", action="store_true", help="print one JSON object to stdout")


def run(arguments: argparse.Namespace) -> int:
    failed, seconds = look_at(fast_steps() if arguments.fast else fast_steps() + slow_steps())
    if arguments.json:
        figures = {f"{name.replace(' ', '_')}_s": round(value, 2) for name, value in seconds.items()}
        print_result(Result("check", {**figures, "failed": failed}, settings={"fast": arguments.fast}), as_json=True)
    progress(f"check failed: {', '.join(failed)}" if failed else "check passed")
    return 1 if failed else 0


def look_at(steps: list[Step]) -> tuple[list[str], dict[str, float]]:
    """Goes through all steps, telling about each; returns the names of the failed ones and the seconds each took."""
    failed: list[str] = []
    seconds: dict[str, float] = {}
    for step in steps:
        start = time.monotonic()
        try:
            outcome = step.look()
        except LauncherError as error:
            outcome = Outcome(problem=str(error))
        seconds[step.name] = time.monotonic() - start
        verdict = "FAILED" if outcome.problem else "skipped" if outcome.note else "ok"
        progress(f"{verdict:<8}{step.name:<20}{seconds[step.name]:6.1f} s  {outcome.note}".rstrip())
        if outcome.problem:
            failed.append(step.name)
            progress("    " + outcome.problem.strip().replace("\n", "\n    "))
    return failed, seconds


def fast_steps() -> list[Step]:
    return [
        Step("ruff format", lambda: _command([script("ruff"), "format", "--check", "--quiet", "--diff", "."])),
        Step("ruff lint", lambda: _command([script("ruff"), "check", "--quiet", "."])),
    ]


def slow_steps() -> list[Step]:
    return [
        Step("import rules", lambda: _command([script("lint-imports"), "--no-cache"])),
        Step("pyright", lambda: _command([script("pyright"), "--pythonpath", PYTHON, "--warnings"])),
        Step("generated types", compare_generated_types),
        Step("tsc", lambda: _npm_script("check:types")),
        Step("eslint", lambda: _npm_script("lint")),
    ]


def compare_generated_types() -> Outcome:
    """Generates the API types anew and compares them with those committed."""
    if not has_web(WEB):
        return Outcome(note="no web/package.json")
    with tempfile.TemporaryDirectory(prefix="lilliput-check-") as folder:
        fresh = Path(folder) / GENERATED_TYPES.name
        generate_api_types(fresh)
        if GENERATED_TYPES.is_file() and fresh.read_text() == GENERATED_TYPES.read_text():
            return Outcome()
    name = GENERATED_TYPES.relative_to(ROOT)
    return Outcome(problem=f"{name} does not match the server; run `./lilliput generate` and commit it")


def _npm_script(name: str) -> Outcome:
    if not has_web(WEB):
        return Outcome(note="no web/package.json")
    node = install_packages(WEB, progress)
    return _command(node.npm("run", "--silent", name), cwd=WEB, environment=node.environment())


def _command(argv: list[str], cwd: Path = ROOT, environment: dict[str, str] | None = None) -> Outcome:
    try:
        done = subprocess.run(
            argv, cwd=cwd, env=environment, capture_output=True, text=True, errors="replace", check=False
        )
    except FileNotFoundError:
        return Outcome(problem=f"{argv[0]} is missing; remove .venv and start again")
    if done.returncode == 0:
        return Outcome()
    return Outcome(problem=f"{done.stdout}{done.stderr}".strip() or f"{argv[0]} ended with status {done.returncode}")
