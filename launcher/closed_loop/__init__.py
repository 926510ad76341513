"""Robots, guidance and the simulated lab in one process and in simulated time: the agents' and guidance's own code, with
everything between them simulated. For experiments and tests of what one process alone cannot show."""

from launcher.closed_loop.agent import SimulatedAgent
from launcher.closed_loop.links import Link
from launcher.closed_loop.loop import ClosedLoop, Latencies
from launcher.closed_loop.sight import Sight
from launcher.closed_loop.store import SimulatedStore

__all__ = ["ClosedLoop", "Latencies", "Link", "Sight", "SimulatedAgent", "SimulatedStore"]
