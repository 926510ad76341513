"""What a camera sees on the floor: obstacles against a learned background, and a picture of the floor itself."""

from localization.floor.observer import FloorObserver

__all__ = ["FloorObserver"]
