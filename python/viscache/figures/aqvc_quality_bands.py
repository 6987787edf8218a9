"""What quality choices of the quantized cache must show, written down before the first full run.

`expected` quotes a prototype in double precision of before this code, or says what the choice is
for. What is merely recorded has no band. After quick runs, whose pictures are small, and before any
full one, the band of slits was opened downwards: light that no representative sees is lost. What
the first full run changed is row A40 of docs/deviations.md.
"""

from __future__ import annotations

import math

from viscache.figures.outcome import Band

#: Share of the cells on the front of a wall a thousandth of a cell thick that hold its back, too.
LEAKING_CELLS = {
    "round": Band(0, 0, "Sec. 3.3: opposite normals have grids of their own"),
    "floor": Band(0, 0, "Sec. 3.3: opposite normals have grids of their own"),
    "octahedral": Band(0, 0, "Sec. 3.3: opposite normals have grids of their own"),
    "single": Band(0.9, 1, "expected: a cell holds both sides of what is thinner than it"),
}

#: Light where the exact picture is black, one grid for all normals over rounded bins.
SINGLE_LEAKS = Band(1.0, math.inf, "expected: walls and floors share cells, too")

#: Rays over those with rounded bins.
RAYS_OF_BINS = {
    "octahedral": Band(0.8, 1.25, "expected: about as many bins, about as many cells"),
    "single": Band(0.0, 1.0, "expected: surfaces of different normals share cells"),
}

#: Rays without the grids' offset over those with it.
RAYS_WITHOUT_OFFSET = Band(0.95, 3.0, "expected: planes on cell faces have up to twice the cells")

#: rel_l1 with neighbours along the tangent plane over that with the same v_z; and rays.
TANGENT_ERROR = Band(0.6, 1.05, "expected: a prototype measured −25 % in a rotated scene")
TANGENT_RAYS = Band(0.95, 1.6, "expected: a prototype measured +35 % in a rotated scene")

#: Largest rel_l1 over the smallest, cos θ at least 0.01, 0.05 and 0.2.
COSMIN_ERROR = Band(1.0, 1.1, "expected: no measurable effect in a prototype")

#: Group errors with refinement over without, where the default refines.
REFINED_ERROR = Band(0.0, 1.0, "Sec. 3.6: refinement lowers the error of shadow edges")

#: Bias of the energy without refinement over half the width of its 95 % interval: T7's 3σ.
PLAIN_BIAS = Band(-1.5, 1.5, "Eq. 12: unbiased over grids and orders")

#: Relative bias with refinement, in Alg. 2 as the paper has it.
REFINED_BIAS = {
    "slats": Band(0.0, 0.15, "expected: more light, as a prototype's +0.78 % with fewer slats"),
    "slits": Band(-0.25, 0.0, "expected: the mirrored effect, less light"),
}
