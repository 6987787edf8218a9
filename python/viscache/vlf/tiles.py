"""Tiles and leaves of the visibility field: which a triangle covers, and which a ray crosses."""

from __future__ import annotations

from viscache import _core
from viscache._core.vlf import cover_tiles, walk_leaves, walk_tiles
from viscache.scene import Scene

__all__ = ["cover_tiles", "expected_references", "walk_leaves", "walk_tiles"]


def expected_references(scene: Scene, n_tiles: int) -> float:
    """Expected entries in the lists of one direction, without splits along the depth."""
    return _core.vlf.expected_references(scene._core, n_tiles)
