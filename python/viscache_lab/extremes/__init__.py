"""Numerical extremes: checks that anyone can run, and the map of where numbers hold.

`viscache doctor --extremes` runs the checks, `viscache reproduce extremes` draws the map.
"""

from viscache_lab.experiment.checks import Case, Check
from viscache_lab.experiment.children import run

__all__ = ["Case", "Check", "run"]
