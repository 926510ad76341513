"""Two vehicles meet at a four-way crossing, five ways: how much longer they take than alone."""

import argparse

from launcher.manoeuvres.catalogue import crossing_scenarios
from launcher.manoeuvres.command import add_situation_arguments, run_situation
from launcher.output import Result


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_situation_arguments(parser, "crossing")


def run(arguments: argparse.Namespace) -> Result:
    return run_situation("crossing", crossing_scenarios, arguments)
