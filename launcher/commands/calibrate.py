"""`./lilliput calibrate`: what the console's page does, for the shell, and calibration from recordings (docs/calibrate.md)."""

import argparse
import os
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

import redis.asyncio

from launcher.calibration_figures import in_force_figures, proposal_figures
from launcher.errors import LauncherError, UsageError
from launcher.lab_file import add_lab_arguments, read_lab
from launcher.lens_calibration import add_arguments as add_lens_arguments
from launcher.lens_calibration import calibrate_lens
from launcher.output import Result, print_result, progress
from launcher.running_redis import with_redis
from localization.offline import (
    LAB_FILE,
    NotCalibratedError,
    OfflineError,
    calibrated,
    calibration_text,
    look_at_floors,
    open_recording,
)
from localization.tags import KnownTags
from protocol.clock import SystemClock
from protocol.messages import CalibrationProposal, CalibrationRun, RunState
from server.repositories.calibration import CalibrationRepository, CalibrationState
from server.repositories.documents import Store

T = TypeVar("T")

ACTOR = "shell"
"""Who did it, in the history."""
_PERIOD_S = 0.3
_PATIENCE_S = 60.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(metavar="ACTION", required=True, parser_class=type(parser))
    status = actions.add_parser("status", help="what is in force, and what waits for a decision")
    status.set_defaults(act=_status)
    run_ = actions.add_parser("run", help="let cameras look anew and wait for the proposal")
    run_.add_argument("--cameras", metavar="IDS", help="camera ids separated by commas (default: all)")
    run_.add_argument("--accept", action="store_true", help="put the proposal in force without a second look")
    run_.set_defaults(act=_run)
    accept = actions.add_parser("accept", help="put the proposal in force")
    accept.set_defaults(act=_accept)
    discard = actions.add_parser("discard", help="drop the proposal")
    discard.set_defaults(act=_discard)
    restore = actions.add_parser("restore", help="go back to what was in force before")
    restore.set_defaults(act=_restore)
    export = actions.add_parser("export", help="write what is in force to a file, as `localize --calibration` reads it")
    export.add_argument("file", type=Path, metavar="FILE")
    export.set_defaults(act=_export)
    for action in (status, run_, accept, discard, restore, export):
        add_lab_arguments(action)
    extrinsics = actions.add_parser("extrinsics", help="cameras and floor tags jointly, from a recording of the floor")
    extrinsics.add_argument(
        "recording", type=Path, metavar="RECORDING", help="folder with a video or pictures per camera"
    )
    extrinsics.add_argument("--lab", type=Path, metavar="FILE", help="lab description (default: RECORDING/lab.yaml)")
    extrinsics.add_argument(
        "--out", type=Path, metavar="FILE", help="write the result there, for `localize --calibration`"
    )
    extrinsics.set_defaults(act=_extrinsics)
    intrinsics = actions.add_parser(
        "intrinsics", help="a camera's lens, from a recording of a chessboard or ChArUco board"
    )
    add_lens_arguments(intrinsics)
    intrinsics.set_defaults(act=calibrate_lens)
    for action in (status, run_, accept, discard, restore, export, extrinsics, intrinsics):
        action.add_argument("--json", action="store_true", help="print one JSON object to stdout")


def run(arguments: argparse.Namespace) -> int:
    arguments.act(arguments)
    return 0


def _status(arguments: argparse.Namespace) -> None:
    state = _with_repository(arguments, lambda calibration: calibration.get())
    figures: dict[str, Any] = {} if state.current is None else in_force_figures(state.current)
    figures["calibrated"] = state.current is not None
    figures["can_be_restored"] = state.previous is not None
    figures["proposal"] = None if state.proposal is None else state.proposal.calibration.id
    if state.run is not None:
        figures["run"] = str(state.run.state)
        figures["run_by"] = state.run.by
    print_result(Result("calibration", figures), as_json=arguments.json)


def _run(arguments: argparse.Namespace) -> None:
    cameras = None if arguments.cameras is None else [part.strip() for part in arguments.cameras.split(",")]

    async def work(calibration: CalibrationRepository) -> CalibrationProposal:
        proposal = await _proposal(calibration, await calibration.start(cameras, ACTOR))
        if arguments.accept:
            await calibration.accept(proposal.calibration.id, ACTOR)
        return proposal

    proposal = _with_repository(arguments, work)
    figures = {**proposal_figures(proposal), "accepted": arguments.accept}
    print_result(Result("calibration", figures), as_json=arguments.json)
    if not arguments.accept:
        progress("accept it with `./lilliput calibrate accept`, or drop it with `./lilliput calibrate discard`")


