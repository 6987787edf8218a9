"""Frames: layers of pixels, counters and parameters."""

from viscache.frame.frame import Frame

__all__ = ["Frame"]
