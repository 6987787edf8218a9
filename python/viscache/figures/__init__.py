"""Figures and tables of the papers, reproduced and held against bands."""

from viscache.figures.registry import FIGURES, FigureInfo, reproduce

__all__ = ["FIGURES", "FigureInfo", "reproduce"]
