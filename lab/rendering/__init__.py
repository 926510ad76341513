"""Rendered frames of the simulated ceiling cameras: those who estimate from them see what a lens would."""

from lab.rendering.camera import CameraRenderer

__all__ = ["CameraRenderer"]
