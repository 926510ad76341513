"""A disk that fills up, for tests."""

import resource
from collections.abc import Generator
from contextlib import contextmanager


@contextmanager
def files_no_longer_than(size: int) -> Generator[None]:
    """The operating system's own limit on a file's length, which looks to a writer like a disk that fills up: what fits is
    written, the rest is an OSError."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
