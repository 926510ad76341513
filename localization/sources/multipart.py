"""The parts of a `multipart/x-mixed-replace` stream (RFC 2046, 5.1; the pictures of a network camera), from bytes as they come.

Pure: bytes in, parts out, each as soon as its last byte is there. Cameras are careless with the format, so it is read with
lenience: boundaries announced with their dashes, bare line feeds, lengths that are absent or wrong; after what makes no
sense it goes on at the next boundary.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

_HEADER_LIMIT = 8192
_MOST_PART = 1 << 26
"""64 MB: no picture is larger, so a length that is comes from garbage."""
_JPEG_END = b"\xff\xd9"
"""What a part without a length ends with; waiting for the next boundary would make every picture a period older."""
_LIES = 3
"""Parts in a row whose length was wrong, after which lengths are no longer believed."""


@dataclass(frozen=True, slots=True)
class Part:
    """A part with its headers (lower case names) and body; `whole` is False for what cannot be one (garbage, too long, cut
    off by the next boundary)."""

    headers: Mapping[str, str]
    body: bytes
    whole: bool = True


def boundary_of(content_type: str) -> str | None:
    """The boundary that a Content-Type header names; None when it is not one of a multipart stream."""
    kind, *parameters = content_type.split(";")
    if not kind.strip().lower().startswith("multipart/"):
        return None
    for parameter in parameters:
        name, _, value = parameter.partition("=")
        boundary = value.strip().strip('"').removeprefix("--")
        if name.strip().lower() == "boundary" and boundary:
            return boundary
    return None


class MultipartParser:
    """Keeps what has come of the part that is not complete yet. ValueError for an empty boundary."""

    def __init__(self, boundary: str) -> None:
        if not boundary:
            raise ValueError("a boundary is needed")
        self._mark = b"--" + boundary.encode("latin-1")
        self._buffer = bytearray()
        self._headers: dict[str, str] | None = None
        self._length: int | None = None
        self._searched = 0
        self._lost = False
        self._by_length = False
        self._lies = 0

    @property
    def in_part(self) -> bool:
        """Whether a part has begun and is not complete."""
        return self._headers is not None

    def feed(self, data: bytes) -> Iterator[Part]:
        """The parts that these bytes complete; in place of garbage, however long, one that is not whole."""
        self._buffer += data
        while True:
            if self._headers is None:
                garbage = self._next_headers()
                if garbage is not None:
                    yield garbage
                    continue
            part = None if self._headers is None else self._next_body(self._headers)
            if part is None:
                return
            yield part

    def _next_headers(self) -> Part | None:
        """Goes past a boundary line and the headers behind it; gives what stood in its place, if that is news."""
        at = self._buffer.find(self._mark)
        if at < 0:
            too_much = len(self._buffer) - len(self._mark) - _HEADER_LIMIT
            return self._lose(too_much) if too_much > 0 else None
        if self._buffer[:at].strip(b"\r\n"):
            part = self._lose(at)
            if part is not None:
                return part
        start = self._buffer.find(self._mark)
        line_end = self._buffer.find(b"\n", start)
        end, gap = _blank_line(self._buffer, line_end) if line_end >= 0 else (-1, 0)
        if end < 0:
            return self._lose(start + len(self._mark)) if len(self._buffer) - start > _HEADER_LIMIT else None
        self._headers = _headers(bytes(self._buffer[line_end + 1 : end]))
        del self._buffer[: end + gap]
        if self._by_length and not self._lost:
            self._lies = 0
        self._lost, self._by_length = False, False
        self._length, self._searched = _length(self._headers), 0
        return None

    def _next_body(self, headers: dict[str, str]) -> Part | None:
        mark = self._find_mark()
        length = self._length if self._lies < _LIES else None
        if length is not None and len(self._buffer) >= length and (mark is None or mark >= length):
            self._by_length = True
            return self._end(headers, length)
        if mark is not None:
            body = bytes(self._buffer[:mark]).removesuffix(b"\n").removesuffix(b"\r")
            return self._end(headers, mark, Part(headers, body, whole=length is None or len(body) >= length))
        if length is None and self._buffer.endswith((_JPEG_END, _JPEG_END + b"\r\n", _JPEG_END + b"\n")):
            return self._end(headers, self._buffer.rfind(_JPEG_END) + len(_JPEG_END))
        if len(self._buffer) > _MOST_PART:
            self._headers = None
            return self._lose(len(self._buffer) - len(self._mark))
        return None

    def _end(self, headers: dict[str, str], length: int, part: Part | None = None) -> Part:
        part = part or Part(headers, bytes(self._buffer[:length]))
        del self._buffer[:length]
        self._headers = None
        return part

    def _find_mark(self) -> int | None:
        """Where the next boundary begins; remembers how far it has looked, so that slow parts cost no more than quick ones."""
        at = self._buffer.find(self._mark, self._searched)
        if at < 0:
            self._searched = max(0, len(self._buffer) - len(self._mark) + 1)
            return None
        return at

    def _lose(self, count: int) -> Part | None:
        """Drops bytes that belong to no part; the first of them are news."""
        body = bytes(self._buffer[:count])
        del self._buffer[:count]
        known, self._lost = self._lost, True
        if known:
            return None
        self._lies += self._by_length
        return Part({}, body, whole=False)


def _blank_line(buffer: bytearray, begin: int) -> tuple[int, int]:
    """Where the headers end, and how long the blank line behind them is; (-1, 0) when it has not come."""
    places = [(at, len(blank)) for blank in (b"\n\r\n", b"\n\n") if (at := buffer.find(blank, begin)) >= 0]
    return min(places, default=(-1, 0))


def _headers(block: bytes) -> dict[str, str]:
    pairs = (line.decode("latin-1").partition(":") for line in block.splitlines())
    return {name.strip().lower(): value.strip() for name, colon, value in pairs if colon}


def _length(headers: Mapping[str, str]) -> int | None:
    text = headers.get("content-length", "")
    return int(text) if text.isascii() and text.isdigit() and 0 < int(text) <= _MOST_PART else None
