"""The console: files of web/dist; every other address is the console's own and gets its page."""

from pathlib import Path

from fastapi import APIRouter, Request
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, HTMLResponse, Response

from server.context import Ctx
from server.methods import AllowedMethods

router = APIRouter(include_in_schema=False)

_NOT_BUILT = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Lilliput</title>
<meta http-equiv="refresh" content="5"><body style="font-family: system-ui, sans-serif; margin: 3em">
<h1>The console is not built yet</h1><p>The service runs, its API is at <a href="/api/openapi.json">/api/openapi.json</a>,
but <code>web/dist</code> is missing. <code>./lilliput up</code> builds it; this page tries again by itself.</p></body></html>"""


@router.get("/{path:path}")
async def console(path: str, request: Request, context: Ctx) -> Response:
    """Files whose names carry a digest of their content are kept for ever, everything else is asked for again."""
    if path == "api" or path.startswith("api/"):
        methods: AllowedMethods = request.app.state.allowed_methods
        if methods.of(f"/{path}"):
            raise HTTPException(405)
        raise HTTPException(404, f"there is no /{path}")
    root = context.configuration.console
    index = root / "index.html"
    if not index.is_file():
        return HTMLResponse(_NOT_BUILT, status_code=503, headers={"Cache-Control": "no-store"})
    found = _inside(root, path)
    if found is None:
        if path.startswith("assets/"):
            raise HTTPException(404, f"there is no /{path}")
        return FileResponse(index, headers={"Cache-Control": "no-cache"})
    kept = path.startswith("assets/")
    return FileResponse(found, headers={"Cache-Control": "public, max-age=31536000, immutable" if kept else "no-cache"})


def _inside(root: Path, path: str) -> Path | None:
    """The file of that path below the root; None when there is none, or it lies outside."""
    if not path or "\0" in path:
        return None
    try:
        found = (root / path).resolve()
        return found if found.is_relative_to(root.resolve()) and found.is_file() else None
    except OSError:
        return None
