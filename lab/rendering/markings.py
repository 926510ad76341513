"""White paint on the floor, from the lanes' centre lines: a dashed line along the middle of each lane, a solid one along
either edge, and nothing where lanes cross."""

from shapely import LineString, MultiLineString, Polygon, segmentize, unary_union
from shapely.geometry.base import BaseGeometry
from shapely.ops import substring

from protocol.lab import Lab

LANE_HALF_WIDTH_M = 0.4
_PAINT_WIDTH_M = 0.04
_DASH_M, _GAP_M = 0.25, 0.25
_SEGMENT_M = 0.1
"""Outlines are cut this short, so that a lens may bend them."""


def painted_outlines(lab: Lab) -> list[Polygon]:
    """Outlines of all painted strips, metres, map frame."""
    lanes = [LineString(lane) for lane in lab.simulation.lanes]
    strips: list[Polygon] = []
    for lane in lanes:
        # Half a paint's width short, so that edges meet in full corners.
        inside = LANE_HALF_WIDTH_M - _PAINT_WIDTH_M / 2
        others = unary_union([other.buffer(inside, cap_style="flat") for other in lanes if other is not lane])
        edges = [lane.offset_curve(side * LANE_HALF_WIDTH_M) for side in (-1.0, 1.0)]
        pieces = [piece for line in edges for piece in _lines(line.difference(others))]
        for piece in _lines(lane.difference(others)):
            pieces += _dashes(piece)
        strips += [piece.buffer(_PAINT_WIDTH_M / 2, cap_style="flat") for piece in pieces]
    return [segmentize(strip, _SEGMENT_M) for strip in strips if not strip.is_empty]


def _dashes(line: LineString) -> list[LineString]:
    dashes: list[LineString] = []
    start = _GAP_M / 2
    while start < line.length:
        dash = substring(line, start, min(line.length, start + _DASH_M))
        if isinstance(dash, LineString) and dash.length > 0:
            dashes.append(dash)
        start += _DASH_M + _GAP_M
    return dashes


def _lines(shape: BaseGeometry) -> list[LineString]:
    if isinstance(shape, LineString):
        return [] if shape.is_empty else [shape]
    return list(shape.geoms) if isinstance(shape, MultiLineString) else []
