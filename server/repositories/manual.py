"""Manual drive: one hand at a time on a robot's stick, by a lease that must be renewed (spec gpss: manual outranks
automatic, releasing it hands back)."""

from protocol.channels import MANUAL
from protocol.clock import Clock
from protocol.lab import VehicleSpec
from protocol.messages import Event, EventLevel, ManualDrive
from server.errors import ConflictError
from server.repositories.documents import Store, Transaction, documents_of

LEASE_S = 0.5
_LEASE_NS = round(LEASE_S * 1e9)
_MANUAL = documents_of(MANUAL)


class ManualDriveRepository:
    """The lease of each robot's stick."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock

    async def drive(
        self, vehicle: VehicleSpec, linear_mps: float, angular_radps: float, holder: str, actor: str
    ) -> ManualDrive:
        """Takes or renews the stick with this twist, clipped to what the vehicle can do. ConflictError while somebody
        else's lease is fresh."""
        limits = vehicle.limits

        async def work(transaction: Transaction) -> ManualDrive:
            now_ns = self._clock.now_ns()
            current = await transaction.find(_MANUAL, vehicle.id)
            held = current is not None and current.expires_ns > now_ns
            if held and current is not None and current.holder != holder:
                raise ConflictError(f"{current.by or 'somebody'} drives {vehicle.id} by hand")
            drive = ManualDrive(
                robot=vehicle.id,
                linear_mps=max(-limits.speed_mps, min(limits.speed_mps, linear_mps)),
                angular_radps=max(-limits.yaw_rate_radps, min(limits.yaw_rate_radps, angular_radps)),
                holder=holder,
                by=actor,
                expires_ns=now_ns + _LEASE_NS,
            )
            transaction.publish(MANUAL, vehicle.id, drive)
            if not held:
                transaction.record(self._event(actor, "manual_taken", f"{actor} drives {vehicle.id} by hand"))
            return drive

        return await self._store.transaction((_MANUAL,), work)

    async def release(self, robot: str, holder: str, actor: str) -> None:
        """Lets go, if somebody holds it at all. ConflictError while it is somebody else."""

        async def work(transaction: Transaction) -> None:
            now_ns = self._clock.now_ns()
            current = await transaction.find(_MANUAL, robot)
            if current is None or current.expires_ns <= now_ns:
                return
            if current.holder != holder:
                raise ConflictError(f"{current.by or 'somebody'} drives {robot} by hand")
            ended = current.model_copy(update={"linear_mps": 0.0, "angular_radps": 0.0, "expires_ns": now_ns})
            transaction.publish(MANUAL, robot, ended)
            transaction.record(self._event(actor, "manual_released", f"{actor} let go of {robot}"))

        await self._store.transaction((_MANUAL,), work)

    def _event(self, actor: str, kind: str, text: str) -> Event:
        return Event(stamp_ns=self._clock.now_ns(), level=EventLevel.INFO, source=actor, kind=kind, text=text)
