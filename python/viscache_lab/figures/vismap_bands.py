"""Bands of the visibility-map paper's figures, written before any of them was run.

Figures 3 and 4 are pictures without numbers; their bands turn the paper's sentences into numbers.
A scene's *slices* are ρ̄ over θ for d < 0.2 units and ρ̄ over d for θ < 2°, with 64 bins each. Only
bins with n >= 100 pairs count.

Our scenes are stand-ins, so values that depend mainly on the scene (record counts, seconds) have no
band; the paper's are printed beside ours. A *variance ratio* is the mean squared error with the
cache over that of product sampling, both of linear luminance over all pixels, from independent
renders at equal samples. *iid* samples are independent, *rqmc* ones a randomised (0,2)-sequence.
`alpha` is the factor of the control variate; the paper has `one`.

The band of the mean ambient occlusion, that of equal samples and those of quick runs (`QUICK_…`)
were written after a first quick run. The settings of Figure 10 were chosen on its own scene.
"""

from __future__ import annotations

import math

from viscache_lab.experiment import Band
from viscache_lab.experiment.claim_rules import Claim

# Figures 3 and 4: correlation

#: ρ̄ of the pairs with d < 0.2 and θ < 2°. The paper's colours turn red from about 0.8 on.
CORNER = Band(0.8, 1.0, "Fig. 4: close to 1 in the top-left corner", claimed=Claim.nearly_all())

#: R² of a straight line through the slice over θ, 0° to 120°.
LINEAR_IN_THETA = Band(
    0.9, 1.0, "Sec. 5: falls off near linearly with increasing θ", claimed=Claim.nearly_all()
)

#: Share of the slice's total fall over d that is reached at its middle.
#: A straight line has 0.5.
CONVEX_IN_D = Band(
    0.55,
    1.5,
    "Sec. 5: a quicker dropoff in the beginning with d, slower at the end",
    claimed=Claim.more(0.5),
)

#: θ in degrees of the largest σ of the slice over θ: not in the first or last tenth.
LARGEST_SIGMA = Band(18.0, 162.0, "expected: σ is largest mid-range")

#: Share of the bins (d, θ) with θ < 90° whose ρ̄ is below 0.
NEGATIVE_SHARE = Band(
    0.0, 0.05, "Fig. 4: the correlation is rarely below 0", claimed=Claim.nearly_none()
)

#: Pairs with θ in [0°, 1°), and in [89°, 91°), over the mean of as wide a band nearby
#: (2° to 7°; 80° to 88° and 92° to 100°): dynamics only.
LINES = Band(
    3.0,
    math.inf,
    "Sec. 4.3: each combination of two flat surfaces gives a line",
    claimed=Claim.much_more(),
)

#: Ratio of the mean ρ of pairs with θ < 30°: dynamics to mushrooms, mushrooms to garden1.
ORDER = Band(
    1.0,
    math.inf,
    "Sec. 4.3: the overall correlation is smaller with difficult visibility",
    claimed=Claim.more(),
)

#: Pair estimates of a full run: the paper's number per scene, ± 10 %.
ESTIMATES = Band(
    0.9 * 1.9e10,
    1.1 * 3.2e10,
    "Sec. 4.1: 1.9–3.2·10¹⁰ estimates per scene",
    claimed=Claim.about(1.9e10, 3.2e10),
)

# Figure 5

#: Least weight inside the search limits, at λ = 5 and 30°.
LEAST_WEIGHT = Band(
    0.6944,
    0.6945,
    "Eq. 9: (1 - 30/180)(1 - 1/6) = 0.69444; Fig. 5 ends at 0.7",
    claimed=Claim.computed(0.6944, 0.6945),
)

#: Weight at the far end of either axis alone: both 5/6.
EDGE_WEIGHT = Band(
    0.83333,
    0.83334,
    "Eq. 9: 1 - 30/180 = 1 - 1/(1 + 5) = 5/6",
    claimed=Claim.computed(0.83333, 0.83334),
)

#: Slope of the weight over d/d_max at 0.
FIRST_SLOPE = Band(
    -1.0, -0.99, "Eq. 9: -1 whatever the steepness", claimed=Claim.computed(-1.0, -0.99)
)

# Table 2

#: Rays of all records over records · 4^M / 2: one ray per cell of the upper hemisphere.
RAYS_OF_RECORDS = Band(
    0.99,
    1.01,
    "Tab. 2: rays/pixel is records · 4^M / 2 / pixels",
    claimed=Claim.computed(0.99, 1.01),
)

#: Bytes of a record of 32x32 cells.
RECORD_BYTES = Band(172, 172, "Sec. 7: 172 bytes", claimed=Claim.exact(172))

# Table 3

#: Garage, 10 samples, rqmc, only the paper's control variate.
GARAGE_CONTROL_VARIATE = Band(
    0.0, 0.45, "Tab. 3 prints 0.212; our garage is another one", claimed=Claim.at_most(0.212)
)

#: The same in quick runs, whose pixels are four times as wide.
QUICK_GARAGE_CONTROL_VARIATE = Band(
    0.0, 1.0, "Tab. 3: 0.212 at 10 samples", claimed=Claim.at_most(0.212)
)

#: Garage, densities guided by the maps, rqmc, with 10 and 30 samples.
GARAGE_GUIDED = {
    10: Band(0.0, 0.27, "expected: discretised scenes gave 0.24"),
    30: Band(0.0, 0.2, "expected: discretised scenes gave 0.13"),
}

