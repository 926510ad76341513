"""A network camera on loopback that speaks RTSP (RFC 2326) and sends JPEG pictures in RTP over the same connection (RFC 2435)."""

import contextlib
import itertools
import re
import socketserver
import struct
import threading

_PAYLOAD_TYPE = 26
_MOST_BYTES = 1400
_CLOCK_HZ = 90_000


class RtspCamera:
    """Sends `picture`, a colour JPEG with 4:2:0 subsampling, at `rate_hz`. `silent` keeps the connection and sends no more."""

    def __init__(self, picture: bytes, width: int, height: int, rate_hz: float = 30.0) -> None:
        self.rate_hz = rate_hz
        self.silent = False
        self._packets = _Packets(picture, width, height)
        self._ended = threading.Event()
        camera = self

        class Handler(socketserver.StreamRequestHandler):
            def handle(self) -> None:
                with contextlib.suppress(OSError):  # the other end hung up
                    camera.converse(self)

        class Server(socketserver.ThreadingTCPServer):
            allow_reuse_address = True
            daemon_threads = True

        self._server = Server(("127.0.0.1", 0), Handler)
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.02})
        self._thread.start()

    @property
    def url(self) -> str:
        return f"rtsp://127.0.0.1:{self._server.server_address[1]}/stream"

    def close(self) -> None:
        self._ended.set()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def converse(self, request: socketserver.StreamRequestHandler) -> None:
        """Answers requests until PLAY, then sends."""
        while True:
            lines = [line := request.rfile.readline().decode().strip()]
            while line:
                lines.append(line := request.rfile.readline().decode().strip())
            if not lines[0]:
                return
            method = lines[0].split()[0]
            sequence = next(re.sub(r"\D", "", line) for line in lines if line.lower().startswith("cseq"))
            extra, body = "", ""
            if method == "OPTIONS":
                extra = "Public: OPTIONS, DESCRIBE, SETUP, PLAY, TEARDOWN\r\n"
            elif method == "DESCRIBE":
                body = f"v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=c\r\nt=0 0\r\nm=video 0 RTP/AVP {_PAYLOAD_TYPE}\r\na=control:0\r\n"
                extra = f"Content-Type: application/sdp\r\nContent-Length: {len(body)}\r\n"
            elif method == "SETUP":
                extra = "Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\nSession: 1\r\n"
            elif method == "PLAY":
                extra = "Session: 1\r\n"
            request.wfile.write(f"RTSP/1.0 200 OK\r\nCSeq: {sequence}\r\n{extra}\r\n{body}".encode())
            if method == "PLAY":
                self._play(request)
                return
            if method == "TEARDOWN":
                return

    def _play(self, request: socketserver.StreamRequestHandler) -> None:
        for number in itertools.count():
            if not self.silent:
                for packet in self._packets.of_frame(round(number * _CLOCK_HZ / self.rate_hz)):
                    request.wfile.write(struct.pack(">cBH", b"$", 0, len(packet)) + packet)
            if self._ended.wait(1 / self.rate_hz):
                return


class _Packets:
    """A picture cut into RTP packets: its tables once, then the scan in parts."""

    def __init__(self, picture: bytes, width: int, height: int) -> None:
        self._size = bytes([width // 8, height // 8])
        tables: list[bytes] = []
        at = 2
        while picture[at + 1] != 0xDA:
            length = int.from_bytes(picture[at + 2 : at + 4], "big")
            if picture[at + 1] == 0xDB:
                body = picture[at + 4 : at + 2 + length]
                tables += [body[i + 1 : i + 65] for i in range(0, len(body), 65)]
            at += 2 + length
        at += 2 + int.from_bytes(picture[at + 2 : at + 4], "big")
        self._scan = picture[at : picture.rindex(b"\xff\xd9")]
        joined = b"".join(tables)
        self._tables = struct.pack(">BBH", 0, 0, len(joined)) + joined
        self._sequence = itertools.count()

    def of_frame(self, timestamp: int) -> list[bytes]:
        """The packets, the last of them marked."""
        packets: list[bytes] = []
        for offset in range(0, len(self._scan), _MOST_BYTES):
            part = self._scan[offset : offset + _MOST_BYTES]
            last = offset + _MOST_BYTES >= len(self._scan)
            rtp = struct.pack(
                ">BBHII", 0x80, _PAYLOAD_TYPE | (0x80 if last else 0), next(self._sequence) & 0xFFFF, timestamp, 7
            )
            kind, quality = 1, 255  # 4:2:0; the tables come along
            jpeg = b"\0" + offset.to_bytes(3, "big") + bytes([kind, quality]) + self._size
            packets.append(rtp + jpeg + (self._tables if offset == 0 else b"") + part)
        return packets
