"""Health as a pure function: what is missing since when, each cause said once."""

from collections.abc import Mapping
from datetime import UTC
from typing import Any

import pytest
from msgspec.structs import replace

from protocol.channels import CHANNELS, COMMANDS, POSES, Channel, Delivery, Instances
from protocol.messages import CameraState, IntakeState, ProcessState, Reason, ReasonCode, Status
from server.health import condition, health_view
from server.problems import HealthInputs
from server.views.health import Condition, HealthView, RedisView, UdpView, losses
from tests.server.samples import START_NS, camera_state
from tests.server.service import gulliver

LAB = gulliver()
NOW_NS = START_NS + 3600 * 10**9
ROBOTS = [vehicle.id for vehicle in LAB.vehicles]
CAMERAS = [camera.id for camera in LAB.cameras]
UDP = UdpView(
    listening=True,
    received=0,
    accepted=0,
    undecodable=0,
    wrong_kind=0,
    unknown_robot=0,
    wrong_sender=0,
    old=0,
    future=0,
    duplicate=0,
    out_of_order=0,
    last_problem=None,
)
SENDS_ALL = {
    Instances.CAMERA: CAMERAS,
    Instances.VEHICLE: ROBOTS,
    Instances.LAB: ["lab"],
    Instances.PROCESS: ["guidance"],
}


def all_fresh(age_s: float = 0.01) -> dict[str, dict[str, int]]:
    stamp_ns = NOW_NS - round(age_s * 1e9)
    return {channel.name: dict.fromkeys(SENDS_ALL[channel.per], stamp_ns) for channel in CHANNELS}


def judge(
    stamps: Mapping[str, Mapping[str, int]],
    cameras: dict[str, CameraState] | None = None,
    processes: dict[str, ProcessState] | None = None,
    redis: RedisView | None = None,
    **changes: Any,
) -> HealthView:
    states = {camera: camera_state(camera, NOW_NS) for camera in CAMERAS} if cameras is None else cameras
    inputs = HealthInputs(
        started_ns=START_NS,
        stamps=stamps,
        camera_states=states,
        processes=processes or {},
        redis=redis or RedisView(reachable=True, since_ns=None),
        udp=changes.pop("udp", UDP),
        zone=UTC,
        **changes,
    )
    return health_view(LAB, inputs, NOW_NS)


def texts(view: HealthView) -> list[str]:
    return [problem.text for problem in view.problems]


def without(stamps: dict[str, dict[str, int]], instance: str, *channels: str) -> dict[str, dict[str, int]]:
    return {
        name: {key: stamp for key, stamp in entries.items() if not (name in channels and key == instance)}
        for name, entries in stamps.items()
    }


def late(stamps: dict[str, dict[str, int]], instance: str, age_s: float, *channels: str) -> dict[str, dict[str, int]]:
    changed = {name: dict(entries) for name, entries in stamps.items()}
    for channel in channels:
        changed[channel][instance] = NOW_NS - round(age_s * 1e9)
    return changed


def test_all_is_well() -> None:
    view = judge(all_fresh())
    assert (view.state, view.problems) == ("ok", ())
    latest = [channel for channel in CHANNELS if channel.delivery is Delivery.LATEST]
    assert {row.channel for row in view.channels} == {channel.name for channel in latest}
    assert all(row.condition in (Condition.OK, Condition.IDLE) for row in view.channels)


def test_an_empty_system_says_why() -> None:
    view = judge({}, cameras={})
    assert view.state == "error"
    said = texts(view)
    assert "no camera process has ever run for cam2; start one with `python -m localization.camera cam2`" in said
    assert "no agent has ever connected for wifibot-14; start one with `python -m agents wifibot-14`" in said
    assert "guidance sends no commands: no robot moves" in said
    assert sum("obstacles" in text for text in said) == 1
    assert sum("the intake says nothing" in text for text in said) == 1
    assert len(said) == len(CAMERAS) + 1 + 1 + 1 + len(ROBOTS)
    assert all(row.age_s is None for row in view.channels)
    assert {row.condition for row in view.channels} == {Condition.MISSING, Condition.IDLE}


def test_a_camera_without_frames() -> None:
    view = judge(late(all_fresh(), "cam2", 600, "detections", "rasters"))
    assert texts(view) == ["no frames from cam2 since 23:03:20"]
    assert view.problems[0].since_ns == NOW_NS - 600 * 10**9
    assert (view.state, view.problems[0].source) == ("error", "cam2")
    (row,) = [row for row in view.channels if (row.channel, row.instance) == ("detections", "cam2")]
    assert (row.condition, row.age_s, row.since_ns) == (Condition.STALE, 600.0, NOW_NS - 600 * 10**9)


