"""Calibration of cameras and floor tags while the system runs: start, compare, accept or discard, undo."""

from typing import Annotated

from fastapi import APIRouter
from pydantic import ConfigDict, Field

from protocol.messages import Calibration, CalibrationRun
from protocol.messages.base import Identifier
from protocol.messages.calibration import RunId
from server.access import Operator, Viewer
from server.context import Ctx
from server.routes.answers import refusals
from server.views.base import Body
from server.views.calibration import CalibrationView

router = APIRouter(prefix="/calibration", tags=["calibration"])


class StartCalibration(Body):
    """Which cameras are to look at the floor tags anew; null: all."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"cameras": ["cam0", "cam1"]}, {}]})

    cameras: Annotated[tuple[Identifier, ...], Field(max_length=1000)] | None = None


class Decision(Body):
    """The proposal that is meant: the `id` of its calibration."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"id": 1700000000000}]})

    id: RunId


@router.get("", summary="State of the calibration", responses=refusals())
async def get_calibration(_identity: Viewer, context: Ctx) -> CalibrationView:
    """What is in force, what is going on, and what waits for a decision."""
    state = await context.calibration.get()
    return CalibrationView(
        stamp_ns=context.clock.now_ns(),
        run=state.run,
        current=state.current,
        previous=state.previous,
        proposal=state.proposal,
    )


@router.post("", summary="Start a calibration", status_code=201, responses=refusals(409))
async def start_calibration(identity: Operator, start: StartCalibration, context: Ctx) -> CalibrationRun:
    """The cameras look at their floor tags while poses go on; some seconds later a proposal waits for a decision. A
    proposal that waited is replaced. Refused while another run goes on."""
    return await context.calibration.start(start.cameras, identity.name)


@router.post("/accept", summary="Accept the proposal", responses=refusals(409))
async def accept_calibration(identity: Operator, decision: Decision, context: Ctx) -> Calibration:
    """Puts it in force for all cameras at once, without a restart; what was in force can be restored. Refused when it is not
    this proposal that waits."""
    return await context.calibration.accept(decision.id, identity.name)


@router.post("/discard", summary="Discard the proposal", status_code=204, responses=refusals(409))
async def discard_calibration(identity: Operator, decision: Decision, context: Ctx) -> None:
    """Nothing changes. Refused when it is not this proposal that waits."""
    await context.calibration.discard(decision.id, identity.name)


@router.post("/restore", summary="Restore the previous calibration", responses=refusals(409))
async def restore_calibration(identity: Operator, context: Ctx) -> Calibration:
    """Puts in force what was before; the present one can be restored in the same way. A camera that was moved since notices
    it, and finds its place anew. Refused when there is no previous one."""
    return await context.calibration.restore(identity.name)
