"""A network camera that sends JPEG pictures over HTTP, one after the other (`multipart/x-mixed-replace`).

Read here rather than by OpenCV's network backend, which buffers frames, waits inside a call for as long as it likes, does
not say when a picture came, and makes every colour first. Pictures carry the camera's own stamp (`X-Timestamp`) where it
sends one, else the time at which their first byte came.
"""

import logging
from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack
from urllib.parse import unquote, urlsplit

import httpx

from localization.sources.base import BrokenFrameError, CaptureError
from localization.sources.jpeg import decode_jpeg
from localization.sources.multipart import MultipartParser, Part, boundary_of
from localization.sources.remote_clock import RemoteClock
from protocol.clock import Clock
from protocol.frames import Frame
from protocol.lab import CameraSpec
from protocol.lab.address import without_password

_CONNECT_S, _SILENCE_S = 5.0, 3.0
_NO_PICTURE_S = 5.0
"""Bytes that make no picture for so long: the stream is begun anew."""
_PATIENCE_S = 0.25
_LATEST_S = 2.0**33
"""Stamps beyond it (the year 2242) are none."""
_logger = logging.getLogger(__name__)


class NotMjpegError(CaptureError):
    """The address answers with something else than a stream of JPEG pictures; `content_type` says what."""

    def __init__(self, text: str, content_type: str) -> None:
        super().__init__(text)
        self.content_type = content_type


class MjpegCapture:
    """One connection. CaptureError, also from the constructor, when the camera does not answer, refuses or falls silent.

    User and password of the URL are sent when the camera asks for them and as it does, by Digest where it offers that."""

    def __init__(self, url: str, spec: CameraSpec, clock: Clock) -> None:
        self._name, self._color, self._clock = without_password(url), spec.color, clock
        self._stack = ExitStack()
        try:
            response = self._connect(url)
            content_type = response.headers.get("content-type", "")
            boundary = boundary_of(content_type)
            if boundary is None:
                said = content_type or "no content type"
                raise NotMjpegError(f"{self._name} answers with {said}, not with an MJPEG stream", content_type)
        except BaseException:
            self._stack.close()
            raise
        self._parser = MultipartParser(boundary)
        self._chunks = response.iter_raw()
        self._parts: deque[tuple[Part, int]] = deque()
        self._remote: RemoteClock | None = RemoteClock()
        self._newest_remote_ns = 0
        self._number = 0
        self._begun_ns: int | None = None
        self._last_picture_s = clock.monotonic_s()

    def read(self) -> Frame | None:
        start_s = self._clock.monotonic_s()
        while not self._parts:
            self._take_chunk()
            now_s = self._clock.monotonic_s()
            if not self._parts and now_s - self._last_picture_s > _NO_PICTURE_S:
                raise CaptureError(f"{self._name} has sent no whole picture for {now_s - self._last_picture_s:.0f} s")
            if not self._parts and now_s - start_s > _PATIENCE_S:
                return None
        part, came_ns = self._parts.popleft()
        self._number += 1
        if not part.whole:
            raise BrokenFrameError(f"{self._name} sent {len(part.body)} bytes that are no whole picture")
        begin_s = self._clock.monotonic_s()
        pixels = decode_jpeg(part.body, color=self._color)
        self._last_picture_s = self._clock.monotonic_s()
        stamp_ns = self._stamp_ns(part, came_ns)
        return Frame(self._number, stamp_ns, pixels, (self._last_picture_s - begin_s) * 1e3)

    def close(self) -> None:
        self._stack.close()

    def _connect(self, url: str) -> httpx.Response:
        """The answer to a GET with the credentials that it wants."""
        timeout = httpx.Timeout(_SILENCE_S, connect=_CONNECT_S)
        # Cameras are in the lab's own network: no proxy of the environment leads there.
        client = self._stack.enter_context(httpx.Client(timeout=timeout, trust_env=False, follow_redirects=True))
        parts = urlsplit(url)
        user, password = unquote(parts.username or ""), unquote(parts.password or "")
        try:
            response = self._send(client, None)
            wanted = response.headers.get("www-authenticate", "").lower() if response.status_code == 401 else ""
            if user and "digest" in wanted:  # never Basic to a camera that need not be told the password
                response.close()
                response = self._send(client, httpx.DigestAuth(user, password))
            elif user and "basic" in wanted:
                response.close()
                response = self._send(client, httpx.BasicAuth(user, password))
        except (httpx.HTTPError, httpx.InvalidURL, ValueError) as error:
            raise CaptureError(f"{self._name} cannot be opened: {error or type(error).__name__}") from error
        if response.status_code != 200:
            raise CaptureError(
                f"{self._name} cannot be opened: it answers {response.status_code} {response.reason_phrase}"
            )
        return response

    def _send(self, client: httpx.Client, auth: httpx.Auth | None) -> httpx.Response:
        response = client.send(httpx.Request("GET", self._name), stream=True, auth=auth)
        self._stack.callback(response.close)
        return response

    def _take_chunk(self) -> None:
        """Waits for bytes, at most for `_SILENCE_S`, and puts aside the parts that they complete."""
        try:
            data = next(self._chunks, None)
        except httpx.TimeoutException as error:
            raise CaptureError(f"{self._name} has sent nothing for {_SILENCE_S:.0f} s") from error
        except (httpx.HTTPError, httpx.StreamError) as error:
            raise CaptureError(f"{self._name} broke off: {error or type(error).__name__}") from error
        if data is None:
            raise CaptureError(f"{self._name} gives no more frames")
        self._parts.extend(self._stamped(data, self._clock.now_ns()))

    def _stamped(self, data: bytes, now_ns: int) -> Iterator[tuple[Part, int]]:
        """Parts with the time at which their first bytes came."""
        for part in self._parser.feed(data):
            yield part, now_ns if self._begun_ns is None else self._begun_ns
            self._begun_ns = None
        if self._begun_ns is None and self._parser.in_part:
            self._begun_ns = now_ns

    def _stamp_ns(self, part: Part, came_ns: int) -> int:
        """The camera's stamp in our time; its arrival when it bears none, or once stamps have failed to tell pictures apart."""
        try:
            remote_s = float(part.headers.get("x-timestamp", ""))
        except ValueError:
            return came_ns
        if self._remote is None or not 0 < remote_s < _LATEST_S:
            return came_ns
        remote_ns = round(remote_s * 1e9)
        if remote_ns <= self._newest_remote_ns:
            # Whole seconds, or a clock that stands: two pictures of one time would count as one.
            _logger.warning(
                "%s stamps pictures that follow each other with %s and %s; they are stamped on arrival",
                self._name,
                self._newest_remote_ns / 1e9,
                remote_s,
            )
            self._remote = None
            return came_ns
        self._newest_remote_ns = remote_ns
        return self._remote.local_ns(remote_ns, came_ns)
