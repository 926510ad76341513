"""Stage timings of runs. They are files of the server's own state folder: on several machines each server knows its own."""

from typing import Annotated

from fastapi import APIRouter, Path, Query

from protocol.errors import DecodeError
from protocol.timings import list_runs, read_run, timings_folder
from server.access import Viewer
from server.context import Ctx
from server.errors import NotFoundError
from server.routes.answers import refusals
from server.views.timings import RunTimingsView, TimingRunView, run_timings_view, run_view

router = APIRouter(tags=["timings"])

_Run = Annotated[str, Path(pattern=r"^[0-9A-Za-z][0-9A-Za-z_-]{0,63}$", examples=["20251124T082145Z"])]
_LastS = Annotated[float, Query(gt=0, le=1e8, allow_inf_nan=False, description="Only its last so many seconds.")]


@router.get("/timings", summary="Runs with stage timings", responses=refusals())
def list_timing_runs(_identity: Viewer, context: Ctx) -> list[TimingRunView]:
    """Newest first."""
    return [run_view(run) for run in reversed(list_runs(timings_folder(context.configuration.state)))]


@router.get("/timings/{run}", summary="A run's stage timings", responses=refusals(404))
def get_timings(_identity: Viewer, run: _Run, context: Ctx, last_s: _LastS | None = None) -> RunTimingsView:
    """Box plots and time graphs, per stage and kind of process. `last_s` counts back from the run's newest record."""
    try:
        return run_timings_view(read_run(timings_folder(context.configuration.state) / run, last_s))
    except DecodeError as error:
        raise NotFoundError(f"there are no stage timings of a run {run!r} on this server's machine") from error
