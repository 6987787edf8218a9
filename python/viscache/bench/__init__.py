"""Benches: every figure a ratio against a named baseline in the same run, and the answer checked."""

from viscache.bench.registry import BENCHES, BenchInfo, run, run_all

__all__ = ["BENCHES", "BenchInfo", "run", "run_all"]
