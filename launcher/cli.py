"""The command line: finds the command, parses its arguments, turns errors into one line and an exit status."""

import argparse
import importlib
import os
import sys
from collections.abc import Callable, Sequence
from typing import Protocol, cast

from launcher.errors import LauncherError
from launcher.registry import COMMANDS, Command

DESCRIPTION = "Lilliput: fleet control and ceiling-camera localization for labs of scaled vehicles and factory floors."


class CommandModule(Protocol):
    """What a module in launcher/commands offers."""

    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int]


def main(argv: Sequence[str], commands: Sequence[Command] = COMMANDS) -> int:
    """Runs the command that `argv` (without the program's name) asks for; returns the exit status, 2 for bad use."""
    try:
        return _dispatch(argv, commands)
    except LauncherError as error:
        print(f"lilliput: {error}", file=sys.stderr)
        return error.exit_status
    except KeyboardInterrupt:
        print("lilliput: stopped", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of our output, e.g. `head`, is gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except SystemExit as error:  # argparse: help (0) or bad use (2)
        return error.code if isinstance(error.code, int) else 1


def _dispatch(argv: Sequence[str], commands: Sequence[Command]) -> int:
    parser = _OneLineParser(prog="lilliput", description=DESCRIPTION)
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True, parser_class=_OneLineParser)
    wanted = next((command for command in commands if argv and command.name == argv[0]), None)
    for command in commands:
        subparser = subparsers.add_parser(command.name, help=command.summary, description=command.summary)
        if command is wanted:
            module = cast(CommandModule, importlib.import_module(command.module))
            module.add_arguments(subparser)
            subparser.set_defaults(run=module.run)
            if command.takes_rest and not {"-h", "--help"} & set(argv[1:2]):
                return module.run(argparse.Namespace(rest=list(argv[1:])))
    if not argv:
        parser.print_help()
        return 2
    arguments = parser.parse_args(argv)
    return arguments.run(arguments)


class _OneLineParser(argparse.ArgumentParser):
    """Complains in one line that says how to go on."""

    def error(self, message: str) -> None:  # type: ignore[override]  # argparse declares NoReturn; exit() never returns
        self.exit(2, f"lilliput: {message} (see `./{self.prog} --help`)\n")
