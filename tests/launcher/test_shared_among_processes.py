"""Several processes share the tests: a file stays whole, and what drives a whole system begins when all else has ended."""

import os
import subprocess
import sys
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CONFTEST = """
import os, pathlib, pytest
from _pytest.nodeid import coerce_node_id

def pytest_collection_modifyitems(items):
    for item in items:
        if item.path.stem == "test_c":
            item._id = coerce_node_id("tests/pure/test_c.py::test")  # as schemathesis does

@pytest.fixture(autouse=True)
def story(request):
    def tell(what):
        with open(pathlib.Path(__file__).parent.parent / "story", "a") as story:
            story.write(f"{what} {request.node.path.parent.name} {request.node.path.stem} {os.getpid()}\\n")
    tell("begins")
    yield
    tell("ends")
"""
THREE_TESTS = """
import pytest, time
pytestmark = {marks}

@pytest.mark.parametrize("number", range(3))
def test(number):
    time.sleep({lasts_s})
"""


@dataclass(frozen=True)
class Run:
    """How a run of the suite ended, and its story: begins or ends, folder, file, process."""

    status: int
    output: str
    story: list[list[str]]


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Of four files of quick tests, one of which fails and one of which is marked to be alone, and of two files that have the
    machine to themselves."""
    folder = tmp_path_factory.mktemp("suite")
    lasting_s = {"agents/test_a": 0.1, "agents/test_b": 0.3, "agents/test_c": 0.3, "e2e/test_d": 0.0, "e2e/test_e": 0.0}
    for name, lasts_s in lasting_s.items():
        path = folder / "tests" / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        marks = "[pytest.mark.alone]" if name == "agents/test_b" else "[]"
        path.write_text(THREE_TESTS.format(marks=marks, lasts_s=lasts_s))
    (folder / "tests/agents/test_0.py").write_text("def test():\n    raise AssertionError\n")
    (folder / "tests/conftest.py").write_text(CONFTEST)
    ended = subprocess.run(
        [sys.executable, "-P", "-m", "pytest", "-p", "xdist.plugin", "-p", "tests.alone", "-n", "2", "tests"],
        cwd=folder,
        env={"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        stdout=subprocess.PIPE,
        text=True,
        check=False,
        timeout=60,
    )
    story = [line.split() for line in (folder / "story").read_text().splitlines()]
    return Run(ended.returncode, ended.stdout, story)


def test_what_has_to_be_alone_begins_when_all_else_has_ended(done: Run) -> None:
    assert [folder == "agents" for _, folder, _, _ in done.story] == [True] * 20 + [False] * 12
    assert len({process for *_, process in done.story}) == 2
    alone = done.story[20:]
    assert [what for what, *_ in alone] == ["begins", "ends"] * 6
    assert len({process for *_, process in alone}) == 1
    assert [name for name, _ in groupby(alone, lambda step: step[2])] == ["test_d", "test_e"]


def test_nothing_runs_beside_a_test_that_is_marked(done: Run) -> None:
    begun = [number for number, (what, _, name, _) in enumerate(done.story) if (what, name) == ("begins", "test_b")]
    assert len(begun) == 3
    assert [done.story[number + 1][::2] for number in begun] == [["ends", "test_b"]] * 3


def test_a_file_stays_in_one_process(done: Run) -> None:
    assert len({(name, process) for _, _, name, process in done.story}) == 6


def test_one_summary_counts_all_and_a_failure_among_those_that_share_fails_the_run(done: Run) -> None:
    assert done.status == 1
    assert "1 failed, 15 passed" in done.output.splitlines()[-1]
    assert "F (tests/agents/test_0.py::test)\n" in done.output[: done.output.index("FAILURES")]
    assert len(done.output.splitlines()) < 40, done.output
