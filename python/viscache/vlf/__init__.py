"""The visibility field (Mortensen, Khanna, Yu, Slater 2007)."""

from viscache.vlf.directions import (
    DIRECTION_COUNTS,
    direction_frames,
    direction_weights,
    directions,
    nearest_direction,
)

__all__ = [
    "DIRECTION_COUNTS",
    "direction_frames",
    "direction_weights",
    "directions",
    "nearest_direction",
]
