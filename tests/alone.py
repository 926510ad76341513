"""Where several processes share the tests (pytest-xdist), some of them still have the machine to themselves.

A test file stays in one process. All files of the folder `ALONE`, which drive a whole system, go to one process together, as its
last work, and it begins with them when every other process has ended: load from beside would change what they time, and they
share one running system. A test with the mark `alone` judges fractions of a second: while it runs, the other processes pause
between two tests.
"""

import fcntl
import os
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling
from xdist.workermanage import WorkerController

ALONE = "e2e"


def is_alone(nodeid: str) -> bool:
    """Whether the test belongs to those that begin when all others have ended."""
    return Path(nodeid.split("::")[0]).parent.name == ALONE


class FilesThenAlone(LoadScopeScheduling):
    """Hands out whole files in the order of the collection, and what has to be alone as one piece."""

    def schedule(self) -> None:
        self.config.option.loadscopereorder = False  # else the largest files would come first
        super().schedule()

    def _assign_work_unit(self, node: WorkerController) -> None:
        """By their places in the collection: of tests with one id, as schemathesis makes them, only the first would run."""
        scope, unit = self.workqueue.popitem(last=False)
        self.assigned_work.setdefault(node, {})[scope] = unit
        collection = self.registered_collections[node]
        node.send_runtest_some([index for index, nodeid in enumerate(collection) if not unit.get(nodeid, True)])

    def _split_scope(self, nodeid: str) -> str:
        return ALONE if is_alone(nodeid) else nodeid.split("::")[0]


@dataclass(frozen=True, slots=True)
class Locks:
    """Descriptors that each process of a run locks: `others`, shared for as long as it has tests, exclusively from its first test
    of `ALONE` on; `test`, for each test, exclusively for one that is marked."""

    others: int
    test: int

    @classmethod
    def of_run(cls, root: Path) -> "Locks":
        """Of a run of the tests below that folder."""
        return cls(os.open(root, os.O_RDONLY), os.open(root / "tests", os.O_RDONLY))

    def close(self) -> None:
        os.close(self.others)
        os.close(self.test)


_LOCKS = pytest.StashKey[Locks]()


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "alone: judges fractions of a second; no other test runs beside it")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> LoadScopeScheduling:
    return FilesThenAlone(config, log)


def pytest_sessionstart(session: pytest.Session) -> None:
    if hasattr(session.config, "workerinput"):
        locks = session.config.stash[_LOCKS] = Locks.of_run(session.config.rootpath)
        fcntl.flock(locks.others, fcntl.LOCK_SH)


@pytest.hookimpl(wrapper=True, tryfirst=True)  # outside of pytest-timeout: waiting is not the test's time
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    locks = item.config.stash.get(_LOCKS, None)
    if locks is None:
        return (yield)
    if is_alone(item.nodeid):
        fcntl.flock(locks.others, fcntl.LOCK_EX)
    fcntl.flock(locks.test, fcntl.LOCK_EX if item.get_closest_marker("alone") else fcntl.LOCK_SH)
    try:
        return (yield)
    finally:
        fcntl.flock(locks.test, fcntl.LOCK_UN)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    if _LOCKS in session.config.stash:
        session.config.stash[_LOCKS].close()  # the process itself goes on until all have ended


def pytest_report_teststatus(report: pytest.TestReport | pytest.CollectReport) -> tuple[str, str, str] | None:
    """Names a failure at once: what comes from several processes is otherwise a row of letters until the end."""
    if not report.failed or not hasattr(report, "node"):
        return None
    category, letter = ("failed", "F") if report.when == "call" else ("error", "E")
    return category, f"{letter} ({report.nodeid})\n", category.upper()
