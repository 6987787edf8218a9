"""The kernels under `correlate`, which benches time alone."""

from viscache._core.correlation import and_popcount_add, total_intersections

__all__ = ["and_popcount_add", "total_intersections"]
