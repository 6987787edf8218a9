"""Bands of the papers' figures: a row of a CSV file each, written before any full run.

The papers' scenes are not public, and their times are from other machines. Their numbers are
printed beside ours, and a band says what to expect of stand-ins. Values that are only recorded,
mostly what depends on the scene, have no band. Where today's hardware breaks a band that is the
paper's claim, the row says so, and the band stays. `expected` quotes an earlier prototype or trial
program. Bands of quick runs (`QUICK_…`) hold the order that the paper claims, and were written
after such a run.

A row has the figure, the band's name, the key of those that share a name, both ends, where the
paper's claim is found (a rule of `claim_rules` and its numbers, and the reason of a limit for
words), the source, and what is measured.

aqvc
    *Paper* and *default* are presets of `vc.Aqvc`: the paper's parameters with one look-up per
    query, and level waves. *RR* is queries per ray (the paper's ray reduction is one less). A
    *speed-up* is the CPU seconds of the exact frame, in our fastest order, over those of the cached
    one. Three bands were widened after quick runs, which have small pictures, and before any full
    run: `SCANLINE_HURTS_REFINEMENT` lost its upper end; `REFINED_BIAS` of slits was widened
    downwards, because light that no representative sees is lost; `STALE` was, too, because a small
    ball makes fewer bits stale than shadow edges make wrong. Row A40 of docs/deviations.md lists
    what the first full run changed in the quality choices.
vlf
    *VLF-RT* is `VisibilityField`, *CRT* is `Bsp`, both with the fastest parameters of a grid search
    on the same rays. A *speed-up* of A over B is the time of B over the time of A, on the same
    rays, in CPU seconds on one thread. `RANDOM_STEPS`, `WHITTED_RAYS` and
    `CLOSED_IS_DARKER` were written after a quick run: they hold the order that the paper claims.
vismap
    Figures 3 and 4 are pictures without numbers; their bands turn the paper's sentences into
    numbers. A scene's *slices* are ρ̄ over θ for d < 0.2 units and ρ̄ over d for θ < 2°, with 64 bins
    each. Only bins with n >= 100 pairs count. A *variance ratio* is the mean squared error with the
    cache over that of product sampling, both of linear luminance over all pixels, from independent
    renders at equal samples. *iid* samples are independent, *rqmc* ones a randomised
    (0,2)-sequence. `alpha` is the factor of the control variate; the paper has `one`. The bands of
    the mean ambient occlusion and of equal samples were written after a first quick run. The
    settings of Figure 10 were chosen on its own scene.
trade
    The goals of a trial with a prototype: 512² tiles of 128², 1024 virtual lights that stay the
    same, C_E 10, ten passes with independent eye samples. `viscache bench progressive` missed most
    of its goals since (docs/performance/progressive.md): the passes of viscache share one sequence
    per pixel, which makes exact passes hard to beat. The goals stand here all the same. A *gain* is
    squared error · CPU seconds of the one over that of the other.
"""

from pathlib import Path

from viscache_lab.experiment.rows import read_bands

aqvc, vlf, vismap, trade = (
    read_bands(Path(__file__).with_name(f"{name}.csv"))
    for name in ("aqvc", "vlf", "vismap", "trade")
)
