"""What the service refuses, as exceptions that the routes map to status codes.

- ServiceError
    - NotFoundError (404): the thing named does not exist
    - ConflictError (409): it exists, but its state forbids what was asked
    - InvalidError (422): the request makes no sense; carries the field
    - UnavailableError (503): something that the service needs is out of reach
"""


class ServiceError(Exception):
    """Base of all refusals; its text is a sentence for the person who asked."""


class NotFoundError(ServiceError):
    """The thing named does not exist."""


class ConflictError(ServiceError):
    """It exists, but its state forbids what was asked."""


class InvalidError(ServiceError):
    """The request makes no sense: `location` is the path of the field, e.g. ("body", "legs", 2, "waypoint")."""

    def __init__(self, location: tuple[str | int, ...], text: str) -> None:
        self.location = location
        super().__init__(text)


class UnavailableError(ServiceError):
    """Something that the service needs is out of reach."""
