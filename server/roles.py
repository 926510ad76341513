"""Roles and who somebody is: viewer < operator < admin; `robot` stands apart and speaks for one robot only."""

from dataclasses import dataclass
from enum import StrEnum


class Role(StrEnum):
    """What somebody may do: look; change and drive; manage users and tokens; or be one robot."""

    VIEWER = "viewer"
    OPERATOR = "operator"
    ADMIN = "admin"
    ROBOT = "robot"


_RANK = {Role.VIEWER: 1, Role.OPERATOR: 2, Role.ADMIN: 3}


@dataclass(frozen=True, slots=True)
class Identity:
    """Somebody who has proven who they are. `name` stands in the history; `holder` tells one session or token from
    another (it holds a stick); `robot` is the one that a robot's token is bound to."""

    name: str
    role: Role
    holder: str
    robot: str | None = None

    def has(self, needed: Role) -> bool:
        """Whether the role is at least `needed`; a robot's is at least none of the others."""
        return self.role is needed or _RANK.get(self.role, 0) >= _RANK.get(needed, 9)

    def is_robot(self, robot: str) -> bool:
        """Whether this is that robot itself."""
        return self.role is Role.ROBOT and self.robot == robot

    def hand(self, tab: str | None) -> str:
        """What holds a stick: this session or token, or one tab of it."""
        return self.holder if tab is None else f"{self.holder}/{tab}"
