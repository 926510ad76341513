"""Seeded mutations of messages: what damaged disks, other versions, bad networks and bad people make of bytes."""

import random
import re

_NUMBER = re.compile(rb"-?\d+(\.\d+)?([eE][-+]?\d+)?")
_VALUES = (
    b"null", b"true", b'""', b"[]", b"{}", b"-1", b"0", b"1e308", b"-1e308", b"1e999", b"NaN", b"Infinity", b"1e-320",
    b"9223372036854775807", b"9223372036854775808", b"-9223372036854775809", b"1" * 400, b'"1.0"', b"0.5",
    b'"\xff"', b'"\\ud800"', b'"' + b"x" * 3000 + b'"', b"[" * 1500,
)  # fmt: skip
"""What a number of a message may be replaced by."""


def mutated(data: bytes, rng: random.Random) -> bytes:
    """Another message than `data`, by one to four mutations."""
    while True:
        changed = data
        for _ in range(rng.choice((1, 1, 1, 2, 4))):
            changed = rng.choice(_MUTATIONS)(changed, rng)
        if changed != data:
            return changed


def _flip(data: bytes, rng: random.Random) -> bytes:
    if not data:
        return b"\0"
    at = rng.randrange(len(data))
    return data[:at] + bytes([data[at] ^ (1 << rng.randrange(8))]) + data[at + 1 :]


def _overwrite(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    put = rng.randbytes(rng.randrange(1, 9))
    return data[:at] + put + data[at + len(put) :]


def _cut(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def _remove(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + data[at + rng.randrange(1, 20) :]


def _insert(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + rng.randbytes(rng.randrange(1, 20)) + data[at:]


def _repeat(data: bytes, rng: random.Random) -> bytes:
    start = rng.randrange(len(data) + 1)
    end = rng.randrange(start, len(data) + 1)
    return data[:end] + data[start:end] + data[end:]


def _number(data: bytes, rng: random.Random) -> bytes:
    """Another value in the place of a number of a text."""
    found = list(_NUMBER.finditer(data))
    if not found:
        return _flip(data, rng)
    at = rng.choice(found)
    return data[: at.start()] + rng.choice(_VALUES) + data[at.end() :]


_MUTATIONS = (_flip, _overwrite, _cut, _remove, _insert, _repeat, _number, _number)
