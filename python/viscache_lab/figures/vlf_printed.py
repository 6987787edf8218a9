"""Numbers of the visibility field's paper, measured on a Pentium 4 of 2.8 GHz with 2 GB."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Occlusion:
    """A row of Table 1: 256x256 pixels with 513 rays each."""

    triangles: int
    crt_s: float
    crt_depth: int
    field_s: float
    field_depth: int
    speedup: float


#: Table 1.
OCCLUSION = {
    "cow": Occlusion(5_800, 38.01, 16, 15.15, 3, 2.51),
    "scorpion": Occlusion(10_000, 32.19, 19, 17.88, 3, 1.80),
    "bugatti": Occlusion(11_000, 43.54, 17, 21.63, 4, 2.01),
    "church": Occlusion(16_000, 25.50, 19, 14.07, 4, 1.81),
    "tugboat": Occlusion(34_000, 44.36, 23, 30.65, 4, 1.45),
}
OCCLUSION_PIXELS, OCCLUSION_RAYS = 256 * 256, 513

#: Section 7: millions of rays per second in the church.
CHURCH_CRT, CHURCH_FIELD = 1.3, 2.4

#: Section 6: the fixed parameters, and the best depths in the classroom.
DIRECTIONS, TILES = 513, 128
CLASSROOM_TRIANGLES, CLASSROOM_LIGHTS, CLASSROOM_FRAMES = 51_208, 4, 420
CLASSROOM_CRT_DEPTH, CLASSROOM_FIELD_DEPTH = 23, 5
CLASSROOM_SIZE, RANDOM_SIZE = (256, 256), (512, 512)

#: Figure 4: triangles of the two random scenes.
RANDOM_SHOWN = (9_000, 16_000)
