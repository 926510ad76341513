"""Which version of the project this is."""

import tomllib
from pathlib import Path

_PROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"


def project_version() -> str:
    """The version in pyproject.toml."""
    with _PROJECT.open("rb") as file:
        return str(tomllib.load(file)["project"]["version"])
