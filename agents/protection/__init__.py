"""The robot's own protection: a safety scanner's fields, which stop it without anybody else. Pure."""

from agents.protection.field import Outline, Sweep, braking_sweep, in_the_way
from agents.protection.guard import ProtectiveGuard
from agents.protection.scan import EchoFilter, RangeScan

__all__ = ["EchoFilter", "Outline", "ProtectiveGuard", "RangeScan", "Sweep", "braking_sweep", "in_the_way"]