def test_a_camera_says_itself_what_is_wrong() -> None:
    cameras = {camera: camera_state(camera, NOW_NS) for camera in CAMERAS}
    cameras["cam1"] = camera_state("cam1", NOW_NS, "frame of 640 x 480, the lab file says 1920 x 1080")
    view = judge(late(all_fresh(), "cam1", 90000, "detections", "rasters"), cameras)
    (text,) = texts(view)
    assert text.startswith("cam1: frame of 640 x 480, the lab file says 1920 x 1080, since 2023-11-13 ")


def test_a_camera_says_since_when() -> None:
    cameras = {camera: camera_state(camera, NOW_NS) for camera in CAMERAS}
    since_ns = NOW_NS - 3_200_000_000
    cameras["cam2"] = replace(camera_state("cam2", NOW_NS, "no frame for 3.2 s"), error_since_ns=since_ns)
    (problem,) = judge(late(all_fresh(), "cam2", 3.2, "detections"), cameras).problems
    assert problem.text == "cam2: no frame for 3.2 s, since 23:13:16"
    assert (problem.severity, problem.source, problem.since_ns) == ("error", "cam2", since_ns)


def test_a_dead_camera_process_is_said_once() -> None:
    view = judge(late(all_fresh(), "cam0", 10, "detections", "rasters", "camera_states"))
    assert texts(view) == ["nothing heard from the process of cam0 since 23:13:10"]


def test_a_robot_fell_silent() -> None:
    view = judge(late(all_fresh(), "wifibot-15", 30, "statuses", "registrations"))
    assert texts(view) == ["no status from wifibot-15 since 23:12:50"]


def test_a_robot_registered_but_its_datagrams_do_not_arrive() -> None:
    view = judge(without(all_fresh(), "wifibot-15", "statuses"))
    (text,) = texts(view)
    assert text.startswith("wifibot-15 has registered but sends no status datagrams")


def test_a_robot_out_of_sight_is_a_warning() -> None:
    view = judge(late(all_fresh(), "turtlebot-16", 5, "poses"))
    assert (view.state, texts(view)) == ("warning", ["no camera has seen turtlebot-16 since 23:13:15"])
    view = judge(without(all_fresh(), "turtlebot-16", "poses"))
    assert texts(view) == ["no camera has ever seen turtlebot-16"]


def test_without_cameras_robots_out_of_sight_go_unsaid() -> None:
    stamps = all_fresh()
    for name in [*CAMERAS]:
        stamps = late(stamps, name, 60, "detections", "rasters")
    for name in ROBOTS:
        stamps = late(stamps, name, 60, "poses")
    assert all("seen" not in text for text in texts(judge(stamps)))


def test_guidance_is_gone() -> None:
    stamps = all_fresh()
    for index, robot in enumerate(ROBOTS):
        stamps = late(stamps, robot, 10 + index, "commands", "guidance")
    assert texts(judge(stamps)) == ["guidance sends no commands since 23:13:10: no robot moves"]
    assert texts(judge(late(all_fresh(), ROBOTS[0], 10, "commands"))) == [
        f"guidance sends no commands to {ROBOTS[0]} since 23:13:10"
    ]


def test_processes() -> None:
    def process(name: str, state: Any, stamp_ns: int = NOW_NS) -> ProcessState:
        return ProcessState(
            name=name, state=state, pid=1, restarts=1, since_ns=NOW_NS - 10**9, stamp_ns=stamp_ns, last_error="signal 9"
        )

    processes = {
        "guidance": process("guidance", "restarting"),
        "scene": process("scene", "stopped"),
        "mapper": process("mapper", "running"),
        "forgotten": process("forgotten", "restarting", NOW_NS - 3600 * 10**9),
    }
    view = judge(all_fresh(), processes=processes)
    assert texts(view) == [
        "guidance died since 23:13:19 and is being restarted: signal 9",
        "scene has ended since 23:13:19: signal 9",
    ]
    assert [each.name for each in view.processes] == sorted(processes)


