"""Messages to bytes and back: JSON for pydantic models and msgspec structs alike, one DecodeError."""

from collections.abc import Callable
from functools import cache, partial
from typing import Any, TypeVar

import msgspec
from pydantic import BaseModel, ValidationError

from protocol.errors import DecodeError

M = TypeVar("M", bound=BaseModel | msgspec.Struct)

UNDECODABLE = (msgspec.MsgspecError, UnicodeDecodeError, RecursionError)
"""What msgspec raises for bytes that hold no such message; the last for JSON nested too deeply."""


def encode(message: BaseModel | msgspec.Struct) -> bytes:
    """Compact JSON."""
    if isinstance(message, BaseModel):
        return message.model_dump_json().encode()
    return msgspec.json.encode(message)


def decode(kind: type[M], data: bytes | str) -> M:
    """The message in `data`; DecodeError, naming the kind and the field, when it is none."""
    try:
        return _decoder(kind)(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise DecodeError(f"not a {kind.__name__}: {where + ': ' if where else ''}{first['msg']}") from error
    except UNDECODABLE as error:
        raise DecodeError(f"not a {kind.__name__}: {error}") from error


@cache
def _decoder(kind: type[Any]) -> Callable[[bytes | str], Any]:
    if issubclass(kind, BaseModel):
        return partial(kind.model_validate_json, strict=True)  # as msgspec: "0.3" is no number
    return msgspec.json.Decoder(kind).decode
