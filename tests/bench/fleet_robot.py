"""One robot of the load generator, as its agent would talk: bytes of statuses out, bytes of the command stream in. No I/O."""

from dataclasses import dataclass, field

from msgspec import Struct
from msgspec.json import Decoder

from protocol.datagram import Kind, pack_payload
from tests.bench.fleet_lab import AREA

_COMMAND = b"event: command\ndata: "
_STOP = b"event: emergency_stop\ndata: "
_END = b"\n\n"
_PIECE_END = _END + b"\r\n"


class Order(Struct):
    """What of a command an agent looks at before anything else; the rest is left out."""

    epoch: int
    sequence: int
    stamp_ns: int
    deadline_ns: int


_ORDERS = Decoder(Order)


@dataclass(slots=True)
class CommandReader:
    """Takes the bytes of a robot's stream of server-sent events as they come; `told` once the state of the emergency stop was
    heard. The server sends each event in one piece, so that the lengths of pieces between them are as good as comments."""

    told: bool = False
    _rest: bytes = b""

    def take(self, data: bytes) -> list[Order]:
        """The commands that are complete now, in order."""
        if self._rest:
            data, self._rest = self._rest + data, b""
        if not self.told:
            begin = data.find(_STOP)
            if begin < 0 or data.find(_END, begin) < 0:
                self._rest = data
                return []
            self.told = True
        orders: list[Order] = []
        begin = data.find(_COMMAND)
        while begin >= 0:
            end = data.find(_END, begin)
            if end < 0:
                self._rest = data[begin:]
                return orders
            orders.append(_ORDERS.decode(data[begin + len(_COMMAND) : end]))
            begin = data.find(_COMMAND, end)
        # The last bytes may begin a command, unless a piece ends with them.
        self._rest = b"" if data.endswith(_PIECE_END) else data[-(len(_COMMAND) - 1) :]
        return orders


@dataclass(slots=True)
class Reporter:
    """Makes a robot's status datagrams, signed as its agent's are: those of a robot that stands at (x, y) and obeys. `sequence`
    is the next one's."""

    robot: str
    x: float
    y: float
    key: bytes
    sequence: int
    order: Order | None = None
    heard_ns: int = 0
    _about: bytes = field(init=False)

    def __post_init__(self) -> None:
        self._about = (
            b'"x":%.6f,"y":%.6f,"yaw":0.25,"linear_mps":0.0,"angular_radps":0.0,"ip":"127.0.0.1","area":"%s","battery":0.83,'
            b'"mode":"AUTOMATIC","faults":[],' % (self.x, self.y, AREA.encode())
        )

    def datagram(self, now_ns: int) -> bytes:
        """The status of this moment."""
        number, self.sequence = self.sequence, self.sequence + 1
        if self.order is None:
            order, age, loss = b"null", b"null", b"null"
        else:
            order = b"[%d,%d]" % (self.order.epoch, self.order.sequence)
            age, loss = b"%.6f" % ((now_ns - self.heard_ns) / 1e9), b"0.0"
        payload = (
            b'{"robot":"%s","sequence":%d,"stamp_ns":%d,%s"command_order":%s,"stopped_by":null,"pose_age_s":0.05,'
            b'"command_age_s":%s,"command_loss":%s,"stop_epoch":null}'
            % (self.robot.encode(), number, now_ns, self._about, order, age, loss)
        )
        return pack_payload(Kind.STATUS, self.robot, number, now_ns, payload, self.key)
