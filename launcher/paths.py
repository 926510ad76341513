"""Where things are: the project's root, the interpreter of its environment, and state folders."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PYTHON = sys.executable
DEFAULT_LAB = ROOT / "labs" / "gulliver.yaml"
WEB = ROOT / "web"


def script(name: str) -> str:
    """A command installed in the project's environment, e.g. ruff."""
    return str(Path(PYTHON).parent / name)


def default_state(lab_name: str) -> Path:
    """The folder for a lab's durable state and logs when `--state` names none."""
    return ROOT / ".lilliput" / lab_name
