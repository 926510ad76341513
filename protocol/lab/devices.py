"""What stands in a lab: areas, cameras, tags, vehicles, zones, ports."""

import itertools
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from shapely.geometry import Point, Polygon

from geometry import SE2, CameraModel
from protocol.lab.base import (
    Family,
    Finite,
    Identifier,
    LabModel,
    NonNegative,
    Outline,
    PoseXYYaw,
    Positive,
    require_simple,
)
from protocol.lab.control import ControlSpec
from protocol.lab.protection import BatterySpec, ProtectiveFieldSpec, ScannerSpec
from protocol.messages.fleet import ZoneOutline, ZoneSpeed


class Area(LabModel):
    """A part of the floor that robots may use: a simple polygon in metres, map frame."""

    id: Identifier
    outline: Outline

    @model_validator(mode="after")
    def _simple(self) -> Self:
        require_simple(self.outline, "outline")
        return self

    def contains(self, x: float, y: float) -> bool:
        """Whether the point (metres, map frame) lies inside or on the border."""
        return bool(Polygon(self.outline).covers(Point(x, y)))


class Intrinsics(LabModel):
    """Pinhole parameters in pixels and k1, k2, p1, p2, k3 (OpenCV's order)."""

    fx: Positive
    fy: Positive
    cx: Finite
    cy: Finite
    distortion: tuple[Finite, Finite, Finite, Finite, Finite] = (0.0, 0.0, 0.0, 0.0, 0.0)


class CameraSpec(LabModel):
    """A ceiling camera. `source` is `sim`, a path, a URL, or a V4L2 device number."""

    id: Identifier
    area: Identifier
    source: str | int
    width: Annotated[int, Field(gt=0, le=16384)]
    height: Annotated[int, Field(gt=0, le=16384)]
    rate_hz: Annotated[float, Field(gt=0, le=1000)]
    color: bool = False
    intrinsics: Intrinsics

    def model(self) -> CameraModel:
        """The camera's parameters as geometry's data type."""
        i = self.intrinsics
        return CameraModel(self.width, self.height, i.fx, i.fy, i.cx, i.cy, i.distortion)


class FloorTags(LabModel):
    """Tags glued to the floor (z = 0) that tie the cameras to the map frame: id -> x, y (m), yaw (rad) of the tag's
    centre; yaw 0 means that the edge from its left-bottom to its right-bottom corner points along map +x."""

    family: Family = "tag36h11"
    size_m: Positive
    poses: dict[int, PoseXYYaw]


class VehicleTag(LabModel):
    """The tag on a vehicle's roof. `height_m` is its height above the floor; `offset` is x, y (m) and yaw (rad) of its
    centre seen from the vehicle's rotation centre."""

    family: Family = "tag36h11"
    id: Annotated[int, Field(ge=0)]
    size_m: Positive
    height_m: NonNegative
    offset: PoseXYYaw = (0.0, 0.0, 0.0)

    def pose_on_vehicle(self) -> SE2:
        """T_vehicle_tag in the plane."""
        return SE2(*self.offset)


class ObstacleBox(LabModel):
    """The blue box in front of a robot (spec gpss): where it starts ahead of the rotation centre, its length along the
    path and its width, in metres, and whether it ends at the next waypoint or runs past it. `robots` and `unknown` say whether
    other robots and floor that no camera sees count."""

    start_m: NonNegative = 1.0
    length_m: Positive = 1.0
    width_m: Positive = 0.6
    stop_at_waypoint: bool = False
    robots: bool = True
    unknown: bool = True


class Detours(LabModel):
    """Whether a robot drives around what blocks it, how long it waits before that (s), and what it keeps free beside itself
    then (m)."""

    enabled: bool = True
    after_s: NonNegative = 3.0
    clearance_m: NonNegative = 0.3


class Limits(LabModel):
    """What a vehicle can do: m/s, rad/s, m/s^2, rad/s^2; and how suddenly its controllers may change that, m/s^3, rad/s^3.
    Emergency stops brake at once and fully."""

    speed_mps: Positive = 0.5
    yaw_rate_radps: Positive = 1.0
    acceleration_mps2: Positive = 0.5
    braking_mps2: Positive = 2.0
    yaw_acceleration_radps2: Positive = 4.0
    jerk_mps3: Positive = 4.0
    yaw_jerk_radps3: Positive = 40.0


GPSS_DRIVER, ROS2_DRIVER = "gpss-redis", "ros2"
"""Drivers with a way of their own: a robot that speaks GPSS documents over Redis by itself, so that no agent of ours drives
it; and a base that speaks ROS 2 over DDS."""

RosDomain = Annotated[int, Field(ge=0, le=232)]
"""A DDS domain: its number times 250 is added to the ports, which end at 65535."""
_ROS_NAME = r"[a-zA-Z][a-zA-Z0-9]*(_[a-zA-Z0-9]+)*"
RosNamespace = Annotated[str, Field(pattern=rf"^{_ROS_NAME}(/{_ROS_NAME})*$", max_length=100)]
"""Names of ROS 2 with slashes between, without one at the beginning (/robot_1 is written robot_1)."""


