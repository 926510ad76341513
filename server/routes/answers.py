"""Descriptions of the refusals that routes share, for the OpenAPI document."""

from typing import Any

from server.views.base import Problem

_MEANINGS = {
    400: "The body is not JSON.",
    401: "Not logged in, or the token is not valid.",
    403: "The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`.",
    404: "It does not exist.",
    409: "Its state forbids this; the detail says why.",
    413: "The body is too large.",
    429: "Too many wrong passwords; the header `Retry-After` says how long to wait.",
    503: "Redis (or what else is needed) is out of reach; nothing was changed.",
}


def refusals(*codes: int) -> dict[int | str, dict[str, Any]]:
    """The `responses` of a route: what may refuse it, beside 400, 401, 403 and 503."""
    return {code: {"model": Problem, "description": _MEANINGS[code]} for code in sorted({400, 401, 403, 503, *codes})}


def open_refusals(*codes: int) -> dict[int | str, dict[str, Any]]:
    """As `refusals`, for routes that need no login."""
    return {code: {"model": Problem, "description": _MEANINGS[code]} for code in sorted({400, 503, *codes})}
