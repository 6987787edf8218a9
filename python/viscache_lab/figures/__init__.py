"""Figures and tables of the papers, reproduced and held against bands.

A module of this folder declares its figures by `@FIGURES.add`; no list has to be kept.
"""

from viscache_lab.experiment.registry import FIGURES
from viscache_lab.experiment.run import reproduce, reproduce_all

__all__ = ["FIGURES", "reproduce", "reproduce_all"]

FIGURES.load()
