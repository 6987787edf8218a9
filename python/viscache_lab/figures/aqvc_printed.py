"""Numbers of the quantized cache's paper: an i7-2600K with a Quadro 6000, 1280×800 pixels."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Scene:
    """A scene of Section 5; the ratios are those of Section 5.2, on the GPU."""

    triangles: int
    total_to_shading: float
    """Time of the exact frame over its shading time; the paper's text says "shading to total"."""
    left_to_gain: float
    """Upper bound of any algorithm's speed-up over the cached frame."""

    @property
    def implied_speedup(self) -> float:
        """The cached frame's speed-up, which follows from the two."""
        return self.total_to_shading / self.left_to_gain


#: Section 5 and 5.2.
SCENES = {
    "apartment": Scene(750_000, 12, 2.5),
    "delta": Scene(750_000, 18, 3.4),
    "conference": Scene(280_000, 5, 2.1),
    "san miguel": Scene(10_000_000, 37, 4.7),
    "hairball": Scene(3_000_000, 26, 6.7),
}
#: Section 5: the largest ray reduction. Section 5.2: its speed-up.
RAY_REDUCTION, SPEEDUP = 50.0, 8.0
#: Section 5: C_E of the sweeps for delta lights and others, with and without anti-aliasing.
DELTA_AA, DELTA_PLAIN = (4, 36), (4, 18)
SMOOTH_AA, SMOOTH_PLAIN = (10, 64), (4, 24)
#: Section 5: the apartment's omni lights always have this C_E.
APARTMENT_POINT_C_E = 4.0
#: Figure 6.
HAIRBALL_SPEEDUP = 3.0
#: Figure 5 and Section 5.2: bidirectional path tracing.
BIDIRECTIONAL_C_E, BIDIRECTIONAL_REDUCTION = 12.0, 6.0
#: Figure 5: San Miguel.
SAN_MIGUEL_C_E = 36.0
#: Section 5.4: shadow maps of 1024×1024 take this many times the cached frame with C_E = 14.
MAPS_C_E, MAPS_RESOLUTION, MAPS_SLOWER = 14.0, 1024, 2.0
#: Section 5.2: share of shading in the apartment's frame on the CPU, and the speed-up's bound.
CPU_SHADING_SHARE, CPU_BOUND = 0.32, 3.0
#: Section 4.4: frame time with 256 MB over that with 1 GB of table.
LARGER_TABLE = 1.05
#: Section 5.3: frames per second with reduced sampling.
FRAMES_PER_SECOND = {"apartment": 2.0, "san miguel": 2.0, "delta": 3.0, "conference": 1.5}
