"""Figures of a sweep and of passes for papers: matplotlib Figures, without pyplot."""

from viscache.plots.over_time import error_over_time
from viscache.plots.sweeps import FORMATS, MARKERS, heatmap, label, pairs, save, save_all, trade
from viscache.sweeps.swept import COLORS, colors_for, pareto, settings_of

__all__ = [
    "COLORS",
    "FORMATS",
    "MARKERS",
    "colors_for",
    "error_over_time",
    "heatmap",
    "label",
    "pairs",
    "pareto",
    "save",
    "save_all",
    "settings_of",
    "trade",
]
