"""How soon do robots stand after the emergency stop? Pressed in a browser, or asked for by a script, on the whole system."""

import argparse
import tempfile
import time
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np

from launcher.chromium import ensure_chromium
from launcher.errors import UsageError
from launcher.output import Result, progress
from launcher.paths import WEB
from launcher.web_build import build_web
from tests.e2e.browser import Console, console
from tests.e2e.emergency_stop import (
    SPEED_MPS,
    drive_to_and_fro,
    press_emergency_stop,
    release_emergency_stop,
    wait_until_both_drive,
)
from tests.e2e.odyssey import Odyssey
from tests.e2e.system import RunningSystem, running_system, wait_for

_WITHIN_S = 10.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--presses", type=int, default=20, metavar="N", help="stops of each way (20)")


def run(arguments: argparse.Namespace) -> Result:
    """Figures: `stop_browser_...` from the press of the button, `stop_api_...` from the request, until the first moment at which
    both robots truly stand. Both drive at 0.3 m/s, on which braking alone takes 0.10 to 0.12 s (`Limits.braking_mps2`).
    UsageError for fewer than one press."""
    if arguments.presses < 1:
        raise UsageError(f"--presses must be at least 1, not {arguments.presses}")
    build_web(WEB, progress)
    ensure_chromium()
    halts_ms: dict[str, list[float]] = {"browser": [], "api": []}
    with tempfile.TemporaryDirectory(prefix="lilliput-stop-") as folder, running_system(Path(folder)) as system:
        system.wait_until_driving_is_possible()
        robots = drive_to_and_fro(system)
        with console(system) as operator:
            operator.open("floor")
            for number in range(arguments.presses):
                progress(f"stop {number + 1} of {arguments.presses}")
                for way, halts in halts_ms.items():
                    halts.append(_halt_ms(system, operator, robots, by_browser=way == "browser"))
                    release_emergency_stop(operator)
    figures: dict[str, float] = {}
    for way, halts in halts_ms.items():
        figures[f"stop_{way}_median_ms"] = median(halts)
        figures[f"stop_{way}_p95_ms"] = float(np.percentile(halts, 95))
        figures[f"stop_{way}_max_ms"] = max(halts)
    return Result("stop", figures, settings={"presses": arguments.presses, "speed_mps": SPEED_MPS})


def _halt_ms(system: RunningSystem, operator: Console, robots: tuple[str, str], *, by_browser: bool) -> float:
    wait_until_both_drive(system)
    with Odyssey(system) as odyssey:
        if by_browser:
            pressed_ns = press_emergency_stop(operator)
        else:
            pressed_ns = float(time.time_ns())
            system.api.post("/estop", json={"reason": "benchmark"}).raise_for_status()
        stood_ns = wait_for("both stand", partial(odyssey.all_stand_since, pressed_ns, robots), _WITHIN_S)
    return (stood_ns - pressed_ns) / 1e6
