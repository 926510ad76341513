"""Which methods an address takes: for answers to those that it does not (405 and its `Allow`, RFC 9110 15.5.6). Several routes
share one address, each with its method; the framework's own answer knows only the first of them."""

from collections.abc import Iterable

from fastapi import FastAPI, Request
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse
from starlette.routing import BaseRoute, Route, compile_path


class AllowedMethods:
    """Of routes below a prefix."""

    def __init__(self, prefix: str, routes: Iterable[BaseRoute]) -> None:
        self._patterns = [
            (compile_path(prefix + route.path)[0], route.methods or set[str]())
            for route in routes
            if isinstance(route, Route)
        ]

    def of(self, path: str) -> list[str]:
        """In alphabetical order; empty when there is no such address."""
        return sorted({method for pattern, methods in self._patterns if pattern.match(path) for method in methods})

    def install(self, app: FastAPI) -> None:
        """Makes the app's refusals of methods tell all that are allowed."""

        async def refused(request: Request, error: Exception) -> JSONResponse:
            assert isinstance(error, HTTPException)
            allowed = self.of(request.url.path)
            headers = {"Allow": ", ".join(allowed)} if allowed else error.headers
            return JSONResponse({"detail": error.detail}, status_code=405, headers=headers)

        app.add_exception_handler(405, refused)
        app.state.allowed_methods = self
