"""Benchmarks. Each figure is a ratio to a named baseline of the same run; answers are checked.

A module of this folder declares its benches by `@BENCHES.add`; no list has to be kept.
"""

from viscache_lab.experiment.registry import BENCHES
from viscache_lab.experiment.run import run_bench

__all__ = ["BENCHES", "run_bench"]

BENCHES.load()
