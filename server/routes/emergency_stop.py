"""The fleet-wide emergency stop."""

from typing import Annotated, Literal

from fastapi import APIRouter
from pydantic import ConfigDict, Field

from protocol.messages import EmergencyStop
from server.access import Operator, Somebody, WhoeverStops
from server.context import Ctx
from server.routes.answers import refusals
from server.views.base import Body, Problem

router = APIRouter(prefix="/estop", tags=["emergency stop"])

_TOLD = {
    "model": Problem,
    "description": "Redis is out of reach: the robots on open streams were told to stop, and it is yet to be written.",
}


class Engage(Body):
    """Why everything is to stop."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"reason": "person on the floor"}]})

    reason: Annotated[str, Field(max_length=200, examples=["person on the floor"])] = ""


class Release(Body):
    """A person's word that it is safe to move again."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"confirm": True}]})

    confirm: Literal[True]


@router.get("", summary="State of the emergency stop", responses=refusals())
async def get_emergency_stop(_identity: Somebody, context: Ctx) -> EmergencyStop:
    """Whether it is engaged, by whom and why. For robots too."""
    return await context.emergency_stop.get()


@router.post("", summary="Stop everything", responses={**refusals(), 503: _TOLD})
async def engage_emergency_stop(identity: WhoeverStops, engage: Engage, context: Ctx) -> EmergencyStop:
    """Every robot halts at once and stays so until a person releases the stop; it survives every restart. When it is
    engaged already, its first reason stays. It works without Redis too: then robots with an open stream are told, it is
    written when Redis is back (if this server still runs), and the answer is a 503 that says so."""
    return await context.emergency_stop.engage(engage.reason, identity.name)


@router.delete("", summary="Release the emergency stop", responses=refusals())
async def release_emergency_stop(identity: Operator, release: Release, context: Ctx) -> EmergencyStop:
    """Routes that were running go on; needs `{"confirm": true}`."""
    assert release.confirm
    return await context.emergency_stop.release(identity.name)
