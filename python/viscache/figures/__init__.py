"""Figures and tables of the papers, reproduced and held against bands."""

from viscache.figures.everything import reproduce_all
from viscache.figures.registry import FIGURES, FigureInfo, reproduce

__all__ = ["FIGURES", "FigureInfo", "reproduce", "reproduce_all"]
