"""Health from the channel table: how old everything is, and in sentences what is missing since when (spec console).

A pure function of the lab description, the stamps of the newest messages, and the time.
"""

from collections.abc import Generator, Iterator, Mapping
from typing import Any, cast

from protocol.channels import (
    CHANNELS,
    GROUND_TRUTH,
    LAB_INSTANCE,
    OBSTACLES,
    REGISTRATIONS,
    Channel,
    Delivery,
    Instances,
)
from protocol.lab import GPSS_DRIVER, Lab
from server.problems import HealthInputs, Problems
from server.views.base import age_s
from server.views.health import ChannelView, Condition, HealthView, ProblemView

_ROWS_AT_ONCE = 200


def health_view(lab: Lab, inputs: HealthInputs, now_ns: int) -> HealthView:
    """The health of the lab at `now_ns`."""
    steps = health_in_steps(lab, inputs, now_ns)
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return cast("HealthView", done.value)


def health_in_steps(lab: Lab, inputs: HealthInputs, now_ns: int) -> Generator[None, None, HealthView]:
    """The same in short steps: that of a thousand robots has seven thousand rows, and a server that makes them in one go says
    nothing to anybody meanwhile."""
    rows, problems = list[ChannelView](), list[ProblemView]()
    for row in _rows(lab, inputs, now_ns):
        rows.append(row)
        if len(rows) % _ROWS_AT_ONCE == 0:
            yield
    for problem in Problems(lab, inputs, rows, now_ns).all():
        problems.append(problem)
        if len(problems) % _ROWS_AT_ONCE == 0:
            yield
    severities = {problem.severity for problem in problems}
    return HealthView(
        state="error" if "error" in severities else "warning" if severities else "ok",
        stamp_ns=now_ns,
        started_ns=inputs.started_ns,
        redis=inputs.redis,
        channels=tuple(rows),
        processes=tuple(inputs.processes[name] for name in sorted(inputs.processes)),
        udp=inputs.udp,
        problems=tuple(problems),
    )


def condition(channel: Channel[Any], age: float | None) -> Condition:
    """How a message of that age (s; None: there never was one) is to be judged."""
    if channel.rate_hz == 0:
        return Condition.IDLE
    if age is None:
        return Condition.MISSING
    if age > channel.stale_after_s:
        return Condition.STALE
    late_s = max(channel.stale_after_s / 2, 1.5 / channel.rate_hz)
    return Condition.WARN if age > late_s else Condition.OK


def _rows(lab: Lab, inputs: HealthInputs, now_ns: int) -> Iterator[ChannelView]:
    for channel in CHANNELS:
        if channel.delivery is not Delivery.LATEST:
            continue
        stamps = inputs.stamps.get(channel.name, {})
        for instance in _expected(channel, lab, stamps):
            stamp_ns = stamps.get(instance)
            age = None if stamp_ns is None else age_s(stamp_ns, now_ns)
            judged = condition(channel, age)
            yield ChannelView(
                channel=channel.name,
                instance=instance,
                producer=channel.producer,
                condition=judged,
                age_s=age,
                stale_after_s=channel.stale_after_s,
                since_ns=stamp_ns if judged is Condition.STALE else None,
            )


def _expected(channel: Channel[Any], lab: Lab, stamps: Mapping[str, int]) -> tuple[str, ...]:
    if channel is GROUND_TRUTH and not lab.has_simulation:
        return ()
    if channel is OBSTACLES and not lab.cameras:
        return ()
    if channel is REGISTRATIONS:  # a robot that speaks GPSS over Redis has nothing to register
        return tuple(vehicle.id for vehicle in lab.vehicles if vehicle.driver != GPSS_DRIVER)
    match channel.per:
        case Instances.CAMERA:
            return tuple(camera.id for camera in lab.cameras)
        case Instances.VEHICLE:
            return tuple(vehicle.id for vehicle in lab.vehicles)
        case Instances.LAB:
            return (LAB_INSTANCE,)
        case Instances.PROCESS:
            return tuple(sorted(stamps))
