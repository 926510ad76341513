"""Finds and reads the lab file that a command is about."""

import argparse
import os
from pathlib import Path

from launcher.errors import UsageError
from launcher.paths import DEFAULT_LAB, default_state
from protocol.errors import LabFileError
from protocol.lab import Lab, load_lab


def add_lab_arguments(parser: argparse.ArgumentParser) -> None:
    """`--lab` and `--state`, with the environment's LILLIPUT_LAB and LILLIPUT_STATE as defaults."""
    add_lab_file_argument(parser)
    parser.add_argument("--state", type=Path, metavar="DIR", help="folder of data and logs (default: .lilliput/LAB)")


def add_lab_file_argument(parser: argparse.ArgumentParser) -> None:
    """`--lab`, with the environment's LILLIPUT_LAB as default."""
    parser.add_argument("--lab", type=Path, metavar="FILE", help="lab description (default: labs/gulliver.yaml)")


def read_lab(given: Path | None, *, recorded: bool = False) -> tuple[Path, Lab]:
    """The lab file's absolute path and its content; UsageError with a line per problem. `recorded`: see `load_lab`."""
    path = (given or Path(os.environ.get("LILLIPUT_LAB") or DEFAULT_LAB)).resolve()
    try:
        return path, load_lab(path, recorded=recorded)
    except LabFileError as error:
        raise UsageError(f"the lab file cannot be used\n{error}") from error


def state_folder(given: Path | None, lab: Lab) -> Path:
    """The absolute path of the state folder."""
    return (given or Path(os.environ.get("LILLIPUT_STATE") or default_state(lab.name))).resolve()
