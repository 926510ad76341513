"""What only the simulated lab reads: the truth behind cameras and vehicles, and its knobs."""

from typing import Annotated

from pydantic import Field

from protocol.lab.base import Finite, Identifier, LabModel, NonNegative, PointXY, PoseXYYaw, Positive


class SimulatedMount(LabModel):
    """Where a simulated camera truly hangs. With zero tilts it looks straight down and its image's x axis points along
    `yaw` (rad) in the map: T_map_camera = translate(position) Rz(yaw) Rx(pi + tilt_x) Ry(tilt_y)."""

    position: tuple[Finite, Finite, Positive]
    yaw: Finite = 0.0
    tilt_x: Finite = 0.0
    tilt_y: Finite = 0.0


class SimulatedImage(LabModel):
    """What the simulated sensor does to the light: Gaussian noise (grey levels), blur sigma (px), gain of the exposure,
    the relative fall-off of the light from one end of the room to the other, and for how long (s) the shutter is open:
    what moves meanwhile is smeared; a frame's stamp is the middle of that time."""

    noise_std: NonNegative = 2.0
    blur_sigma_px: NonNegative = 0.6
    exposure: Positive = 1.0
    lighting_gradient: Annotated[float, Field(ge=0, lt=1)] = 0.15
    exposure_s: Annotated[float, Field(ge=0, le=0.1)] = 0.003


class SimulatedSurvey(LabModel):
    """How well the room was measured: standard deviations of what is true from what the description says. Floor tags' x and
    y (m) and heading (rad), focal lengths (relative), principal points (px), heights of the vehicles' tags (m)."""

    floor_tag_m: NonNegative = 0.0
    floor_tag_rad: NonNegative = 0.0
    focal: Annotated[float, Field(ge=0, lt=0.1)] = 0.0
    center_px: NonNegative = 0.0
    tag_height_m: NonNegative = 0.0


class SimulatedDrive(LabModel):
    """How simulated wheels lie: relative scale error of left and right odometry, noise of each step relative to the way
    travelled, relative slip (what kinds make of it in turns: docs/architecture.md), the delay of the motors' answer, and
    how fast a steered wheel turns (rad/s)."""

    left_scale: Positive = 1.0
    right_scale: Positive = 1.0
    noise: NonNegative = 0.01
    slip: Annotated[float, Field(ge=0, lt=1)] = 0.02
    delay_s: NonNegative = 0.03
    steering_rate_radps: Positive = 1.5


class SimulatedScanner(LabModel):
    """How simulated safety scanners lie: standard deviation of a range (m), the share of echoes that do not come back, and the
    share of beams that find something where nothing is (dust, a glint)."""

    noise_m: NonNegative = 0.01
    missed: Annotated[float, Field(ge=0, lt=1)] = 0.002
    false_echoes: Annotated[float, Field(ge=0, lt=1)] = 0.0002


class SimulatedNetwork(LabModel):
    """What happens to datagrams between robots and the rest: share lost and duplicated, delay and its jitter (s)."""

    loss: Annotated[float, Field(ge=0, lt=1)] = 0.0
    duplication: Annotated[float, Field(ge=0, lt=1)] = 0.0
    delay_s: NonNegative = 0.0
    jitter_s: NonNegative = 0.0


Tour = Annotated[tuple[PointXY, ...], Field(min_length=2, max_length=99)]


class Simulation(LabModel):
    """What only the simulated lab reads: the truth behind the cameras and vehicles, and its knobs. `tours` are loops of
    points (m, map frame) that vehicles drive from the lab's first start on; `walls` are lines (m, map frame) that scanners see
    and nobody passes."""

    seed: int = 1
    step_s: Annotated[float, Field(gt=0, le=0.05)] = 0.01
    mounts: dict[Identifier, SimulatedMount] = Field(default_factory=dict)
    starts: dict[Identifier, PoseXYYaw] = Field(default_factory=dict)
    lanes: tuple[Annotated[tuple[PointXY, ...], Field(min_length=2)], ...] = ()
    walls: tuple[Annotated[tuple[PointXY, ...], Field(min_length=2)], ...] = ()
    survey: SimulatedSurvey = SimulatedSurvey()
    tours: dict[Identifier, Tour] = Field(default_factory=dict)
    image: SimulatedImage = SimulatedImage()
    drive: SimulatedDrive = SimulatedDrive()
    scanner: SimulatedScanner = SimulatedScanner()
    network: SimulatedNetwork = SimulatedNetwork()
