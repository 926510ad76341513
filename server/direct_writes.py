"""A short way to the listeners of streams: uvicorn's protocol with an ASGI extension by which an answer that has begun takes one
more piece at once. On the usual way each piece passes a generator, a task and every middleware; for the commands of a thousand
robots that was most of what the server did."""

from collections.abc import Callable, Mapping
from typing import Any, cast

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

Write = Callable[[bytes], bool]
"""Whether the piece was taken; if not it is to go the usual way."""
_EXTENSION = "lilliput.direct_write"


class DirectWriteProtocol(HttpToolsProtocol):
    """HTTP/1.1 as uvicorn speaks it. What it adds to a request's scope `direct_write` finds."""

    def on_message_begin(self) -> None:
        super().on_message_begin()
        self.scope["extensions"] = {_EXTENSION: {"write": self._write_piece}}

    def _write_piece(self, data: bytes) -> bool:
        """Only into a chunked answer that has begun, and while all that was written before is with the kernel: nothing piles up
        for a client that does not listen, and nothing overtakes."""
        cycle, transport = self.cycle, self.transport
        if not cycle.chunked_encoding or cycle.response_complete or cycle.disconnected:
            return False
        if transport.is_closing() or transport.get_write_buffer_size():
            return False
        transport.write(b"%x\r\n%b\r\n" % (len(data), data))
        return True


def direct_write(scope: Mapping[str, Any]) -> Write | None:
    """The short way into the answer to a request; None where the server has none."""
    extension = scope.get("extensions", {}).get(_EXTENSION)
    return None if extension is None else cast("Write", extension["write"])
