"""Faults that simulated cameras are made to suffer; the simulated lab obeys. Durable, until they are taken back."""

from protocol import keys
from protocol.clock import Clock
from protocol.lab import Lab
from protocol.messages import CameraFault, Event, EventLevel
from server.errors import NotFoundError
from server.repositories.documents import Documents, Store, Transaction

CAMERA_FAULTS = Documents(keys.SIMULATED_FAULTS, CameraFault)


class CameraFaultRepository:
    """Faults by camera id. NotFoundError for a camera that is not simulated."""

    def __init__(self, store: Store, lab: Lab, clock: Clock) -> None:
        self._store, self._clock = store, clock
        self._cameras = {camera.id for camera in lab.cameras if camera.source == "sim"}

    async def all(self) -> dict[str, CameraFault]:
        return await self._store.all(CAMERA_FAULTS)

    async def put(self, camera: str, fault: CameraFault, actor: str) -> CameraFault:
        """Replaces the fault that the camera suffers."""
        self._require(camera)

        async def work(transaction: Transaction) -> CameraFault:
            transaction.put(CAMERA_FAULTS, camera, fault)
            text = f"{actor} has {camera} suffer a simulated fault: {fault.kind}"
            transaction.record(self._event(actor, "fault_begun", text))
            return fault

        return await self._store.transaction((CAMERA_FAULTS,), work)

    async def delete(self, camera: str, actor: str) -> None:
        """NotFoundError when there is none."""
        self._require(camera)

        async def work(transaction: Transaction) -> None:
            if not await transaction.exists(CAMERA_FAULTS, camera):
                raise NotFoundError(f"{camera} suffers no simulated fault")
            transaction.delete(CAMERA_FAULTS, camera)
            transaction.record(self._event(actor, "fault_ended", f"{actor} ended the simulated fault of {camera}"))

        await self._store.transaction((CAMERA_FAULTS,), work)

    def _require(self, camera: str) -> None:
        if camera not in self._cameras:
            raise NotFoundError(f"there is no simulated camera {camera!r}")

    def _event(self, actor: str, kind: str, text: str) -> Event:
        return Event(stamp_ns=self._clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)
