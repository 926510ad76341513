"""A network camera on loopback, MJPEG over HTTP, that misbehaves on request."""

import base64
import hashlib
import re
import threading
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Literal
from urllib.parse import unquote

import cv2
import numpy as np
from numpy.typing import NDArray

Mood = Literal[
    "well", "absent", "hanging", "garbage", "truncated", "between", "breaking off", "silent", "no lengths", "html"
]

_NONCE = "5ca1ab1e"


def _md5(text: str) -> str:
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()


def jpeg(pixels: NDArray[np.uint8], quality: int = 90) -> bytes:
    """The picture as a camera sends it."""
    ok, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert ok
    return data.tobytes()


class MjpegCamera:
    """Sends `picture` at `rate_hz` while `mood` is `well`. Others: `absent` answers 503; `hanging` stops in the middle of a
    picture and keeps the connection; `silent` connects and sends nothing; `garbage` sends bytes in place of pictures;
    `between` bytes between them; `truncated` half pictures; `breaking off` ends the connection within a picture; `no lengths`
    leaves Content-Length away; `html` answers with a page. `stamp` makes an X-Timestamp for each picture.

    With `user` (`name:password` as in a URL) it wants to know who asks, by one of `schemes`; `told` are the Authorization
    headers that came."""

    def __init__(
        self,
        picture: bytes,
        rate_hz: float = 50.0,
        *,
        user: str | None = None,
        schemes: tuple[Literal["Basic", "Digest"], ...] = ("Basic",),
    ) -> None:
        self.picture, self.rate_hz, self.user, self.schemes = picture, rate_hz, user, schemes
        self.mood: Mood = "well"
        self.stamp: Callable[[], str] | None = None
        self.connections = 0
        self.told: list[str | None] = []
        self._ended = threading.Event()
        camera = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                camera.answer(self)

            def log_message(self, format: str, *args: object) -> None:  # noqa: A002  # the base class's name
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.02})
        self._thread.start()

    @property
    def url(self) -> str:
        user = f"{self.user}@" if self.user else ""
        return f"http://{user}127.0.0.1:{self._server.server_address[1]}/video"

    def close(self) -> None:
        self._ended.set()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def answer(self, request: BaseHTTPRequestHandler) -> None:
        self.connections += 1
        if self.mood == "absent":
            request.send_error(503)
            return
        self.told.append(request.headers.get("Authorization"))
        if self.user is not None and not self._knows(self.told[-1], request.path):
            request.send_response(401)
            if "Basic" in self.schemes:
                request.send_header("WWW-Authenticate", 'Basic realm="camera"')
            if "Digest" in self.schemes:
                request.send_header("WWW-Authenticate", f'Digest realm="camera", nonce="{_NONCE}", qop="auth"')
            request.send_header("Content-Length", "0")
            request.end_headers()
            return
        kind = "text/html" if self.mood == "html" else "multipart/x-mixed-replace; boundary=frame"
        request.send_response(200)
        request.send_header("Content-Type", kind)
        request.end_headers()
        try:
            while not self._ended.is_set() and self.mood not in ("absent", "html"):
                if not self._send(request):
                    return
                self._ended.wait(1 / self.rate_hz)
        except OSError:
            pass  # the other end hung up

    def _knows(self, authorization: str | None, path: str) -> bool:
        """Whether the header proves knowledge of user and password (RFC 7617, RFC 7616 with MD5)."""
        name, _, password = unquote(self.user or "").partition(":")
        scheme, _, said = (authorization or "").partition(" ")
        if scheme not in self.schemes:
            return False
        if scheme == "Basic":
            return base64.b64decode(said).decode() == f"{name}:{password}"
        given = dict(re.findall(r'(\w+)="?([^",]+)"?', said))
        secret, asked = _md5(f"{name}:camera:{password}"), _md5(f"GET:{path}")
        proof = _md5(f"{secret}:{_NONCE}:{given['nc']}:{given['cnonce']}:auth:{asked}")
        return (given["username"], given["response"]) == (name, proof)

    def _send(self, request: BaseHTTPRequestHandler) -> bool:
        """One picture; False to end the connection."""
        data, mood = self.picture, self.mood
        if mood == "silent":
            return True
        length = b"" if mood == "no lengths" else b"Content-Length: %d\r\n" % len(data)
        stamp = b""
        if self.stamp is not None:
            stamp = b"X-Timestamp: %s\r\n" % self.stamp().encode()
        if mood == "garbage":
            data = np.random.default_rng(1).integers(0, 256, len(data), np.uint8).tobytes()
        elif mood == "truncated":
            data = data[: len(data) // 2]
        if mood == "between":
            request.wfile.write(b"\x00\xffnoise" * 100)
        head = b"--frame\r\nContent-Type: image/jpeg\r\n" + length + stamp + b"\r\n"
        if mood in ("hanging", "breaking off"):
            request.wfile.write(head + data[: len(data) // 2])
            while mood == "hanging" and self.mood == mood and not self._ended.wait(0.02):
                pass
            return False
        request.wfile.write(head + data + b"\r\n")
        return True
