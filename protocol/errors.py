"""The errors of the protocol package.

- ProtocolError
    - DecodeError: bytes that are not the message they should be
    - LabFileError: a lab description that cannot be used; carries file and line
    - BusUnavailableError: Redis did not take a message that must be delivered
"""

from dataclasses import dataclass


class ProtocolError(Exception):
    """Base of all errors raised here."""


class DecodeError(ProtocolError):
    """Bytes that are not the message they should be; the text says which message and what is wrong."""


class BusUnavailableError(ProtocolError):
    """Redis is out of reach and the message was not delivered."""


@dataclass(frozen=True, slots=True)
class LabProblem:
    """One thing wrong in a lab file: the line (1-based; 0 when it concerns the file as a whole), where, and what."""

    line: int
    where: str
    what: str


class LabFileError(ProtocolError):
    """A lab description that cannot be used; its text has one `file:line: where: what` per problem."""

    def __init__(self, path: str, problems: list[LabProblem]) -> None:
        self.path = path
        self.problems = tuple(problems)
        super().__init__(
            "\n".join(
                f"{path}:{p.line}: {p.where}: {p.what}" if p.where else f"{path}:{p.line}: {p.what}" for p in problems
            )
        )
