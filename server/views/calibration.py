"""Calibration as the console shows it."""

from protocol.messages import Calibration, CalibrationProposal, CalibrationRun
from server.views.base import View


class CalibrationView(View):
    """The newest run (null: there never was one), what is in force, what was before (null: nothing to restore), and the
    proposal that waits for a decision. Each camera's own state is in `/cameras`."""

    stamp_ns: int
    run: CalibrationRun | None
    current: Calibration | None
    previous: Calibration | None
    proposal: CalibrationProposal | None
