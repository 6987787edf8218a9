"""Numbers of the visibility-map paper about its cache, at 1600x1200 on two cores of 2008."""

from __future__ import annotations

from dataclasses import dataclass

PIXELS = 1600 * 1200


@dataclass(frozen=True, slots=True)
class Cache:
    """A column of Table 2."""

    records: int
    map_size: int
    rays_per_pixel: float


@dataclass(frozen=True, slots=True)
class Cost:
    """A column of Table 3; seconds."""

    samples: int
    product_s: float
    """With product importance sampling only."""
    cache_s: float
    """With the control variate."""
    overhead_s: float
    overhead_percent: float
    variance_ratio: float


#: Table 2.
CACHES = {
    "garage": Cache(14_300, 32, 3.81),
    "dynamics": Cache(6_200, 64, 6.61),
    "garden1": Cache(17_100, 32, 4.56),
}

#: Table 3.
COSTS = {
    "garage": (
        Cost(10, 103.0, 124.9, 21.9, 21.3, 0.212),
        Cost(30, 155.3, 178.3, 23.0, 14.8, 0.339),
        Cost(100, 325.1, 346.8, 21.7, 6.7, 0.497),
        Cost(300, 779.1, 800.9, 21.8, 2.8, 0.633),
    ),
    "dynamics": (
        Cost(10, 65.0, 85.0, 20.0, 30.8, 0.405),
        Cost(30, 82.1, 102.6, 20.5, 24.9, 0.533),
        Cost(100, 135.2, 157.9, 22.7, 16.8, 0.641),
        Cost(300, 280.5, 303.4, 22.9, 8.1, 0.734),
    ),
    "garden1": (
        Cost(10, 229.1, 309.2, 80.1, 34.9, 0.775),
        Cost(30, 451.8, 534.7, 82.9, 18.3, 0.997),
        Cost(100, 1211.7, 1307.1, 95.4, 7.9, 1.190),
        Cost(300, 3220.6, 3306.8, 86.2, 2.7, 1.244),
    ),
}
SAMPLES = tuple(cost.samples for cost in COSTS["garage"])

#: Figure 13: samples per pixel of both sides in equal time, and the remaining variance.
EQUAL_TIME_S, EQUAL_TIME_SAMPLES, EQUAL_TIME_RATIO = 178.0, (30, 39), 0.489

#: Figure 10: ambient occlusion of 259k triangles, 4 shading points per pixel.
AO_TRIANGLES, AO_SAMPLES, AO_RAYS = 259_000, 4, 1024
AO_SECONDS, AO_CACHE_SECONDS, AO_CACHE_RAYS = 2776.0, 44.0, 17.7

#: Figure 11.
PREVIEW_RECORDS = 12_500

#: Section 7: bytes of a record of 32x32 cells, and of a cache of 14300 of them.
RECORD_BYTES, CACHE_MEGABYTES = 172, 2.4

#: Equation 9 and Figure 5.
STEEPNESS, THETA_MAX_DEG = 5.0, 30.0