def test_redis_is_gone_and_nothing_else_matters() -> None:
    view = judge({}, cameras={}, redis=RedisView(reachable=False, since_ns=NOW_NS - 5 * 10**9))
    (text,) = texts(view)
    assert text.startswith("Redis is out of reach since 23:13:15")
    assert view.state == "error"


def test_an_intake_that_is_silent_is_named_instead_of_each_robot() -> None:
    stamps = all_fresh()
    for robot in ROBOTS:
        stamps = late(stamps, robot, 10, "statuses")
    (problem,) = judge(late(stamps, "lab", 10, "intake")).problems
    assert (problem.source, problem.severity) == ("intake", "error")
    assert problem.text == "the intake says nothing since 23:13:10: no robot's status datagrams are heard"
    assert len(texts(judge(stamps))) == len(ROBOTS)


def test_counts_and_losses_are_the_intakes_newest() -> None:
    counts = dict.fromkeys(UDP.model_dump(exclude={"listening", "last_problem"}), 3)
    state = IntakeState(stamp_ns=NOW_NS, last_problem="x", losses={ROBOTS[0]: 0.25}, **counts)
    view = UdpView.of(state, NOW_NS)
    assert (view.listening, view.received, view.out_of_order, view.last_problem) == (True, 3, 3, "x")
    assert losses(state, NOW_NS) == {ROBOTS[0]: 0.25}
    later_ns = NOW_NS + 6 * 10**9
    assert UdpView.of(state, later_ns) == view.model_copy(update={"listening": False})
    assert losses(state, later_ns) == losses(None, NOW_NS) == {}
    assert UdpView.of(None, NOW_NS) == UDP.model_copy(update={"listening": False})


@pytest.mark.parametrize(
    ("channel", "age", "expected"),
    [
        (POSES, None, Condition.MISSING),
        (POSES, 0.0, Condition.OK),
        (POSES, 0.25, Condition.OK),
        (POSES, 0.26, Condition.WARN),
        (POSES, 0.5, Condition.WARN),
        (POSES, 0.501, Condition.STALE),
        (COMMANDS, 0.1, Condition.OK),
    ],
)
def test_conditions_by_age(channel: Channel[Any], age: float | None, expected: Condition) -> None:
    assert condition(channel, age) is expected


def test_no_channel_warns_at_its_own_rate() -> None:
    for channel in CHANNELS:
        if channel.rate_hz:
            assert condition(channel, 1 / channel.rate_hz) is Condition.OK, channel.name


def test_ground_truth_is_expected_of_simulations_only() -> None:
    real = LAB.model_copy(
        update={
            "cameras": tuple(camera.model_copy(update={"source": "0"}) for camera in LAB.cameras),
            "vehicles": tuple(vehicle.model_copy(update={"driver": "real"}) for vehicle in LAB.vehicles),
        }
    )
    inputs = HealthInputs(START_NS, all_fresh(), {}, {}, RedisView(reachable=True, since_ns=None), UDP, UTC)
    rows = health_view(real, inputs, NOW_NS).channels
    assert "ground_truth" not in {row.channel for row in rows}


def test_a_robot_s_battery_faults_and_losses_are_told() -> None:
    robot = "wifibot-14"
    heard = Status(robot=robot, sequence=1, stamp_ns=NOW_NS, linear_mps=0.0, angular_radps=0.0, battery=0.15)
    view = judge(all_fresh(), statuses={robot: heard}, losses={robot: 0.31})
    assert texts(view) == [
        "wifibot-14 has 15% of its battery left",
        "31% of the statuses of wifibot-14 are lost on their way here",
    ]
    assert view.state == "warning"
    stop = Reason(code=ReasonCode.DRIVER_FAULT, text="motor hot", since_ns=NOW_NS - 2_000_000_000)
    worse = heard.model_copy(
        update={"battery": 0.04, "faults": ("motor hot",), "stopped_by": stop, "command_loss": 0.5}
    )
    view = judge(all_fresh(), statuses={robot: worse})
    assert texts(view)[0].startswith("wifibot-14: motor hot since ")
    assert texts(view)[1:] == [
        "wifibot-14 has 4% of its battery left: it drives no route any more",
        "50% of the commands for wifibot-14 do not reach it in time",
    ]
    assert [problem.severity for problem in view.problems] == ["error", "error", "warning"]
    assert view.problems[0].since_ns == stop.since_ns
    well = heard.model_copy(update={"battery": 0.9, "command_loss": 0.05})
    assert texts(judge(all_fresh(), statuses={robot: well}, losses={robot: 0.02})) == []
