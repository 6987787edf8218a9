"""Figures of a sweep for papers. Each function returns a matplotlib Figure, without pyplot."""

from viscache.plots.sweeps import (
    FORMATS,
    MARKERS,
    heatmap,
    label,
    pairs,
    save,
    save_all,
    trade,
)
from viscache.sweeps.swept import COLORS, colors_for, pareto, settings_of

__all__ = [
    "COLORS",
    "FORMATS",
    "MARKERS",
    "colors_for",
    "heatmap",
    "label",
    "pairs",
    "pareto",
    "save",
    "save_all",
    "settings_of",
    "trade",
]
