"""The result of a command: text for people, or with `--json` exactly one object on stdout.

The object is `{"name", "figures", "published", "settings", "version"}` (design, "The launcher"): `figures` is flat with
units in its snake_case keys, `published` holds the same keys where a report gives a value.
"""

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TextIO

from protocol.version import project_version


@dataclass(frozen=True, slots=True)
class Result:
    """What a command found out: `figures` by name with unit, e.g. `position_error_median_mm`."""

    name: str
    figures: Mapping[str, Any]
    published: Mapping[str, Any] = field(default_factory=dict[str, Any])
    settings: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def as_json(self) -> str:
        """One JSON object; NaN and infinity are refused with ValueError, since JSON has neither."""
        content = {
            "name": self.name,
            "figures": dict(self.figures),
            "published": dict(self.published),
            "settings": dict(self.settings),
            "version": project_version(),
        }
        return json.dumps(content, allow_nan=False)

    def as_text(self) -> str:
        """A line per figure, with the published value behind it where there is one."""
        width = max((len(key) for key in self.figures), default=0)
        lines = [self.name]
        for key, value in self.figures.items():
            behind = f"   (published: {_plain(self.published[key])})" if key in self.published else ""
            lines.append(f"  {key:<{width}}  {_plain(value)}{behind}")
        return "\n".join(lines)


def print_result(result: Result, *, as_json: bool, stream: TextIO | None = None) -> None:
    """Writes the result to stdout in the form asked for."""
    print(result.as_json() if as_json else result.as_text(), file=stream or sys.stdout, flush=True)


def progress(text: str) -> None:
    """Tells people what goes on; always on stderr, so that stdout holds the result alone."""
    print(text, file=sys.stderr, flush=True)


def _plain(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
