"""What Figures 3 and 4 of the visibility-map paper must show, written down before they were run.

The figures are pictures without numbers; the bands turn the paper's sentences into numbers.
A scene's *slices* are ρ̄ over θ for d < 0.2 units and ρ̄ over d for θ < 2°, in 64 bins each.
Only bins with n >= 100 pairs count.
"""

from __future__ import annotations

import math

from viscache.figures.outcome import Band

#: ρ̄ of the pairs with d < 0.2 and θ < 2°. The paper's colours turn red from about 0.8 on.
CORNER = Band(0.8, 1.0, "Fig. 4: close to 1 in the top-left corner")

#: R² of a straight line through the slice over θ, 0° to 120°.
LINEAR_IN_THETA = Band(0.9, 1.0, "Sec. 5: falls off near linearly with increasing θ")

#: Share of the fall over the whole slice in d that is done by the middle of it.
#: A straight line has 0.5.
CONVEX_IN_D = Band(
    0.55, 1.5, "Sec. 5: a quicker dropoff in the beginning with d, slower at the end"
)

#: θ in degrees of the largest σ of the slice over θ: not in the first or last tenth.
LARGEST_SIGMA = Band(18.0, 162.0, "expected: σ is largest mid-range")

#: Share of the bins (d, θ) with θ < 90° whose ρ̄ is below 0.
NEGATIVE_SHARE = Band(0.0, 0.05, "Fig. 4: the correlation is rarely below 0")

#: Pairs with θ in [0°, 1°), and in [89°, 91°), over the mean of as wide a band nearby
#: (2° to 7°; 80° to 88° and 92° to 100°): dynamics only.
LINES = Band(3.0, math.inf, "Sec. 4.3: each combination of two flat surfaces gives a line")

#: Ratio of the mean ρ of pairs with θ < 30°: dynamics to mushrooms, mushrooms to garden1.
ORDER = Band(
    1.0, math.inf, "Sec. 4.3: the overall correlation is smaller with difficult visibility"
)

#: Pair estimates of a full run, 10 % around what the paper did per scene.
ESTIMATES = Band(0.9 * 1.9e10, 1.1 * 3.2e10, "Sec. 4.1: 1.9–3.2·10¹⁰ estimates per scene")
