"""Poses as packets of the existing systems, one receiver (spec udp; spec localization, "Wire formats out").

A packet has what one update brought: the vehicles of one camera's frame, as the systems before sent them. Its fields:

- `x`, `y`, `z`, `theta`: of the *tag*, as from those systems (`point: vehicle` sends the rotation centre on the floor instead);
- `speed`: of the rotation centre over the floor, m/s, never negative;
- `time_msec`: of a detection its capture time, of the packet the newest of these;
- `camera_id`: the first camera that saw the vehicle in this update (of the packet: its first detection's), counted from 0 in
  the order of the lab description, as the reports' camera i;
- `average_gap`: mean of the last 64 gaps between updates to this receiver, ms, 0 before the second;
- `seq`: one more than the datagram before, from 0, modulo 2^32.
"""

import logging
import math
from collections import deque
from collections.abc import Iterable

from geometry import SE2
from localization.outputs.pace import Pace
from localization.outputs.resolving import Lookup, UnresolvedHostError, is_address, look_up, resolve
from localization.outputs.udp_sender import Address, Counts, UdpSender
from protocol.clock import Clock
from protocol.gulliview import GulliViewDetection, pack, split, to_wire
from protocol.lab import GulliViewOutput, Lab
from protocol.messages import TrackedPose

_logger = logging.getLogger(__name__)

_RETRY_S, _REFRESH_S = 5.0, 60.0
"""How long until a name that does not resolve is looked up again, and one that did."""
_GAPS = 64


class GulliViewReceiver:
    """Sends every pose to one receiver. A receiver by name is looked up anew now and then (`run`)."""

    def __init__(
        self, sender: UdpSender, clock: Clock, lab: Lab, output: GulliViewOutput, lookup: Lookup = look_up
    ) -> None:
        self._sender, self._clock, self._output, self._lookup = sender, clock, output, lookup
        self._pace = Pace(clock, output.rate_hz)
        self._tags = {vehicle.id: vehicle.tag for vehicle in lab.vehicles}
        self._cameras = {camera.id: number for number, camera in enumerate(lab.cameras)}
        self._address: Address | None = (output.host, output.port) if is_address(output.host) else None
        self._seq = 0
        self._gaps_ms: deque[float] = deque(maxlen=_GAPS)
        self._sent_s: float | None = None
        self._wrapped: set[str] = set()
        self.counts = Counts()

    async def run(self) -> None:
        """Keeps the receiver's address, until cancelled."""
        told = False
        while True:
            try:
                self._address = await resolve(self._output.host, self._lookup), self._output.port
                told = False
            except UnresolvedHostError as error:
                if not told:
                    _logger.warning("no %s packets for %s: %s", self._output.layout, self._output.host, error)
                told = True
            await self._clock.sleep(_RETRY_S if told else _REFRESH_S)

    def send(self, poses: Iterable[TrackedPose]) -> None:
        """Sends what is due, in as many datagrams as it needs. Never blocks, never raises."""
        if self._address is None:
            return
        detections = [self._detection(pose) for pose in self._pace.due(poses)]
        if not detections:
            return
        packets = split(
            self._output.layout,
            self._seq,
            max(detection.time_msec for detection in detections),
            detections,
            average_gap=self._average_gap_ms(),
            camera_id=detections[0].camera_id,
        )
        self._seq = (self._seq + len(packets)) % 2**32
        for packet in packets:
            try:
                data = pack(self._output.layout, packet)
            except ValueError as error:
                self.counts.failed += 1
                _logger.warning("a packet for %s was not sent: %s", self._name, error)
                continue
            self._sender.send(data, self._address, self._name, self.counts)

    def describe(self) -> str:
        """What is sent to whom, for the log."""
        return f"{self._name}: {self.counts.sent} sent, {self.counts.failed} failed"

    @property
    def _name(self) -> str:
        return f"{self._output.layout} at {self._output.host}:{self._output.port}"

    def _detection(self, pose: TrackedPose) -> GulliViewDetection:
        tag = self._tags[pose.vehicle]
        place, height_m = SE2(pose.x, pose.y, pose.yaw), 0.0
        if self._output.point == "tag":
            place, height_m = place @ tag.pose_on_vehicle(), tag.height_m
        x, y, theta = to_wire(self._output.layout, place.x, place.y, place.yaw)
        if min(x, y) < 0 and pose.vehicle not in self._wrapped:
            self._wrapped.add(pose.vehicle)
            _logger.warning(
                "%s is at (%.2f, %.2f) m: receivers of %s packets read negative coordinates as huge positive ones",
                pose.vehicle,
                place.x,
                place.y,
                self._output.layout,
            )
        return GulliViewDetection(
            tag_id=tag.id,
            x=x,
            y=y,
            theta=theta,
            speed=math.hypot(pose.vx, pose.vy),
            camera_id=self._cameras.get(pose.cameras[0], 0) if pose.cameras else 0,
            time_msec=pose.stamp_ns // 1_000_000,
            z=round(height_m * 1000.0),
        )

    def _average_gap_ms(self) -> int:
        now_s = self._clock.monotonic_s()
        if self._sent_s is not None:
            self._gaps_ms.append((now_s - self._sent_s) * 1e3)
        self._sent_s = now_s
        return round(sum(self._gaps_ms) / len(self._gaps_ms)) if self._gaps_ms else 0
