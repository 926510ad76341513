"""The one table of processes (design, "Processes"): name, command, when it runs, restart policy.

`./lilliput up` starts what `expand` makes of it for a lab; docker-compose.yml mirrors it and a test compares the two.
Every process tolerates any order of start and the loss of any other; the order here only shortens the start.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Literal

from launcher.errors import UsageError
from protocol.lab import GPSS_DRIVER, Lab

REDIS = "redis"
SERVER = "server"
INTAKE = "intake"

Restart = Literal["always", "never"]


@dataclass(frozen=True, slots=True)
class ProcessKind:
    """A row of the table. `argv` is what follows the Python interpreter; `{id}` stands for the instance's id. `runs` says
    for people when a lab has it, `instances` gives the ids of a lab's instances, an id of "" meaning the only one.
    `needs_token`: gets an API token. `starts_first`: the others connect to it, so they are started a little later.
    `niceness`: how far it steps back when processors are short: what stops robots goes first, pictures for people last."""

    name: str
    argv: tuple[str, ...]
    runs: str
    instances: Callable[[Lab], Sequence[str]]
    restart: Restart = "always"
    needs_token: bool = False
    starts_first: bool = False
    niceness: int = 0


@dataclass(frozen=True, slots=True)
class ProcessInstance:
    """One process to run: its unique name (`camera-cam0`), its row, its camera's or vehicle's id (else ""), and what
    follows the interpreter."""

    name: str
    kind: ProcessKind
    id: str
    argv: tuple[str, ...]


def _always(_lab: Lab) -> Sequence[str]:
    return ("",)


def _cameras(lab: Lab) -> Sequence[str]:
    return tuple(camera.id for camera in lab.cameras)


def _with_cameras(lab: Lab) -> Sequence[str]:
    return ("",) if lab.cameras else ()


def _simulated_vehicles(lab: Lab) -> Sequence[str]:
    return tuple(vehicle.id for vehicle in lab.vehicles if vehicle.driver == "sim")


def _with_gpss_robots(lab: Lab) -> Sequence[str]:
    return ("",) if any(vehicle.driver == GPSS_DRIVER for vehicle in lab.vehicles) else ()


def _with_ros2_output(lab: Lab) -> Sequence[str]:
    return ("",) if lab.outputs.ros2.enabled else ()


def _when_simulated(lab: Lab) -> Sequence[str]:
    return ("",) if lab.has_simulation else ()


PROCESSES = (
    ProcessKind(REDIS, (), "without REDIS_URL: a private server", _always),
    ProcessKind("lab", ("-m", "lab"), "when any camera or vehicle is simulated", _when_simulated, starts_first=True),
    ProcessKind(SERVER, ("-m", "server"), "always", _always, starts_first=True),
    ProcessKind(INTAKE, ("-m", "server.intake"), "always", _always),
    ProcessKind("guidance", ("-m", "server.guidance"), "always", _always),
    ProcessKind("scene", ("-m", "server.scene"), "always", _always, niceness=10),
    ProcessKind("camera", ("-m", "localization.camera", "{id}"), "one per camera", _cameras, niceness=3),
    ProcessKind("tracker", ("-m", "localization.tracker"), "always", _always),
    ProcessKind(
        "calibrator", ("-m", "localization.calibrator"), "when there is any camera", _with_cameras, niceness=10
    ),
    ProcessKind("mapper", ("-m", "mapping.mapper"), "always", _always),
    ProcessKind("gpss", ("-m", "server.gpss"), f"when any vehicle's driver is {GPSS_DRIVER}", _with_gpss_robots),
    ProcessKind("ros2", ("-m", "localization.ros2_bridge"), "when outputs.ros2 is enabled", _with_ros2_output),
    ProcessKind("agent", ("-m", "agents", "{id}"), "one per simulated vehicle", _simulated_vehicles, needs_token=True),
)


def expand(lab: Lab, table: Sequence[ProcessKind] = PROCESSES) -> list[ProcessInstance]:
    """The processes that a lab needs, in the order of the table."""
    return [
        ProcessInstance(
            name=f"{kind.name}-{instance}" if instance else kind.name,
            kind=kind,
            id=instance,
            argv=tuple(part.replace("{id}", instance) for part in kind.argv),
        )
        for kind in table
        for instance in kind.instances(lab)
    ]


def select(processes: Sequence[ProcessInstance], names: Collection[str]) -> list[ProcessInstance]:
    """Those whose own name or kind is in `names`; UsageError for a name that fits none."""
    known = {process.name for process in processes} | {process.kind.name for process in processes}
    if unknown := sorted(set(names) - known):
        listed = ", ".join(process.name for process in processes)
        raise UsageError(f"no process is called {', '.join(unknown)}; this lab has {listed}")
    return [process for process in processes if {process.name, process.kind.name} & set(names)]
