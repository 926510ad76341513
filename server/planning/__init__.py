"""Ways around obstacles: the floor that is free with clearance, shortest ways over it, and lines that robots can drive.

Pure: grids and polygons in, polylines out; metres in the map frame.
"""

from server.planning.free_space import FreeSpace, Needs
from server.planning.lines import straightened
from server.planning.search import ShortestWays

__all__ = ["FreeSpace", "Needs", "ShortestWays", "straightened"]
