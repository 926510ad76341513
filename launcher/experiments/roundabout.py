"""A vehicle comes to a roundabout in which another drives: how much longer they take than alone."""

import argparse

from launcher.manoeuvres.catalogue import roundabout_scenarios
from launcher.manoeuvres.command import add_situation_arguments, run_situation
from launcher.output import Result


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_situation_arguments(parser, "roundabout")


def run(arguments: argparse.Namespace) -> Result:
    return run_situation("roundabout", roundabout_scenarios, arguments)
