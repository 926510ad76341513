"""Runs an example of docs/examples (its path is the first argument, the robot the second) on a base of the simulated lab, in
place of its own ideal one: what the example knows of the world stays what it reads by its protocol."""

import importlib.util
import sys
from pathlib import Path

from tests.e2e.simulated_base import SimulatedBase


def main() -> None:
    path = Path(sys.argv.pop(1))
    sys.path.insert(0, str(path.parent))
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    example.main(SimulatedBase(sys.argv[1]))


if __name__ == "__main__":
    main()
