"""What is wrong with a lab, in sentences: what is missing since when (spec console). What follows from one cause is said once: of
a camera whose process is gone it is not also said that it sends no frames."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, tzinfo
from typing import Any, Literal

from protocol.channels import (
    CAMERA_STATES,
    COMMANDS,
    DETECTIONS,
    INTAKE,
    LAB_INSTANCE,
    OBSTACLES,
    POSES,
    PROCESSES,
    RASTERS,
    REGISTRATIONS,
    STATUSES,
    Channel,
)
from protocol.lab import GPSS_DRIVER, Lab, VehicleSpec
from protocol.messages import CameraState, ProcessState, Status
from server.views.base import age_s
from server.views.health import ChannelView, Condition, ProblemView, RedisView, UdpView

Stamps = Mapping[str, Mapping[str, int]]
"""Channel name -> instance -> stamp of its newest message (ns)."""
_BAD = (Condition.STALE, Condition.MISSING)
_LOSSY = 0.2
"""A share of messages lost that a person should know of."""


@dataclass(frozen=True, slots=True)
class HealthInputs:
    """What health is judged by; `zone` is the time zone of clock times in sentences, `losses` the share of each robot's statuses
    that did not arrive."""

    started_ns: int
    stamps: Stamps
    camera_states: Mapping[str, CameraState]
    processes: Mapping[str, ProcessState]
    redis: RedisView
    udp: UdpView
    zone: tzinfo | None = None
    statuses: Mapping[str, Status] = field(default_factory=dict[str, Status])
    losses: Mapping[str, float] = field(default_factory=dict[str, float])


class Problems:
    """The sentences, in the order in which an operator should read them."""

    def __init__(self, lab: Lab, inputs: HealthInputs, rows: Sequence[ChannelView], now_ns: int) -> None:
        self._lab, self._inputs, self._now_ns = lab, inputs, now_ns
        self._rows = {(row.channel, row.instance): row for row in rows}

    def all(self) -> Iterator[ProblemView]:
        if not self._inputs.redis.reachable:
            since_ns = self._inputs.redis.since_ns
            text = f"Redis is out of reach{self._since(since_ns)}: nothing can be changed, robots stop by themselves"
            yield _problem("error", "redis", since_ns, text)
            return
        yield from self._processes()
        for camera in self._lab.cameras:
            yield from self._camera(camera.id)
        if self._lab.cameras and self._bad(OBSTACLES, LAB_INSTANCE):
            since_ns = self._stamp(OBSTACLES, LAB_INSTANCE)
            text = f"no map of obstacles{self._since(since_ns)}: robots on routes wait (is the mapper running?)"
            yield _problem("error", "mapper", since_ns, text)
        yield from self._guidance()
        if self._bad(INTAKE, LAB_INSTANCE):
            since_ns = self._stamp(INTAKE, LAB_INSTANCE)
            text = f"the intake says nothing{self._since(since_ns)}: no robot's status datagrams are heard"
            yield _problem("error", "intake", since_ns, text)
        cameras_work = any(not self._bad(DETECTIONS, camera.id) for camera in self._lab.cameras)
        for vehicle in self._lab.vehicles:
            yield from self._robot(vehicle, cameras_work)

    def _processes(self) -> Iterator[ProblemView]:
        for name, process in sorted(self._inputs.processes.items()):
            if age_s(process.stamp_ns, self._now_ns) > PROCESSES.stale_after_s:
                continue
            if process.state == "restarting":
                last = f": {process.last_error}" if process.last_error else ""
                text = f"{name} died{self._since(process.since_ns)} and is being restarted{last}"
                yield _problem("error", name, process.since_ns, text)
            elif process.state == "stopped":
                last = f": {process.last_error}" if process.last_error else ""
                yield _problem(
                    "error", name, process.since_ns, f"{name} has ended{self._since(process.since_ns)}{last}"
                )

    def _camera(self, camera: str) -> Iterator[ProblemView]:
        state = self._inputs.camera_states.get(camera)
        if state is None or self._bad(CAMERA_STATES, camera):
            since_ns = self._stamp(CAMERA_STATES, camera)
            text = (
                f"no camera process has ever run for {camera}; start one with `python -m localization.camera {camera}`"
                if since_ns is None
                else f"nothing heard from the process of {camera}{self._since(since_ns)}"
            )
            yield _problem("error", camera, since_ns, text)
        elif not state.connected or state.error:
            since_ns = state.error_since_ns
            if since_ns is None and self._bad(DETECTIONS, camera):
                since_ns = self._stamp(DETECTIONS, camera)
            since = f",{self._since(since_ns)}" if since_ns else ""
            yield _problem("error", camera, since_ns, f"{camera}: {state.error or 'not connected'}{since}")
        elif self._bad(DETECTIONS, camera):
            since_ns = self._stamp(DETECTIONS, camera)
            yield _problem("error", camera, since_ns, f"no frames from {camera}{self._since(since_ns)}")
        elif self._bad(RASTERS, camera):
            since_ns = self._stamp(RASTERS, camera)
            yield _problem("warning", camera, since_ns, f"no obstacles from {camera}{self._since(since_ns)}")

    def _guidance(self) -> Iterator[ProblemView]:
        robots = [vehicle.id for vehicle in self._lab.vehicles]
        silent = [robot for robot in robots if self._bad(COMMANDS, robot)]
        stamps = [stamp for robot in silent if (stamp := self._stamp(COMMANDS, robot)) is not None]
        since_ns = max(stamps, default=None)
        if robots and silent == robots:
            text = f"guidance sends no commands{self._since(since_ns)}: no robot moves"
            yield _problem("error", "guidance", since_ns, text)
        elif silent:
            text = f"guidance sends no commands to {', '.join(silent)}{self._since(since_ns)}"
            yield _problem("error", "guidance", since_ns, text)

    def _robot(self, vehicle: VehicleSpec, cameras_work: bool) -> Iterator[ProblemView]:
        robot = vehicle.id
        registered, heard = self._stamp(REGISTRATIONS, robot), self._stamp(STATUSES, robot)
        if registered is None and heard is None:
            text = (
                f"{robot} has never written its status to Redis; it needs a user: `./lilliput token redis {robot}`"
                if vehicle.driver == GPSS_DRIVER
                else f"no agent has ever connected for {robot}; start one with `python -m agents {robot}`"
            )
            yield _problem("warning", robot, None, text)
        elif self._bad(STATUSES, robot) and (vehicle.driver == GPSS_DRIVER or not self._bad(INTAKE, LAB_INSTANCE)):
            text = (
                f"{robot} has registered but sends no status datagrams (is UDP let through, and the key the same?)"
                if heard is None
                else f"no status from {robot}{self._since(heard)}"
            )
            yield _problem("error", robot, heard, text)
        if cameras_work and self._bad(POSES, robot):
            since_ns = self._stamp(POSES, robot)
            text = (
                f"no camera has seen {robot}{self._since(since_ns)}" if since_ns else f"no camera has ever seen {robot}"
            )
            yield _problem("warning", robot, since_ns, text)
        if heard is not None and not self._bad(STATUSES, robot):
            yield from self._said_by(vehicle)

    def _said_by(self, vehicle: VehicleSpec) -> Iterator[ProblemView]:
        """What a robot that is heard says of itself, and how well it is heard."""
        robot, status = vehicle.id, self._inputs.statuses.get(vehicle.id)
        if status is None:
            return
        stop = status.stopped_by
        since_ns = None if stop is None else stop.since_ns
        for fault in status.faults:
            yield _problem("error", robot, since_ns, f"{robot}: {fault}{self._since(since_ns)}")
        if status.battery is not None and status.battery <= vehicle.battery.low:
            empty = status.battery <= vehicle.battery.empty
            text = f"{robot} has {status.battery:.0%} of its battery left{': it drives no route any more' if empty else ''}"
            yield _problem("error" if empty else "warning", robot, None, text)
        lost = self._inputs.losses.get(robot, 0.0)
        if lost > _LOSSY:
            yield _problem("warning", robot, None, f"{lost:.0%} of the statuses of {robot} are lost on their way here")
        if status.command_loss is not None and status.command_loss > _LOSSY:
            text = f"{status.command_loss:.0%} of the commands for {robot} do not reach it in time"
            yield _problem("warning", robot, None, text)

    def _bad(self, channel: Channel[Any], instance: str) -> bool:
        row = self._rows.get((channel.name, instance))
        return row is not None and row.condition in _BAD

    def _stamp(self, channel: Channel[Any], instance: str) -> int | None:
        return self._inputs.stamps.get(channel.name, {}).get(instance)

    def _since(self, stamp_ns: int | None) -> str:
        """ " since 12:03:10", with the day when that is another one; nothing when there is no stamp."""
        if stamp_ns is None:
            return ""
        moment = datetime.fromtimestamp(stamp_ns / 1e9, UTC).astimezone(self._inputs.zone)
        today = datetime.fromtimestamp(self._now_ns / 1e9, UTC).astimezone(self._inputs.zone)
        day = "" if moment.date() == today.date() else f"{moment:%Y-%m-%d} "
        return f" since {day}{moment:%H:%M:%S}"


def _problem(severity: Literal["warning", "error"], source: str, since_ns: int | None, text: str) -> ProblemView:
    return ProblemView(severity=severity, source=source, since_ns=since_ns, text=text)
