"""Correlation statistics of visibility: Section 4 of the visibility-map paper."""

from viscache.correlation.rows import DirectionSet, surface_points, visibility_rows

__all__ = ["DirectionSet", "surface_points", "visibility_rows"]
