"""`./lilliput generate`: writes the sources that follow from others, which `check` compares with those committed."""

import argparse

from launcher.api_types import GENERATED_TYPES, generate_api_types
from launcher.errors import LauncherError
from launcher.output import progress
from launcher.paths import ROOT, WEB
from launcher.web_build import has_web


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Takes no arguments."""


def run(_arguments: argparse.Namespace) -> int:
    if not has_web(WEB):
        raise LauncherError("there is no web/package.json, so there are no API types to generate")
    generate_api_types(GENERATED_TYPES)
    progress(f"wrote {GENERATED_TYPES.relative_to(ROOT)}")
    return 0
