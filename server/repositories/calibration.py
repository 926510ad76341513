"""Calibration as people steer it: runs are asked for, proposals accepted or discarded, the result before restored. What is
computed comes from the calibrator; cameras take what is in force by themselves (docs/calibrate.md)."""

from collections.abc import Collection
from dataclasses import dataclass

from protocol import keys
from protocol.channels import CALIBRATION_RUNS, LAB_INSTANCE
from protocol.clock import Clock
from protocol.lab import Lab, camera_basis, floor_basis
from protocol.messages import Calibration, CalibrationProposal, CalibrationRun, Event, EventLevel, RunState
from protocol.messages.calibration import CURRENT, PREVIOUS
from server.errors import ConflictError, InvalidError
from server.repositories.documents import Documents, Store, Transaction, documents_of

CALIBRATIONS = Documents(keys.CALIBRATIONS, Calibration)
PROPOSALS = Documents(keys.CALIBRATION_PROPOSALS, CalibrationProposal)
RUNS = documents_of(CALIBRATION_RUNS)
_GIVEN_UP_NS = 60_000_000_000
"""A run without any news for so long has lost its calibrator, and another may take its place."""


@dataclass(frozen=True, slots=True)
class CalibrationState:
    """All there is; damaged records are left out."""

    run: CalibrationRun | None
    current: Calibration | None
    previous: Calibration | None
    proposal: CalibrationProposal | None


