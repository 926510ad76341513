"""`./lilliput experiment NAME`: runs an experiment in the simulated lab and prints its figures."""

import argparse
import importlib
from collections.abc import Callable
from typing import Protocol, cast

from launcher.errors import UsageError
from launcher.output import Result, print_result

EXPERIMENTS = (
    "tracking",
    "max-speed",
    "coverage",
    "crowd",
    "rectangle",
    "fusion",
    "route",
    "obstacles",
    "crossing",
    "merge",
    "roundabout",
)
"""A name is a module in launcher/experiments (hyphens are underscores there) with `add_arguments(parser)` and
`run(arguments) -> Result`."""


class ExperimentModule(Protocol):
    """What a module in launcher/experiments offers."""

    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], Result]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    subparsers = parser.add_subparsers(dest="experiment", metavar="NAME", required=True, parser_class=type(parser))
    for name in EXPERIMENTS:
        module = _module(name)
        subparser = subparsers.add_parser(name, help=module.__doc__, description=module.__doc__)
        subparser.add_argument("--json", action="store_true", help="print one JSON object")
        module.add_arguments(subparser)


def run(arguments: argparse.Namespace) -> int:
    if arguments.experiment not in EXPERIMENTS:
        raise UsageError(f"no experiment is called {arguments.experiment}; there are {', '.join(EXPERIMENTS)}")
    print_result(_module(arguments.experiment).run(arguments), as_json=arguments.json)
    return 0


def _module(name: str) -> ExperimentModule:
    return cast(ExperimentModule, importlib.import_module(f"launcher.experiments.{name.replace('-', '_')}"))
