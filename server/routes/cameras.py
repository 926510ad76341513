"""Cameras, their previews, and the picture of the floor."""

from hashlib import sha256
from typing import Annotated, cast

from fastapi import APIRouter, Header, Path, Response

from protocol import keys
from protocol.channels import CAMERA_STATES
from server.access import Viewer
from server.context import Ctx
from server.errors import NotFoundError
from server.live.reading import read_extrinsics
from server.routes.answers import refusals
from server.views.cameras import CameraView, camera_view

router = APIRouter(tags=["cameras"])

_JPEG = {
    200: {"description": "A JPEG.", "content": {"image/jpeg": {"schema": {"type": "string", "format": "binary"}}}},
    304: {"description": "The picture is still the one of `If-None-Match`."},
}
_CameraId = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$", examples=["cam0"])]


@router.get("/cameras", summary="All cameras", responses=refusals())
async def list_cameras(_identity: Viewer, context: Ctx) -> list[CameraView]:
    """Every camera of the lab description with its state, its place and the floor that it sees."""
    states = await context.bus.latest_all(CAMERA_STATES)
    extrinsics, faults = await read_extrinsics(context.bus), await context.faults.all()
    now_ns = context.clock.now_ns()
    return [
        camera_view(c, states.get(c.id), extrinsics.get(c.id), now_ns, faults.get(c.id)) for c in context.lab.cameras
    ]


@router.get(
    "/cameras/{camera_id}/preview.jpg",
    summary="A camera's newest small picture",
    response_class=Response,
    responses={**_JPEG, **refusals(404)},
)
async def get_preview(
    _identity: Viewer, camera_id: _CameraId, context: Ctx, if_none_match: Annotated[str | None, Header()] = None
) -> Response:
    """A few times a second at most; ask with `If-None-Match`."""
    if camera_id not in {camera.id for camera in context.lab.cameras}:
        raise NotFoundError(f"there is no camera {camera_id!r} in lab {context.lab.name!r}")
    data = cast("bytes | None", await context.bus.redis.hget(keys.PREVIEWS, camera_id))  # pyright: ignore[reportGeneralTypeIssues]  # typed for both clients
    if data is None:
        raise NotFoundError(f"{camera_id} has not sent a picture yet")
    return _picture(data, if_none_match, {})


@router.get(
    "/floor.jpg",
    summary="The floor, stitched from all cameras",
    response_class=Response,
    responses={**_JPEG, **refusals(404)},
)
async def get_floor(_identity: Viewer, context: Ctx, if_none_match: Annotated[str | None, Header()] = None) -> Response:
    """Seen from above, y upwards; the header `X-Bounds` has its `minx,miny,maxx,maxy` in metres."""
    data, raw_bounds = cast(
        "tuple[bytes | None, bytes | None]",
        tuple(await context.bus.redis.mget(keys.FLOOR_PICTURE, keys.FLOOR_PICTURE_BOUNDS)),
    )
    if data is None or raw_bounds is None:
        raise NotFoundError("there is no picture of the floor yet: no calibrated camera has sent one")
    bounds = ",".join(raw_bounds.decode().strip("[] \n").replace(" ", "").split(","))
    return _picture(data, if_none_match, {"X-Bounds": bounds})


def _picture(data: bytes, if_none_match: str | None, headers: dict[str, str]) -> Response:
    """The picture with its tag, or 304 when the browser has that one. It is kept by nobody else."""
    tag = f'"{sha256(data).hexdigest()[:20]}"'
    headers = {"ETag": tag, "Cache-Control": "private, no-cache", **headers}
    known = {part.strip().removeprefix("W/") for part in (if_none_match or "").split(",")}
    if tag in known:
        return Response(status_code=304, headers=headers)
    return Response(data, media_type="image/jpeg", headers=headers)
