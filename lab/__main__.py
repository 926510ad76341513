"""`python -m lab`: the simulated lab as a process of its own (docs/architecture.md); ends within a second of SIGTERM."""

import logging

import cv2

from lab.service import LabService, PortTakenError
from protocol.clock import SystemClock
from protocol.errors import LabFileError
from protocol.lab import load_lab
from protocol.lifetime import run, run_until_signal
from protocol.settings import Settings


def main() -> None:
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s: %(message)s")
    settings = Settings.from_environment()
    logging.getLogger("lab").info("%s", settings)
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from None
    if not lab.has_simulation:
        raise SystemExit(f"{settings.lab}: no camera has source 'sim' and no vehicle driver 'sim': nothing to simulate")
    cv2.setNumThreads(1)  # pictures are small and the cameras share two worker threads
    try:
        run(run_until_signal(LabService(lab, settings, SystemClock()).run()))
    except PortTakenError as error:
        raise SystemExit(str(error)) from None


if __name__ == "__main__":
    main()
