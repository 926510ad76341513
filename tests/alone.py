"""Where several processes share the tests (pytest-xdist), those that drive a whole system still have the machine to themselves.

A test file stays in one process. All files of the folder `ALONE` go to one process together, as its last work, and it begins
with them when every other process has ended: load from beside would change what they time, and they share one running system.
"""

import fcntl
import os
from collections.abc import Generator
from pathlib import Path

import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling

ALONE = "e2e"
_OTHERS_ENDED = pytest.StashKey[int]()
"""The descriptor that a process locks: shared as long as it has tests, exclusively from its first test of `ALONE` on."""


def is_alone(nodeid: str) -> bool:
    """Whether the test has the machine to itself."""
    return Path(nodeid.split("::")[0]).parent.name == ALONE


class FilesThenAlone(LoadScopeScheduling):
    """Hands out whole files in the order of the collection, and what has to be alone as one piece."""

    def schedule(self) -> None:
        self.config.option.loadscopereorder = False  # else the largest files would come first
        super().schedule()

    def _split_scope(self, nodeid: str) -> str:
        return ALONE if is_alone(nodeid) else nodeid.split("::")[0]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> LoadScopeScheduling:
    return FilesThenAlone(config, log)


def pytest_sessionstart(session: pytest.Session) -> None:
    if hasattr(session.config, "workerinput"):
        lock = session.config.stash[_OTHERS_ENDED] = os.open(__file__, os.O_RDONLY)
        fcntl.flock(lock, fcntl.LOCK_SH)


@pytest.hookimpl(wrapper=True, tryfirst=True)  # outside of pytest-timeout: waiting is not the test's time
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    lock = item.config.stash.get(_OTHERS_ENDED, None)
    if lock is not None and is_alone(item.nodeid):
        fcntl.flock(lock, fcntl.LOCK_EX)
    return (yield)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    if _OTHERS_ENDED in session.config.stash:
        os.close(session.config.stash[_OTHERS_ENDED])  # the process itself goes on until all have ended


def pytest_report_teststatus(report: pytest.TestReport | pytest.CollectReport) -> tuple[str, str, str] | None:
    """Names a failure at once: what comes from several processes is otherwise a row of letters until the end."""
    if not report.failed or not hasattr(report, "node"):
        return None
    category, letter = ("failed", "F") if report.when == "call" else ("error", "E")
    return category, f"{letter} ({report.nodeid})\n", category.upper()
