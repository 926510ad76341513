"""A vehicle on a ramp meets one on the main road, three ways: how much longer they take than alone."""

import argparse

from launcher.manoeuvres.catalogue import merge_scenarios
from launcher.manoeuvres.command import add_situation_arguments, run_situation
from launcher.output import Result


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_situation_arguments(parser, "merge")


def run(arguments: argparse.Namespace) -> Result:
    return run_situation("merge", merge_scenarios, arguments)
