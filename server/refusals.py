"""Maps what is raised to answers: `{"detail": "..."}`, or FastAPI's list for 422."""

import logging
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from redis.exceptions import RedisError
from starlette.responses import JSONResponse

from protocol.errors import BusUnavailableError, DecodeError
from server.errors import ConflictError, InvalidError, NotFoundError, UnavailableError

_logger = logging.getLogger(__name__)
_CODES: dict[type[Exception], int] = {NotFoundError: 404, ConflictError: 409, UnavailableError: 503}


def install(app: FastAPI) -> None:
    """Adds the handlers to the app."""
    for kind in _CODES:
        app.add_exception_handler(kind, _refused)
    app.add_exception_handler(InvalidError, _invalid)
    app.add_exception_handler(RequestValidationError, _not_valid)
    for kind in (RedisError, BusUnavailableError, ConnectionError):
        app.add_exception_handler(kind, _redis_away)
    app.add_exception_handler(DecodeError, _damaged)


async def _refused(_request: Request, error: Exception) -> JSONResponse:
    code = next(code for kind, code in _CODES.items() if isinstance(error, kind))
    return JSONResponse({"detail": str(error)}, status_code=code)


async def _invalid(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, InvalidError)
    return _unprocessable([{"type": "value_error", "loc": list(error.location), "msg": str(error)}])


async def _not_valid(_request: Request, error: Exception) -> JSONResponse:
    """Without the input: it may be NaN, which JSON cannot say, or a password."""
    assert isinstance(error, RequestValidationError)
    items: list[dict[str, Any]] = [
        {"type": item["type"], "loc": list(item["loc"]), "msg": item["msg"]} for item in error.errors()
    ]
    return _unprocessable(items)


async def _redis_away(request: Request, error: Exception) -> JSONResponse:
    _logger.warning("%s %s: %s", request.method, request.url.path, error)
    return JSONResponse(
        {"detail": "Redis is out of reach; nothing was changed. Try again."},
        status_code=503,
        headers={"Retry-After": "1"},
    )


async def _damaged(request: Request, error: Exception) -> JSONResponse:
    """The error names the record, never what is in it."""
    _logger.error("%s %s: %s", request.method, request.url.path, error)
    return JSONResponse({"detail": f"{error}. Nothing was changed; replace or delete it."}, status_code=503)


def _unprocessable(items: list[dict[str, Any]]) -> JSONResponse:
    return JSONResponse({"detail": items}, status_code=422)
