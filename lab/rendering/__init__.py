"""Rendered frames of the simulated ceiling cameras (issue of pixels, not of numbers: estimators see what a lens would)."""

from lab.rendering.camera import CameraRenderer

__all__ = ["CameraRenderer"]
