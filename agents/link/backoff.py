"""How long to wait before the next attempt, and what to say about it."""

import logging


class Backoff:
    """Doubling delays from `first_s` to `last_s`; `reset` once it works again."""

    def __init__(self, first_s: float = 0.1, last_s: float = 2.0) -> None:
        self._first_s = first_s
        self._last_s = last_s
        self._next_s = first_s

    def next_s(self) -> float:
        delay_s, self._next_s = self._next_s, min(self._last_s, 2.0 * self._next_s)
        return delay_s

    def reset(self) -> None:
        self._next_s = self._first_s


class Trouble:
    """Says in the log when something goes wrong, goes wrong otherwise, or works again, but not every repetition."""

    def __init__(self, logger: logging.Logger, what: str) -> None:
        self._logger = logger
        self._what = what
        self._text: str | None = None

    @property
    def text(self) -> str | None:
        """What is wrong at the moment; None when nothing is."""
        return self._text

    def note(self, text: str) -> None:
        if text != self._text:
            self._logger.warning("%s: %s", self._what, text)
        self._text = text

    def over(self) -> None:
        if self._text is not None:
            self._logger.info("%s: works again", self._what)
        self._text = None