async def _proposal(calibration: CalibrationRepository, run: CalibrationRun) -> CalibrationProposal:
    """Waits for the run's outcome; LauncherError when it gives none."""
    progress(f"{', '.join(run.cameras)} look at their floor tags")
    clock = SystemClock()
    started_s = clock.monotonic_s()
    answered: tuple[str, ...] = ()
    while True:
        state = await calibration.get()
        now = state.run
        if now is None or now.id != run.id:
            raise LauncherError("another calibration took the place of this one")
        if now.answered != answered:
            answered = now.answered
            progress(f"{len(answered)} of {len(now.cameras)} cameras have answered")
        if state.proposal is not None and state.proposal.calibration.id == run.id:
            if now.text:
                progress(f"warning: {now.text}")
            return state.proposal
        if now.state in (RunState.FAILED, RunState.DISCARDED):
            raise LauncherError(f"no calibration: {now.text}")
        if clock.monotonic_s() - started_s > _PATIENCE_S:
            raise LauncherError("no calibration: the calibrator does not answer; is the process `calibrator` running?")
        await clock.sleep(_PERIOD_S)


def _accept(arguments: argparse.Namespace) -> None:
    async def work(calibration: CalibrationRepository) -> dict[str, Any]:
        return in_force_figures(await calibration.accept(_waiting(await calibration.get()), ACTOR))

    print_result(Result("calibration", _with_repository(arguments, work)), as_json=arguments.json)


def _discard(arguments: argparse.Namespace) -> None:
    async def work(calibration: CalibrationRepository) -> int:
        proposal = _waiting(await calibration.get())
        await calibration.discard(proposal, ACTOR)
        return proposal

    print_result(Result("calibration", {"discarded": _with_repository(arguments, work)}), as_json=arguments.json)


def _restore(arguments: argparse.Namespace) -> None:
    async def work(calibration: CalibrationRepository) -> dict[str, Any]:
        return in_force_figures(await calibration.restore(ACTOR))

    print_result(Result("calibration", _with_repository(arguments, work)), as_json=arguments.json)


def _export(arguments: argparse.Namespace) -> None:
    current = _with_repository(arguments, lambda calibration: calibration.get()).current
    if current is None:
        raise LauncherError("there is no calibration yet: are the cameras running, and do they see their floor tags?")
    _write(arguments.file, calibration_text(current))
    print_result(
        Result("calibration", {**in_force_figures(current), "file": str(arguments.file)}), as_json=arguments.json
    )


def _extrinsics(arguments: argparse.Namespace) -> None:
    own: Path = arguments.recording / LAB_FILE
    if not arguments.recording.exists():
        raise UsageError(f"{arguments.recording} does not exist")
    if arguments.lab is None and not own.is_file():
        raise UsageError(f"{arguments.recording} has no {LAB_FILE}: say with --lab FILE which lab was recorded")
    path, lab = read_lab(arguments.lab or own, recorded=True)
    try:
        recording = open_recording(arguments.recording, lab)
        progress(f"looking at the floor tags of {len(recording.cameras)} cameras")
        with ThreadPoolExecutor(os.cpu_count() or 1) as executor:
            looks = look_at_floors(recording.cameras, KnownTags.of(lab), executor)
        calibration, problems = calibrated(lab, looks)
    except NotCalibratedError as error:
        raise LauncherError(str(error)) from error
    except OfflineError as error:
        raise UsageError(str(error)) from error
    warnings = [*recording.warnings, *problems]
    for warning in warnings:
        progress(f"warning: {warning}")
    if arguments.out is not None:
        _write(arguments.out, calibration_text(calibration))
    settings = {"recording": str(arguments.recording), "lab": str(path)}
    figures = {**in_force_figures(calibration), "warnings": warnings}
    print_result(Result("calibration", figures, settings=settings), as_json=arguments.json)


def _with_repository(arguments: argparse.Namespace, work: Callable[[CalibrationRepository], Awaitable[T]]) -> T:
    """Does `work` on the calibration of the system that runs; refusals become errors of one line."""
    _, lab = read_lab(arguments.lab)

    async def on_redis(client: redis.asyncio.Redis) -> T:
        return await work(CalibrationRepository(Store(client), lab, SystemClock()))

    return with_redis(arguments, on_redis)


def _waiting(state: CalibrationState) -> int:
    if state.proposal is None:
        raise UsageError("no calibration is proposed; start one with `./lilliput calibrate run`")
    return state.proposal.calibration.id


def _write(file: Path, content: bytes) -> None:
    try:
        file.write_bytes(content)
    except OSError as error:
        raise UsageError(f"{file} cannot be written: {error.strerror}") from error
