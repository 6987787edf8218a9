"""Full runs of the visibility-map paper's figures, rows as the figures name them."""

from __future__ import annotations

from viscache.figures import vismap_bands as bands
from viscache.figures.outcome import Band
from viscache.figures.recorded_value import Missing, Recorded, Run


def _run(figure: str, frame: str) -> Run:
    return Run(figure=figure, date="2026-11-25", machine="C", frame=frame)


def _of(figure: str, what: str, band: Band, written: str) -> Recorded:
    return Recorded(figure=figure, what=what, band=band, written=written)


#: Other work ran on the machine.
RUNS = (
    _run("vismap-fig3", "195,000 points of garden1, 96×96 directions"),
    _run("vismap-fig5", "no frame"),
    _run("vismap-fig8", "800×600, mushrooms"),
    _run("vismap-fig11", "640×480"),
    _run("vismap-fig12", "800×600"),
    _run("vismap-tab2", "1600×1200"),
    _run("vismap-sweep", "640×480, simulated pixels, 30 samples"),
)

RECORDED = (
    _of(
        "vismap-fig3",
        "garden1: mean rho of pairs with d < 0.2, theta < 2 deg",
        bands.CORNER,
        "0.865",
    ),
    _of(
        "vismap-fig3",
        "garden1: share of bins with theta < 90 deg whose mean rho is negative",
        bands.NEGATIVE_SHARE,
        "0",
    ),
    _of(
        "vismap-fig3",
        "garden1: R^2 of a line through the slice over theta, 0 to 120 deg",
        bands.LINEAR_IN_THETA,
        "0.990",
    ),
    _of(
        "vismap-fig3",
        "garden1: share of the fall over d done by the middle",
        bands.CONVEX_IN_D,
        "1.14",
    ),
    _of("vismap-fig3", "garden1: pair estimates", bands.ESTIMATES, "1.901e10"),
    _of("vismap-fig5", "least weight, at d_max and 30 deg", bands.LEAST_WEIGHT, "0.694444"),
    _of("vismap-fig5", "weight at d_max and 0 deg", bands.EDGE_WEIGHT, "0.833333"),
    _of("vismap-fig5", "weight at 0 and 30 deg", bands.EDGE_WEIGHT, "0.833333"),
    _of("vismap-fig5", "first slope over d / d_max", bands.FIRST_SLOPE, "-0.995"),
    _of(
        "vismap-fig8",
        "rank correlation of the density by weight with mean angle of normals",
        bands.WEIGHT_FINDS_CURVATURE,
        "0.85",
    ),
    _of(
        "vismap-fig8",
        "rank correlation of the density by difference with 1 - rho",
        bands.DIFFERENCE_FINDS_LOW_RHO,
        "0.485",
    ),
    _of("vismap-fig11", "rays traced for lights that are turned", bands.PREVIEW_RAYS, "0"),
    _of(
        "vismap-fig11",
        "correlation of displayed luminance, preview with reference",
        bands.PREVIEW_LOOKS_ALIKE,
        "0.973",
    ),
    _of(
        "vismap-fig12",
        "records of garden1 over records of dynamics, same parameters",
        bands.HARD_SCENES_GET_MORE,
        "26.1",
    ),
    _of("vismap-tab2", "garage: rays over records · 4^M / 2", bands.RAYS_OF_RECORDS, "1"),
    _of("vismap-tab2", "garage: bytes of a record", bands.RECORD_BYTES, "172"),
    _of("vismap-tab2", "dynamics: rays over records · 4^M / 2", bands.RAYS_OF_RECORDS, "1"),
    _of("vismap-tab2", "garden1: rays over records · 4^M / 2", bands.RAYS_OF_RECORDS, "1"),
    _of("vismap-tab2", "garden1: bytes of a record", bands.RECORD_BYTES, "172"),
    _of("vismap-tab2", "garden2: rays over records · 4^M / 2", bands.RAYS_OF_RECORDS, "1"),
    _of("vismap-tab2", "garden2: bytes of a record", bands.RECORD_BYTES, "172"),
    _of(
        "vismap-sweep",
        "variance left with 64x64 cells over that with 32x32",
        bands.LARGER_MAPS,
        "0.77",
    ),
)

MISSING = (
    Missing(
        figure="vismap-fig1",
        band=bands.OCCLUDED_CROP,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-fig4",
        band=bands.LINES,
        reason="stopped after 11 minutes beside other work",
    ),
    Missing(
        figure="vismap-fig4",
        band=bands.ORDER,
        reason="stopped after 11 minutes beside other work",
    ),
    Missing(
        figure="vismap-fig10",
        band=bands.AO_RAYS,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-fig10",
        band=bands.AO_TIME,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-fig10",
        band=bands.AO_RMSE,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-fig13",
        band=bands.EQUAL_TIME,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-fig13",
        band=bands.EQUAL_SAMPLES,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-fig13",
        band=bands.SHADOWS_GAIN_MORE,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-tab3",
        band=bands.GARAGE_CONTROL_VARIATE,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-tab3",
        band=bands.GARDEN_PREVIOUS_PASS,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-tab3",
        band=bands.GARDEN_ONE,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-tab3",
        band=bands.IID_IS_FLAT,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-tab3",
        band=bands.RQMC_RISES,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-tab3",
        band=bands.OVERHEAD_IS_CONSTANT,
        reason="not run again since the rules were written",
    ),
    Missing(
        figure="vismap-temporal",
        band=bands.RATIO_STAYS,
        reason="not run again since the rules were written",
    ),
)
