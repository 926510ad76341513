"""Credentials that Redis confirmed not long ago: for the one thing that must work while Redis is out of reach, stopping."""

from protocol.clock import Clock
from server.repositories.tokens import digest
from server.roles import Identity

_FOR_S = 12 * 3600.0
_MOST = 10_000


class KnownCredentials:
    """Identities by the digest of their cookie or token, of the last twelve hours, the latest ten thousand."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._known: dict[str, tuple[float, Identity]] = {}

    def note(self, secret: str, identity: Identity | None) -> Identity | None:
        """Remembers what Redis said of the secret (None: it is not valid), and gives it back."""
        key = digest(secret)
        self._known.pop(key, None)
        if identity is not None:
            self._known[key] = self._clock.monotonic_s(), identity
            while len(self._known) > _MOST:
                del self._known[next(iter(self._known))]
        return identity

    def find(self, secret: str) -> Identity | None:
        """Who that was when it was asked last; None when that is unknown or long ago."""
        seen_s, identity = self._known.get(digest(secret), (0.0, None))
        return identity if self._clock.monotonic_s() - seen_s < _FOR_S else None
