"""The live state as encoded entries with versions: who lags behind gets all that is newer than what they have, once.

An entry is encoded when it changes, not per client; a message is put together once for all clients at the same version.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

from pydantic import BaseModel

MAPS = ("robots", "cameras", "waypoints", "routes", "objects", "zones", "speed_zones")
SINGLES = ("estop", "obstacles", "health")
_LOG_LENGTH = 50
_TOMBSTONES = 1000


@dataclass(slots=True)
class _Entry:
    """`key` is compared to find a change; `data` is None when it is gone."""

    version: int
    key: object
    data: bytes | None


@dataclass(frozen=True, slots=True)
class Item:
    """What to show, and what to compare instead of it (e.g. without ages); the same when that is None."""

    view: BaseModel
    key: object = None


class Sections:
    """Sections of entries by id, singles, and a log of the last lines."""

    def __init__(self) -> None:
        self.version = 0
        self._maps: dict[str, dict[str, _Entry]] = {name: {} for name in MAPS}
        self._singles = {name: _Entry(0, None, None) for name in SINGLES}
        self._log: deque[tuple[int, bytes]] = deque(maxlen=_LOG_LENGTH)
        self._oldest = 0
        self._changed = False
        self._messages: dict[tuple[int, int], bytes] = {}

    def replace(self, section: str, items: Mapping[str, Item]) -> None:
        """Makes `items` the whole of a section."""
        entries = self._maps[section]
        self.put(section, items)
        for name in entries.keys() - items.keys():
            if entries[name].data is not None:
                entries[name] = _Entry(self._next(), None, None)

    def put(self, section: str, items: Mapping[str, Item]) -> None:
        """Sets some entries of a section."""
        entries = self._maps[section]
        for name, item in items.items():
            self._set(entries, name, item)

    def replace_single(self, section: str, item: Item | None) -> None:
        """Sets one of the singles; None: there is none."""
        if item is not None:
            self._set(self._singles, section, item)
        elif self._singles[section].data is not None:
            self._singles[section] = _Entry(self._next(), None, None)

    def append(self, line: BaseModel) -> None:
        """Adds a line to the log."""
        self._log.append((self._next(), line.model_dump_json().encode()))

    def commit(self) -> bool:
        """Makes the changes since the last commit one version; whether there were any."""
        if not self._changed:
            return False
        self.version += 1
        self._changed = False
        self._messages.clear()
        self._forget_tombstones()
        return True

    def message(self, since: int, stamp_ns: int) -> bytes:
        """What a client at version `since` misses; a snapshot when it has nothing (-1) or lags too far behind."""
        body = self._messages.get((since, self.version))
        if body is None:
            body = self._snapshot() if since < self._oldest or since < 0 else self._changes(since)
            self._messages[since, self.version] = body
        kind = b"snapshot" if since < self._oldest or since < 0 else b"changes"
        return b'{"type":"%s","stamp_ns":%d%s}' % (kind, stamp_ns, body)

    def _snapshot(self) -> bytes:
        parts = [_map(name, {k: e for k, e in self._maps[name].items() if e.data is not None}) for name in MAPS]
        parts += [b',"%s":%s' % (name.encode(), self._singles[name].data or b"null") for name in SINGLES]
        parts.append(b',"events":[%s]' % b",".join(data for _, data in self._log))
        return b"".join(parts)

    def _changes(self, since: int) -> bytes:
        parts: list[bytes] = []
        for name in MAPS:
            newer = {key: entry for key, entry in self._maps[name].items() if entry.version > since}
            if newer:
                parts.append(_map(name, newer))
        for name in SINGLES:
            entry = self._singles[name]
            if entry.version > since:
                parts.append(b',"%s":%s' % (name.encode(), entry.data or b"null"))
        lines = [data for version, data in self._log if version > since]
        if lines:
            parts.append(b',"events":[%s]' % b",".join(lines))
        return b"".join(parts)

    def _set(self, entries: dict[str, _Entry], name: str, item: Item) -> None:
        key = item.view if item.key is None else item.key
        old = entries.get(name)
        if old is None or old.data is None or old.key != key:
            entries[name] = _Entry(self._next(), key, item.view.model_dump_json().encode())

    def _next(self) -> int:
        self._changed = True
        return self.version + 1

    def _forget_tombstones(self) -> None:
        gone = [(e.version, name, key) for name in MAPS for key, e in self._maps[name].items() if e.data is None]
        if len(gone) <= _TOMBSTONES:
            return
        for version, name, key in sorted(gone)[: len(gone) // 2]:
            del self._maps[name][key]
            self._oldest = max(self._oldest, version)


def _map(name: str, entries: Mapping[str, _Entry]) -> bytes:
    # Ids are lower-case letters, digits, dashes and underscores: nothing to escape.
    inner = b",".join(b'"%s":%s' % (key.encode(), entry.data or b"null") for key, entry in entries.items())
    return b',"%s":{%s}' % (name.encode(), inner)
