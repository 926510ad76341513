"""`./lilliput bench NAME`: measures how fast a part is, on this machine (docs/benchmarks.md)."""

import argparse
import importlib
import os
from collections.abc import Callable
from typing import Protocol, cast

from launcher.errors import LauncherError, UsageError
from launcher.output import Result, print_result

BENCHES = ("localization", "memory", "stop", "fleet", "guidance")
"""A name is a module in tests/bench with `add_arguments(parser)` and `run(arguments) -> Result`."""
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


class BenchModule(Protocol):
    """What a module in tests/bench offers."""

    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], Result]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    for (
        variable
    ) in _ONE_THREAD:  # before NumPy is loaded: our matrices are small, and threads only get in each other's way
        os.environ.setdefault(variable, "1")
    subparsers = parser.add_subparsers(dest="bench", metavar="NAME", required=True, parser_class=type(parser))
    for name in BENCHES:
        module = _module(name)
        subparser = subparsers.add_parser(name, help=module.__doc__, description=module.__doc__)
        subparser.add_argument("--json", action="store_true", help="print one JSON object")
        module.add_arguments(subparser)


def run(arguments: argparse.Namespace) -> int:
    if arguments.bench not in BENCHES:
        raise UsageError(f"no benchmark is called {arguments.bench}; there are {', '.join(BENCHES)}")
    print_result(_module(arguments.bench).run(arguments), as_json=arguments.json)
    return 0


def _module(name: str) -> BenchModule:
    try:
        return cast(BenchModule, importlib.import_module(f"tests.bench.{name}"))
    except ModuleNotFoundError as error:
        if error.name is None or not error.name.startswith("tests"):
            raise
        raise LauncherError("benchmarks are part of the sources, not of the image: run them in a checkout") from error
