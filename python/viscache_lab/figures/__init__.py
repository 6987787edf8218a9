"""Figures and tables of the papers, reproduced and held against bands.

A module of this folder registers its figures by `@figure`; no list has to be kept.
"""

import importlib
import pkgutil

from viscache_lab.figures import registry
from viscache_lab.figures.everything import reproduce_all
from viscache_lab.figures.registry import FIGURES, FigureInfo, figure, reproduce

__all__ = ["FIGURES", "FigureInfo", "figure", "reproduce", "reproduce_all"]

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")
registry.arrange()
