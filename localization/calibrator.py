"""The calibrator process, `python -m localization.calibrator`: calibrates all cameras and floor tags jointly (spec localization,
"Better than the reports") from what the camera processes saw, and proposes the result of what a person asked for.

At the first start, and when a camera was moved, nobody has to ask: the joint result comes into force by itself.
"""

import asyncio
import logging
from collections.abc import Sequence
from dataclasses import dataclass

from redis.exceptions import RedisError

from geometry import SE2
from localization.agenda import Agenda
from localization.calibration import ExtrinsicsError, FloorSighting, JointCalibration, refine_jointly
from localization.calibration_link import received_sighting
from localization.calibration_store import CalibrationStore, Stored
from localization.comparison import InUse, compare_cameras, compare_floor_tags
from protocol.bus import Bus
from protocol.channels import CALIBRATION_RUNS, CAMERA_STATES, EVENTS, LAB_INSTANCE, SIGHTINGS
from protocol.clock import Clock, SystemClock
from protocol.errors import BusUnavailableError, LabFileError
from protocol.lab import Lab, camera_basis, floor_basis, load_lab
from protocol.lifetime import run_until_signal
from protocol.messages import (
    CalibratedCamera,
    CalibratedFloorTag,
    Calibration,
    CalibrationProposal,
    CalibrationRun,
    CameraState,
    Event,
    EventLevel,
    FloorTagSighting,
    RunState,
)
from protocol.settings import Settings

_logger = logging.getLogger(__name__)

NAME = "calibrator"
_PERIOD_S = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class _Refined:
    """A joint result with the sightings that it was made of."""

    sightings: list[FloorSighting]
    joint: JointCalibration
    calibration: Calibration


