"""How far long work has come, on stderr: a bar on a terminal, a line now and then elsewhere."""

import sys
import time

_EVERY_S = {True: 0.2, False: 10.0}
_WIDTH = 30


class ProgressBar:
    """`show` may be called as often as one likes."""

    def __init__(self, what: str, total: int) -> None:
        self._what, self._total = what, max(1, total)
        self._on_terminal = sys.stderr.isatty()
        self._started_s = self._shown_s = time.monotonic()

    def show(self, done: int) -> None:
        now_s = time.monotonic()
        if now_s - self._shown_s < _EVERY_S[self._on_terminal]:
            return
        self._shown_s = now_s
        share = min(1.0, done / self._total)
        left_s = (now_s - self._started_s) * (1.0 / share - 1.0) if share > 0 else 0.0
        bar = f"[{'#' * round(share * _WIDTH):<{_WIDTH}}] " if self._on_terminal else ""
        text = f"{self._what} {bar}{share:4.0%}, {left_s:.0f} s left"
        print(f"\r{text:<70}" if self._on_terminal else text, end="" if self._on_terminal else "\n", file=sys.stderr)
        sys.stderr.flush()

    def end(self) -> None:
        """Clears the bar."""
        if self._on_terminal:
            print(f"\r{'':<70}\r", end="", file=sys.stderr, flush=True)
