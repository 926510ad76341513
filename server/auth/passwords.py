"""Passwords: argon2id hashes, and readable random ones for the first administrator."""

import asyncio
import secrets

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError

MIN_LENGTH, MAX_LENGTH = 8, 256
_CONSONANTS, _VOWELS = "bdfghjklmnprstvz", "aeiou"
_SYLLABLES, _WORDS, _DIGITS = 2, 4, 4


class Passwords:
    """Hashes and checks. Each hash costs tens of milliseconds and 64 MB on purpose: done in a thread, few at once."""

    def __init__(self, hasher: PasswordHasher | None = None) -> None:
        self._hasher = hasher or PasswordHasher()
        self._at_once = asyncio.Semaphore(2)
        self._nobodys: str | None = None

    async def hash(self, password: str) -> str:
        async with self._at_once:
            return await asyncio.to_thread(self._hasher.hash, password)

    async def verify(self, stored: str | None, password: str) -> bool:
        """Whether the password fits the stored hash; takes as long when there is none, so that nobody learns which users
        exist."""
        if stored is None and self._nobodys is None:
            self._nobodys = await self.hash(secrets.token_hex())
        async with self._at_once:
            fits = await asyncio.to_thread(self._fits, stored or self._nobodys or "", password)
        return fits and stored is not None

    def _fits(self, stored: str, password: str) -> bool:
        try:
            return self._hasher.verify(stored, password)
        except (VerificationError, InvalidHashError):
            return False


def readable_password() -> str:
    """Random and easy to type, such as `kodu-fami-zelo-tiva-4821`: about 64 bits."""
    words = (
        "".join(secrets.choice(_CONSONANTS) + secrets.choice(_VOWELS) for _ in range(_SYLLABLES)) for _ in range(_WORDS)
    )
    return "-".join((*words, "".join(secrets.choice("0123456789") for _ in range(_DIGITS))))
