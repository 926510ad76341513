"""The cable to a base of the simulated lab, for robots that have software of their own: DRIVE out, ODOMETRY in, by the documented
datagrams (docs/architecture.md, "The simulated base"). Blocking calls, a thread of its own."""

import os
import socket
import threading
import time

from protocol.datagram import Datagram, Sequencer, pack, unpack
from protocol.errors import DecodeError
from protocol.messages import DriveSetpoint, Odometry


class SimulatedBase:
    """`drive` holds a twist; `odometry` is the newest, `twist` what the wheels really do."""

    def __init__(self, vehicle: str) -> None:
        self.twist = (0.0, 0.0)
        self.odometry: Odometry | None = None
        self._vehicle = vehicle
        self._key = bytes.fromhex(os.environ["LILLIPUT_UDP_KEY"])
        self._sequencer = Sequencer(time.time_ns())
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", int(os.environ["LAB_UDP_PORT"])))
        self.drive(0.0, 0.0)
        threading.Thread(target=self._hear, daemon=True).start()

    def drive(self, linear: float, angular: float) -> None:
        number = self._sequencer.next()
        setpoint = DriveSetpoint(self._vehicle, number, linear, angular)
        try:
            self._socket.send(pack(Datagram(self._vehicle, number, time.time_ns(), setpoint), self._key))
        except ConnectionError:  # the lab is not up yet
            return

    def _hear(self) -> None:
        while True:
            try:
                message = unpack(self._socket.recv(2048), self._key).message
            except (DecodeError, ConnectionError):
                continue
            if isinstance(message, Odometry) and message.vehicle == self._vehicle:
                self.odometry = message
                self.twist = message.linear_mps, message.angular_radps