class Ros2Base(LabModel):
    """Where on ROS 2 a vehicle with driver `ros2` is: the namespace of its topics (none: the vehicle's id, dashes as
    underscores, after `robot_` if it begins with a digit) and the DDS domain (none: ROS_DOMAIN_ID). `scan` says whether it has a
    laser scanner; `scan_pose` is the scanner's x, y (m) and yaw (rad) seen from the rotation centre."""

    namespace: RosNamespace | None = None
    domain: RosDomain | None = None
    scan: bool = True
    scan_pose: PoseXYYaw = (0.0, 0.0, 0.0)


class VehicleSpec(LabModel):
    """A robot. `footprint` is its outline in metres seen from its rotation centre (x forward, y left); `scanner` is its safety
    scanner, if the simulated lab is to have one (a ROS 2 base has its own, see `ros2`)."""

    id: Identifier
    kind: Literal["wifibot", "turtlebot", "agv", "freke"]
    footprint: Outline
    driver: Identifier = "sim"
    tag: VehicleTag
    limits: Limits = Limits()
    obstacle_box: ObstacleBox = ObstacleBox()
    detours: Detours = Detours()
    ros2: Ros2Base | None = None
    control: ControlSpec = ControlSpec()
    scanner: ScannerSpec | None = None
    protective_field: ProtectiveFieldSpec = ProtectiveFieldSpec()
    battery: BatterySpec = BatterySpec()

    @model_validator(mode="after")
    def _simple(self) -> Self:
        require_simple(self.footprint, "footprint")
        if self.ros2 is not None and self.driver != ROS2_DRIVER:
            raise ValueError(f"ros2 is for vehicles whose driver is {ROS2_DRIVER}, this one's is {self.driver}")
        return self

    @property
    def ros2_namespace(self) -> str:
        """As the lab description says, else made from the id, whose dashes ROS does not allow, nor a digit at the beginning,
        nor two underscores in a row, nor one at the end."""
        if self.ros2 is not None and self.ros2.namespace is not None:
            return self.ros2.namespace
        name = "_".join(part for part in self.id.replace("-", "_").split("_") if part)
        return name if name[0].isalpha() else f"robot_{name}"


class ZoneSpec(LabModel):
    """An exclusive zone cut into sub-areas (polygons in metres, map frame); vehicles nearer than `detection_m` matter."""

    id: Identifier
    detection_m: Positive
    subareas: dict[Identifier, Outline]

    @model_validator(mode="after")
    def _simple(self) -> Self:
        for name, outline in self.subareas.items():
            require_simple(outline, f"sub-area {name}")
        return self


class SpeedZoneSpec(LabModel):
    """A part of the floor (m, map frame) where robots drive no faster than `speed_mps`."""

    id: Identifier
    outline: ZoneOutline
    speed_mps: ZoneSpeed

    @model_validator(mode="after")
    def _simple(self) -> Self:
        require_simple(self.outline, f"speed zone {self.id}")
        return self


class Accuracy(LabModel):
    """How well the description was measured, as standard deviations: floor tags' x and y (m) and heading (rad), heights of the
    vehicles' tags (m), focal lengths (relative), principal points (px). Calibration weighs by them, and what they leave open is
    part of every pose's covariance."""

    floor_tag_m: Positive = 0.002
    floor_tag_rad: Positive = 0.005
    tag_height_m: Positive = 0.002
    focal: Annotated[float, Field(gt=0, lt=0.1)] = 0.001
    center_px: Positive = 1.0


Port = Annotated[int, Field(gt=0, lt=65536)]


class Output(LabModel):
    """One way for poses to leave: whether it is on, and how often each vehicle's pose goes (0: every update)."""

    enabled: bool = True
    rate_hz: Annotated[float, Field(ge=0, le=1000)] = 0.0


GulliViewLayout = Literal["gulliview-2021", "gulliview-2023", "gulliview-2025a", "gulliview-2025"]


class GulliViewOutput(Output):
    """A receiver of the existing systems' packets (spec udp): which layout it speaks, where it listens, and whether positions
    are the tag's, as from those systems, or the vehicle's rotation centre."""

    layout: GulliViewLayout
    host: Annotated[str, Field(min_length=1)]
    port: Port
    point: Literal["tag", "vehicle"] = "tag"


class Ros2Output(Output):
    """Poses as ROS 2 topics over DDS, off unless asked for; `domain` is the DDS domain (none: ROS_DOMAIN_ID)."""

    enabled: bool = False
    domain: RosDomain | None = None


class Outputs(LabModel):
    """Where tracked poses go: the bus (Redis), our datagrams to registered robots, packets of the existing systems, ROS 2."""

    redis: Output = Output()
    datagrams: Output = Output()
    gulliview: tuple[GulliViewOutput, ...] = ()
    ros2: Ros2Output = Ros2Output()


class Ports(LabModel):
    """Where the system listens: HTTP of the console and API, UDP from robots, the loopback-only port of the 3D scene,
    and UDP of the simulated lab's vehicles. Every robot's agent listens on `stop_udp` for emergency stops by broadcast. `redis`
    opens the private Redis to robots that speak GPSS (none: closed)."""

    http: Port = 8000
    robots_udp: Port = 2020
    scene: Port = 8010
    lab_udp: Port = 2030
    stop_udp: Port = 2040
    redis: Port | None = None

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        tcp, udp = ("http", "scene", "redis"), ("robots_udp", "lab_udp", "stop_udp")
        for a, b in (*itertools.combinations(tcp, 2), *itertools.combinations(udp, 2)):
            if getattr(self, a) == getattr(self, b):
                raise ValueError(f"{a} and {b} cannot share port {getattr(self, a)}")
        return self
