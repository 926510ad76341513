"""What an operator sets per robot: the obstacle box; durable."""

from protocol import keys
from protocol.clock import Clock
from protocol.messages import Event, EventLevel, RobotSettings
from server.repositories.documents import Documents, Store, Transaction

ROBOT_SETTINGS = Documents(keys.ROBOT_SETTINGS, RobotSettings)


class RobotSettingsRepository:
    """Settings by robot."""

    def __init__(self, store: Store, clock: Clock) -> None:
        self._store, self._clock = store, clock

    async def all(self) -> dict[str, RobotSettings]:
        return await self._store.all(ROBOT_SETTINGS)

    async def put(self, robot: str, settings: RobotSettings, actor: str) -> RobotSettings:
        """Replaces the robot's settings as a whole."""

        async def work(transaction: Transaction) -> RobotSettings:
            transaction.put(ROBOT_SETTINGS, robot, settings)
            transaction.record(
                Event(
                    stamp_ns=self._clock.now_ns(),
                    level=EventLevel.INFO,
                    source=actor,
                    kind="robot_settings_changed",
                    text=f"{actor} set {robot}: {settings.model_dump_json(exclude_none=True)}",
                )
            )
            return settings

        return await self._store.transaction((ROBOT_SETTINGS,), work)
