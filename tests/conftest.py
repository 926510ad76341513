"""Order of the whole run: quick folders first, the browser last; repeats at the end that the console's tests failed."""

import os
from pathlib import Path

import pytest

ORDER = (
    "geometry", "protocol", "mapping", "lab", "localization", "agents", "server", "launcher", "bench", "experiments", "e2e",
)  # fmt: skip
TESTS = Path(__file__).parent
pytest_plugins = ("tests.redis_fixture", "tests.alone")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: (_rank(item.path), _shares_the_system(item)))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if os.environ.get("LILLIPUT_WEB_TESTS_FAILED"):
        terminalreporter.section("console (vitest)")
        terminalreporter.write_line("FAILED: the console's own tests failed, see the start of this run", red=True)


def _shares_the_system(item: pytest.Item) -> bool:
    """Tests of the shared running system come last: it runs to the end, and two systems at once are more than two cores bear."""
    return isinstance(item, pytest.Function) and "system" in item.fixturenames


def _rank(path: Path) -> float:
    """Place of a test's folder; folders not listed come before the slow ones at the end."""
    folder = path.relative_to(TESTS).parts[0] if path.is_relative_to(TESTS) else ""
    return ORDER.index(folder) if folder in ORDER else ORDER.index("experiments") - 0.5
