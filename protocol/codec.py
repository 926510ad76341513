"""Messages to bytes and back: JSON for pydantic models and msgspec structs alike, one DecodeError."""

from functools import cache
from typing import Any, TypeVar

import msgspec
from pydantic import BaseModel, ValidationError

from protocol.errors import DecodeError

M = TypeVar("M", bound=BaseModel | msgspec.Struct)


def encode(message: BaseModel | msgspec.Struct) -> bytes:
    """Compact JSON."""
    if isinstance(message, BaseModel):
        return message.model_dump_json().encode()
    return msgspec.json.encode(message)


def decode(kind: type[M], data: bytes | str) -> M:
    """The message in `data`; DecodeError, naming the kind and the field, when it is none."""
    try:
        if issubclass(kind, BaseModel):
            return kind.model_validate_json(data, strict=True)  # as msgspec: "0.3" is no number
        return _struct_decoder(kind).decode(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise DecodeError(f"not a {kind.__name__}: {where + ': ' if where else ''}{first['msg']}") from error
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise DecodeError(f"not a {kind.__name__}: {error}") from error


@cache
def _struct_decoder(kind: type[Any]) -> msgspec.json.Decoder[Any]:
    return msgspec.json.Decoder(kind)
