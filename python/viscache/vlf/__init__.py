"""The visibility field (Mortensen, Khanna, Yu, Slater 2007)."""

from viscache.vlf.aligned import AlignedRows, aligned_occlusion, trace_aligned
from viscache.vlf.directions import (
    DIRECTION_COUNTS,
    direction_frames,
    direction_weights,
    directions,
    nearest_direction,
)
from viscache.vlf.dynamic import DynamicField, DynamicHits

__all__ = [
    "DIRECTION_COUNTS",
    "AlignedRows",
    "DynamicField",
    "DynamicHits",
    "aligned_occlusion",
    "direction_frames",
    "direction_weights",
    "directions",
    "nearest_direction",
    "trace_aligned",
]
