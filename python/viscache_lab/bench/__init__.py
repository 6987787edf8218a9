"""Benchmarks. Each figure is a ratio to a named baseline of the same run; answers are checked."""

from viscache_lab.bench.registry import BENCHES, BenchInfo, run, run_all

__all__ = ["BENCHES", "BenchInfo", "run", "run_all"]
