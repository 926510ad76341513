"""The obstacle grid on its way to a browser."""

import base64

from pydantic import Field

from protocol.messages import FloorRaster
from server.views.base import View


class ObstaclesView(View):
    """A grid on the floor. Cell (row, column) covers x from origin_x + column * cell_m and y from origin_y + row * cell_m;
    rows grow with y."""

    stamp_ns: int = Field(description="When its cells last changed.")
    origin_x: float
    origin_y: float
    cell_m: float
    columns: int
    rows: int
    occupied: str = Field(description="Base64 of a bit field, row-major, most significant bit first.")
    observed: str = Field(description="As `occupied`; a cell that is not observed says nothing.")


def obstacles_view(raster: FloorRaster) -> ObstaclesView:
    """The view of a raster."""
    return ObstaclesView(
        stamp_ns=raster.stamp_ns,
        origin_x=raster.origin_x,
        origin_y=raster.origin_y,
        cell_m=raster.cell_m,
        columns=raster.columns,
        rows=raster.rows,
        occupied=base64.b64encode(raster.occupied).decode(),
        observed=base64.b64encode(raster.observed).decode(),
    )