class CalibrationRepository:
    """Each change is one transaction with its line of history."""

    def __init__(self, store: Store, lab: Lab, clock: Clock) -> None:
        self._store, self._lab, self._clock = store, lab, clock

    async def get(self) -> CalibrationState:
        """The newest run, what is in force, what was before, and what waits for a decision."""
        calibrations = await self._store.all(CALIBRATIONS)
        return CalibrationState(
            run=(await self._store.all(RUNS)).get(LAB_INSTANCE),
            current=calibrations.get(CURRENT),
            previous=calibrations.get(PREVIOUS),
            proposal=(await self._store.all(PROPOSALS)).get(LAB_INSTANCE),
        )

    async def start(self, cameras: Collection[str] | None, actor: str) -> CalibrationRun:
        """Asks cameras (None: all) to look anew. InvalidError for one that does not exist, ConflictError while a run goes on;
        a proposal that waits is replaced."""
        asked = self._chosen(cameras)

        async def work(transaction: Transaction) -> CalibrationRun:
            now_ns = self._clock.now_ns()
            before = await transaction.find(RUNS, LAB_INSTANCE)
            if before is not None and before.is_busy and now_ns - before.stamp_ns < _GIVEN_UP_NS:
                raise ConflictError(f"a calibration of {before.by} is going on; wait for it")
            run = CalibrationRun(
                id=max(now_ns // 1_000_000, 1 if before is None else before.id + 1),
                state=RunState.COLLECTING,
                stamp_ns=now_ns,
                started_ns=now_ns,
                by=actor,
                cameras=asked,
            )
            transaction.delete(PROPOSALS, LAB_INSTANCE)
            transaction.publish(CALIBRATION_RUNS, LAB_INSTANCE, run)
            self._record(
                transaction, actor, "calibration_started", f"{actor} started a calibration of {', '.join(asked)}"
            )
            return run

        return await self._store.transaction((RUNS, PROPOSALS), work)

    async def accept(self, proposal_id: int, actor: str) -> Calibration:
        """Puts the proposal in force; what was in force becomes the previous one. ConflictError when it is not that proposal
        that waits, or when it rests on another lab description."""

        async def work(transaction: Transaction) -> Calibration:
            proposal = await self._waiting(transaction, proposal_id)
            self._require_of_this_lab(proposal.calibration, "the proposed calibration")
            new = self._in_force(proposal.calibration, actor)
            self._replace(transaction, new, await transaction.find(CALIBRATIONS, CURRENT))
            await self._decide(transaction, proposal_id, RunState.ACCEPTED)
            text = f"{actor} accepted the calibration of {', '.join(new.cameras)}"
            self._record(transaction, actor, "calibration_accepted", text)
            return new

        return await self._store.transaction((CALIBRATIONS, PROPOSALS, RUNS), work)

    async def discard(self, proposal_id: int, actor: str) -> None:
        """Drops the proposal; nothing changes. ConflictError when it is not that proposal that waits."""

        async def work(transaction: Transaction) -> None:
            await self._waiting(transaction, proposal_id)
            await self._decide(transaction, proposal_id, RunState.DISCARDED)
            self._record(transaction, actor, "calibration_discarded", f"{actor} discarded the proposed calibration")

        await self._store.transaction((CALIBRATIONS, PROPOSALS, RUNS), work)

    async def restore(self, actor: str) -> Calibration:
        """Puts the previous result in force again, and keeps the present one as the previous: done twice, it undoes itself.
        ConflictError when there is none, or when it rests on another lab description."""

        async def work(transaction: Transaction) -> Calibration:
            previous = await transaction.get(CALIBRATIONS, PREVIOUS)
            if previous is None:
                raise ConflictError("there is no previous calibration to restore")
            self._require_of_this_lab(previous, "the previous calibration")
            new = self._in_force(previous, actor)
            self._replace(transaction, new, await transaction.find(CALIBRATIONS, CURRENT))
            self._record(transaction, actor, "calibration_restored", f"{actor} restored the previous calibration")
            return new

        return await self._store.transaction((CALIBRATIONS, PROPOSALS, RUNS), work)

    def _chosen(self, cameras: Collection[str] | None) -> tuple[str, ...]:
        known = [camera.id for camera in self._lab.cameras]
        if cameras is None:
            cameras = known
        if not cameras:
            raise InvalidError(("body", "cameras"), "name at least one camera")
        for camera in cameras:
            if camera not in known:
                raise InvalidError(("body", "cameras"), f"there is no camera {camera!r}; there are {', '.join(known)}")
        return tuple(camera for camera in known if camera in cameras)

    async def _waiting(self, transaction: Transaction, proposal_id: int) -> CalibrationProposal:
        proposal = await transaction.get(PROPOSALS, LAB_INSTANCE)
        if proposal is None:
            raise ConflictError("no calibration is proposed; start one")
        if proposal.calibration.id != proposal_id:
            raise ConflictError("another calibration is proposed by now; look at it first")
        return proposal

    async def _decide(self, transaction: Transaction, proposal_id: int, state: RunState) -> None:
        transaction.delete(PROPOSALS, LAB_INSTANCE)
        run = await transaction.find(RUNS, LAB_INSTANCE)
        if run is not None and run.id == proposal_id:
            decided = run.model_copy(update={"state": state, "stamp_ns": self._clock.now_ns()})
            transaction.publish(CALIBRATION_RUNS, LAB_INSTANCE, decided)

    def _replace(self, transaction: Transaction, new: Calibration, old: Calibration | None) -> None:
        if old is not None:
            transaction.put(CALIBRATIONS, PREVIOUS, old)
        else:
            transaction.delete(CALIBRATIONS, PREVIOUS)
        transaction.put(CALIBRATIONS, CURRENT, new)

    def _require_of_this_lab(self, calibration: Calibration, what: str) -> None:
        """Cameras ignore what rests on another description: putting it in force would only push out a good one."""
        if calibration.floor_basis != floor_basis(self._lab.floor_tags):
            raise ConflictError(f"{what} rests on other floor tags than the lab file has now; calibrate anew")
        bases = {camera.id: camera_basis(camera) for camera in self._lab.cameras}
        changed = [name for name, camera in calibration.cameras.items() if bases.get(name) != camera.basis]
        if changed:
            raise ConflictError(
                f"{what} rests on another description of {', '.join(sorted(changed))} than the lab file has now; calibrate anew"
            )

    def _in_force(self, calibration: Calibration, actor: str) -> Calibration:
        """From now on: cameras take what is newer than what they found by themselves."""
        return calibration.model_copy(update={"stamp_ns": self._clock.now_ns(), "by": actor})

    def _record(self, transaction: Transaction, actor: str, kind: str, text: str) -> None:
        transaction.record(
            Event(stamp_ns=self._clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)
        )