class Calibrator:
    """The process between its edges; `run` goes on until it is cancelled."""

    def __init__(self, lab: Lab, bus: Bus, clock: Clock) -> None:
        self._lab, self._bus, self._clock = lab, bus, clock
        self._agenda, self._store = Agenda(lab), CalibrationStore(bus)
        self._last_id = 0
        self._before: tuple[int, InUse] | None = None

    async def run(self) -> None:
        async with asyncio.TaskGroup() as group:
            group.create_task(self._listen())
            group.create_task(self._work())

    async def _listen(self) -> None:
        agenda = self._agenda
        async for received in self._bus.subscribe(SIGHTINGS, CALIBRATION_RUNS, CAMERA_STATES):
            match received.message:
                case FloorTagSighting() as sighting:
                    agenda.sightings[sighting.camera] = sighting
                case CameraState() as state:
                    agenda.states[state.camera] = state
                case CalibrationRun() as run:
                    agenda.run = run
                case _:
                    pass

    async def _work(self) -> None:
        is_down = False
        while True:
            try:
                await self.turn()
                is_down = False
            except (RedisError, OSError, BusUnavailableError) as error:
                if not is_down:
                    _logger.warning("waits for Redis: %s", error)
                is_down = True
            await self._clock.sleep(_PERIOD_S)

    async def turn(self) -> None:
        """What is due now: the run that somebody asked for, else what cameras did by themselves."""
        run = self._agenda.run
        if run is not None and run.is_busy:
            await self._go_on(run)
            return
        if not self._agenda.sightings:
            return
        stored = await self._store.read()
        cameras = self._agenda.unrefined(stored.current, self._clock.now_ns())
        if cameras:
            await self._refine_by_itself(cameras, stored)

    async def _go_on(self, run: CalibrationRun) -> None:
        if self._before is None or self._before[0] != run.id:
            # Cameras may take what they find at once: what was in use is remembered from when they were asked.
            self._before = run.id, self._in_use(await self._store.read())
        now_ns = self._clock.now_ns()
        answered = self._agenda.answered(run)
        if not self._agenda.is_collected(run, now_ns):
            if answered != run.answered:
                await self._say(run.model_copy(update={"answered": answered, "stamp_ns": now_ns}))
            return
        silent = self._agenda.why_silent(run)
        if not answered:
            await self._fail(run, silent)
            return
        run = run.model_copy(update={"answered": answered, "state": RunState.REFINING, "stamp_ns": now_ns})
        if not await self._say(run):
            return
        try:
            refined = await self._refine(run.id, run.by)
        except ExtrinsicsError as error:
            await self._fail(run, str(error))
            return
        before = self._before[1]
        proposal = CalibrationProposal(
            calibration=refined.calibration,
            cameras=compare_cameras(self._lab, refined.sightings, answered, before, refined.joint),
            floor_tags=compare_floor_tags(refined.sightings, before, refined.joint),
            not_answered=tuple(camera for camera in run.cameras if camera not in answered),
        )
        update = {"state": RunState.PROPOSED, "stamp_ns": self._clock.now_ns(), "text": silent}
        text = f"a calibration of {', '.join(answered)} is proposed to {run.by}"
        event = self._event(EventLevel.INFO, "calibration_proposed", text)
        await self._say(run.model_copy(update=update), proposal, event)

    async def _refine_by_itself(self, cameras: tuple[str, ...], stored: Stored) -> None:
        now_ns = self._clock.now_ns()
        self._last_id = max(self._last_id + 1, now_ns // 1_000_000)
        try:
            refined = await self._refine(self._last_id, NAME)
        except ExtrinsicsError as error:
            self._agenda.note_failure(cameras)
            text = f"no joint calibration, cameras keep their own: {error}"
            _logger.warning("%s", text)
            await self._bus.publish(
                EVENTS, LAB_INSTANCE, self._event(EventLevel.WARNING, "calibration_not_refined", text)
            )
            return
        calibration = refined.calibration
        why = (
            "first start" if self._agenda.still_holds(stored.current) is None else f"{', '.join(cameras)} moved or new"
        )
        worst_px = max(camera.reprojection_px for camera in calibration.cameras.values())
        text = f"calibrated {', '.join(sorted(calibration.cameras))} jointly ({why}), at most {worst_px:.2f} px off"
        _logger.info("%s", text)
        if not await self._store.put_in_force(calibration, self._event(EventLevel.INFO, "calibration_refined", text)):
            return  # somebody was faster; the next turn sees what is in force now
        run = self._agenda.run
        if run is not None and run.state is RunState.PROPOSED:
            outdated = f"{', '.join(cameras)} found a new place by itself meanwhile"
            update = {"state": RunState.DISCARDED, "stamp_ns": self._clock.now_ns(), "text": outdated}
            await self._say(run.model_copy(update=update))

    async def _refine(self, run_id: int, by: str) -> _Refined:
        """The joint result of all newest sightings. ExtrinsicsError says what stands in the way."""
        now_ns = self._clock.now_ns()
        sightings = [received_sighting(message) for message in self._agenda.usable()]
        joint = await asyncio.to_thread(refine_jointly, self._lab, sightings)
        return _Refined(sightings, joint, as_calibration(self._lab, joint, run_id, now_ns, by))

    def _in_use(self, stored: Stored) -> InUse:
        held = self._agenda.still_holds(stored.current)
        described = {tag: SE2(*pose) for tag, pose in self._lab.floor_tags.poses.items()}
        refined = {} if held is None else {t: SE2(p.x, p.y, p.yaw) for t, p in held.floor_tags.items()}
        return InUse(stored.extrinsics, described | refined)

    async def _say(
        self, run: CalibrationRun, proposal: CalibrationProposal | None = None, event: Event | None = None
    ) -> bool:
        """False when the run is no longer ours to go on with."""
        said = await self._store.say(run, proposal=proposal, event=event)
        self._agenda.run = run if said else None
        return said

    async def _fail(self, run: CalibrationRun, why: str) -> None:
        _logger.warning("calibration %d gave nothing: %s", run.id, why)
        failed = run.model_copy(update={"state": RunState.FAILED, "stamp_ns": self._clock.now_ns(), "text": why})
        await self._say(failed, event=self._event(EventLevel.WARNING, "calibration_failed", f"no calibration: {why}"))

    def _event(self, level: EventLevel, kind: str, text: str) -> Event:
        return Event(stamp_ns=self._clock.now_ns(), level=level, source=NAME, kind=kind, text=text)


def as_calibration(lab: Lab, joint: JointCalibration, run_id: int, stamp_ns: int, by: str) -> Calibration:
    """A joint result as it is stored."""
    return Calibration(
        id=run_id,
        stamp_ns=stamp_ns,
        by=by,
        floor_basis=floor_basis(lab.floor_tags),
        cameras={
            camera: CalibratedCamera.of(found, joint.left_out.get(camera, ()), camera_basis(lab.camera(camera)))
            for camera, found in sorted(joint.extrinsics.items())
        },
        floor_tags={
            tag: CalibratedFloorTag(x=pose.x, y=pose.y, yaw=pose.yaw, shift_m=joint.floor_tag_shift_m.get(tag, 0.0))
            for tag, pose in sorted(joint.floor_tags.items())
        },
    )


async def _run(lab: Lab, settings: Settings, clock: Clock) -> None:
    bus = Bus.connect(settings.redis_url, clock)
    try:
        await run_until_signal(Calibrator(lab, bus, clock).run())
    finally:
        await bus.close()


def main(_arguments: Sequence[str] | None = None) -> None:
    """Runs until SIGTERM or SIGINT; settings come from the environment (`protocol.settings`)."""
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(message)s")
    settings = Settings.from_environment()
    try:
        lab = load_lab(settings.lab)
    except LabFileError as error:
        raise SystemExit(str(error)) from None
    _logger.info("calibrator of %s with %s", lab.name, settings)
    asyncio.run(_run(lab, settings, SystemClock()))


if __name__ == "__main__":
    main()
