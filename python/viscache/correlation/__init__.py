"""Correlation statistics of visibility: Section 4 of the visibility-map paper.

Places points on surfaces, traces a row of bits for each, and correlates all pairs over distance and
angle.
"""

from viscache.correlation import plots
from viscache.correlation.dataset import load_dataset, save_dataset
from viscache.correlation.derived import (
    Box,
    correlation_lengths,
    high_correlation_box,
    predicted_variance_ratio,
)
from viscache.correlation.measure import correlate, measure, phi
from viscache.correlation.point_rows import point_rows
from viscache.correlation.rows import DirectionSet, surface_points, visibility_rows

__all__ = [
    "Box",
    "DirectionSet",
    "correlate",
    "correlation_lengths",
    "high_correlation_box",
    "load_dataset",
    "measure",
    "phi",
    "plots",
    "point_rows",
    "predicted_variance_ratio",
    "save_dataset",
    "surface_points",
    "visibility_rows",
]
