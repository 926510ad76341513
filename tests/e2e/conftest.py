"""One running system for the tests that only use it; those that break it start their own."""

from collections.abc import Iterator

import pytest

from tests.e2e.system import RunningSystem, running_system


@pytest.fixture(scope="session")
def system(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningSystem]:
    """The lab of the reports, everything running, robots localized."""
    with running_system(tmp_path_factory.mktemp("system")) as running:
        running.wait_until_driving_is_possible()
        yield running
