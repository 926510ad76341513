"""What the experiments of the three traffic situations share on the command line."""

import argparse
from collections.abc import Callable
from pathlib import Path

from launcher.errors import UsageError
from launcher.manoeuvres.evaluation import RUNS
from launcher.manoeuvres.plot import plot_situation
from launcher.manoeuvres.scenario import Scenario
from launcher.manoeuvres.table import PUBLISHED_MEAN, compare, figures
from launcher.output import Result


def add_situation_arguments(parser: argparse.ArgumentParser, situation: str) -> None:
    """Adds `--runs` and `--plot`."""
    parser.add_argument("--runs", type=int, default=RUNS, help=f"of each scenario (default: {RUNS}, as the report)")
    parser.add_argument(
        "--plot", type=Path, default=Path(f"{situation}.png"), metavar="FILE", help=f"PNG (default: {situation}.png)"
    )


def run_situation(situation: str, scenarios: Callable[[], list[Scenario]], arguments: argparse.Namespace) -> Result:
    """The table and its picture. UsageError for less than one run."""
    if arguments.runs < 1:
        raise UsageError("--runs is at least 1")
    rows = compare(scenarios(), arguments.runs)
    plot_situation(situation, rows, arguments.plot)
    key = f"fk_{situation}" if len(rows) == 1 else f"fk_{situation}_mean"
    settings = {
        "runs": arguments.runs,
        "speed_mps": rows[0].scenario.speed_mps,
        "acceleration_mps2": rows[0].scenario.acceleration_mps2,
        "deceleration_mps2": rows[0].scenario.deceleration_mps2,
        "plot": str(arguments.plot),
    }
    return Result(situation, dict(figures(situation, rows)), {key: PUBLISHED_MEAN[situation]}, settings)