#: Garden, alpha of the previous pass, 10 samples or more, either point set, steady state.
GARDEN_PREVIOUS_PASS = Band(
    0.0, 1.03, "Eq. 5: with the best alpha variance does not rise", claimed=Claim.less()
)

#: Garden, alpha one, at 300 samples: the paper's own weakness.
GARDEN_ONE = Band(
    1.0,
    math.inf,
    "Tab. 3: at the higher sampling rates variance increases (1.244)",
    claimed=Claim.more(),
)

#: Largest over smallest iid ratio of the numbers of samples.
IID_IS_FLAT = Band(
    1.0,
    1.2,
    "Eq. 4: the ratio of iid samples does not depend on their number",
    claimed=Claim.none(),
)

#: Ratio at 300 over ratio at 10 samples, rqmc, alpha one: garage and dynamics.
RQMC_RISES = Band(1.0, math.inf, "Tab. 3: 0.212 to 0.633 and 0.405 to 0.734", claimed=Claim.more())

#: Largest over smallest overhead in seconds of the numbers of samples.
OVERHEAD_IS_CONSTANT = Band(
    1.0, 1.5, "Tab. 3: 1.06, 1.15, 1.19 in the three scenes", claimed=Claim.at_most(1.19)
)

# Figures 1, 13 and 14

#: Garage, variance ratio at equal time.
EQUAL_TIME = Band(0.0, 0.5, "Fig. 13: 0.489", claimed=Claim.at_most(0.489))

#: The same at equal samples.
EQUAL_SAMPLES = Band(
    0.0,
    1.0,
    "Tab. 3: 0.212 to 0.633 in the garage, by the number of samples",
    claimed=Claim.at_most(0.633),
)

#: Variance ratio in pixels with nine in ten light-product samples blocked, over that in pixels with
#: fewer than half blocked.
SHADOWS_GAIN_MORE = Band(
    0.0, 1.0, "Sec. 7: the effect is much stronger in shadows", claimed=Claim.much_less()
)

#: Variance ratio of the crop of an occluded glossy surface, 10 samples.
OCCLUDED_CROP = Band(
    0.0, 0.5, "Fig. 1: significantly reduced noise in occluded regions", claimed=Claim.much_less()
)

#: The same in quick runs, whose pixels are ten times as wide.
QUICK_OCCLUDED_CROP = Band(
    0.0, 1.0, "Fig. 1: significantly reduced noise in occluded regions", claimed=Claim.much_less()
)

# Figures 8 and 12

#: Rank correlation, over the cells of a grid, of the density of records placed by the difference of
#: maps with 1 - ρ of the surroundings. Chance gives 0 ± 0.05 at 400 cells.
DIFFERENCE_FINDS_LOW_RHO = Band(
    0.15,
    1.0,
    "Fig. 8: finds the regions of low correlation",
    claimed=Claim.words(0.15, 1.0, because="three times what chance gives"),
)

#: The same of records placed by weight, with the mean angle to the normals of the surroundings.
WEIGHT_FINDS_CURVATURE = Band(
    0.15,
    1.0,
    "Fig. 8: more records on surfaces of high curvature",
    claimed=Claim.words(0.15, 1.0, because="three times what chance gives"),
)

#: Records of garden1 over records of dynamics, with equal parameters and maps.
HARD_SCENES_GET_MORE = Band(
    1.0, math.inf, "Sec. 5.4: complex occlusion gets more records", claimed=Claim.more()
)

# Figure 10

#: Rays per shading point, reference over cache.
AO_RAYS = Band(58.0, math.inf, "Fig. 10: 1024 / 17.7 = 57.9", claimed=Claim.at_least(1024 / 17.7))

#: Time, reference over cache.
AO_TIME = Band(60.0, math.inf, "Fig. 10: 2776 s / 44 s = 63", claimed=Claim.at_least(63.0))

#: Root mean squared error of the ambient visibility in [0, 1].
AO_RMSE = Band(
    0.0,
    0.03,
    "Fig. 10: a bit softer, some artefacts; 0.03 is our limit",
    claimed=Claim.words(0.0, 0.03, because="3 % of full visibility"),
)

#: Mean ambient visibility of the reference, so that the error is relative to something.
AO_MEAN = Band(0.2, 0.8, "expected: neither a closed room nor an open plain")

# Figure 11

#: Rays traced after the environment was turned or replaced.
PREVIEW_RAYS = Band(
    0, 0, "Sec. 6.2: the environment map can be replaced and rotated freely", claimed=Claim.exact(0)
)

#: Pearson correlation of displayed luminance, preview with reference.
PREVIEW_LOOKS_ALIKE = Band(
    0.8,
    1.0,
    "Sec. 6.2: good enough to judge shadows and highlights",
    claimed=Claim.words(0.8, 1.0, because="two thirds of the luminance explained (0.8²)"),
)

# Sweep

#: Variance ratio with maps of 64x64 over that with 32x32 at equal thresholds: four times the rays
#: gain less than a factor of two.
LARGER_MAPS = Band(
    0.5, 1.1, "Sec. 7: the extra cost is usually not motivated", claimed=Claim.little_gain()
)

#: Variance ratio with the tightest thresholds over that with the loosest.
MORE_RECORDS_HELP = Band(0.0, 1.0, "expected: records nearer by are better approximations")

# Animation

#: New records in the second frame of a static scene.
NOTHING_NEW = Band(0, 0, "expected: every look-up of the first frame succeeds again")

#: Largest mean variance ratio of ten frames in a row over that of the first ten.
RATIO_STAYS = Band(
    0.0, 1.25, "Sec. 5.3: removal keeps the cache from deteriorating", claimed=Claim.none()
)
