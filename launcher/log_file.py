"""What a process prints: kept in a log file of limited size, with warnings and errors shown on the terminal as well."""

import re
from collections.abc import Callable
from pathlib import Path

CAP_BYTES = 2_000_000
"""A log file of this size is renamed to NAME.log.1 (replacing the one before), so two of them are kept at most."""
LONGEST_LINE = 20_000
ECHO_LINES = 5
ECHO_WINDOW_S = 10.0
"""At most `ECHO_LINES` lines of a process reach the terminal in this time; the rest stands in its log."""
WORTH_SHOWING = re.compile(rb"\b(WARNING|ERROR|CRITICAL)\b")


class CappedLog:
    """Appends to a file and renames it when it is full. A disk that takes no more loses lines, never the caller."""

    def __init__(self, path: Path, cap_bytes: int = CAP_BYTES) -> None:
        self.path = path
        self._cap_bytes = cap_bytes
        path.parent.mkdir(parents=True, exist_ok=True)

    def write(self, content: bytes) -> None:
        try:
            with self.path.open("ab") as file:
                if file.tell() and file.tell() + len(content) > self._cap_bytes:
                    self.path.replace(self.path.with_name(f"{self.path.name}.1"))
                    file = self.path.open("ab")
                with file:
                    file.write(content)
        except OSError:
            return


class OutputReader:
    """Takes a process's output piece by piece: all of it to the log, lines worth showing to `tell`.

    `last_line` is the newest line with anything in it: of a Python process that crashed, the exception.
    """

    def __init__(
        self, log: CappedLog, tell: Callable[[str], None], monotonic_s: Callable[[], float], echo: bool
    ) -> None:
        self._log = log
        self._tell = tell
        self._monotonic_s = monotonic_s
        self._echo = echo
        self._rest = b""
        self._shown: list[float] = []
        self._hidden = 0
        self.last_line = ""

    def feed(self, piece: bytes) -> None:
        self._log.write(piece)
        *lines, self._rest = (self._rest + piece).split(b"\n")
        if len(self._rest) > LONGEST_LINE:
            lines, self._rest = [*lines, self._rest], b""
        for line in lines:
            self._take(line)

    def end(self) -> None:
        """The output is over; an unfinished line counts as a line."""
        if self._rest:
            self._take(self._rest)
            self._rest = b""

    def _take(self, line: bytes) -> None:
        if not line.strip():
            return
        self.last_line = line[:LONGEST_LINE].decode(errors="replace").strip()
        if self._echo and WORTH_SHOWING.search(line):
            self._show(self.last_line)

    def _show(self, line: str) -> None:
        now = self._monotonic_s()
        self._shown = [at for at in self._shown if now - at < ECHO_WINDOW_S]
        if len(self._shown) >= ECHO_LINES:
            self._hidden += 1
            return
        if self._hidden:
            self._tell(f"({self._hidden} more lines in {self._log.path})")
            self._hidden = 0
        self._shown.append(now)
        self._tell(line)
