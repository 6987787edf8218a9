"""Full runs of the quantized cache's figures, most of them copied from the page that holds them."""

from __future__ import annotations

from viscache.figures import aqvc_bands
from viscache.figures.outcome import Band
from viscache.figures.recorded_value import Missing, Recorded, Run

PAGE = "performance/quantized-cache.md"
#: The day on which the values entered the page.
DATE = "2026-11-22"
RUNS = (
    Run(figure="aqvc-fig2", date="2026-11-25", machine="C", frame="640×400, a plane and the room"),
    Run(figure="aqvc-fig3", date=DATE, machine="C", frame="stairs in the sun, C_E 16"),
    Run(
        figure="aqvc-fig4", date="2026-11-25", machine="C", frame="640×400, cube on a plane, C_E 16"
    ),
    Run(figure="aqvc-fig5", date=DATE, machine="C", frame="640×400, 1 to 16 samples per pixel"),
    Run(figure="aqvc-fig6", date=DATE, machine="C", frame="512×512, one and 9 samples per pixel"),
    Run(figure="aqvc-fig7", date=DATE, machine="C", frame="640×400, hairball 512×512"),
    Run(figure="aqvc-fig8", date=DATE, machine="C", frame="640×400, maps of 1024²"),
    Run(figure="aqvc-claims", date=DATE, machine="C", frame="640×400, 16 samples per pixel"),
)


def _claim(what: str, band: Band, written: str, section: str = "Claims") -> Recorded:
    return Recorded(
        figure="aqvc-claims", what=what, band=band, written=written, page=PAGE, section=section
    )


def _run(figure: str, what: str, band: Band, written: str) -> Recorded:
    return Recorded(figure=figure, what=what, band=band, written=written)


def _hairball(what: str, band: Band, written: str) -> Recorded:
    section = "Figure 6: the hairball"
    return Recorded(
        figure="aqvc-fig6", what=what, band=band, written=written, page=PAGE, section=section
    )


def _missing(figure: str, band: Band, reason: str) -> Missing:
    return Missing(figure=figure, band=band, reason=reason)


RECORDED = (
    _run(
        "aqvc-fig2",
        "eye samples per cell of a plane over C_E²",
        aqvc_bands.SAMPLES_PER_CELL,
        "0.861",
    ),
    _run(
        "aqvc-fig2",
        "samples per cell, the far half over the near half",
        aqvc_bands.CELLS_FOLLOW_FOOTPRINT,
        "0.95",
    ),
    _run(
        "aqvc-fig2",
        "samples 0.1 cells apart that share a cell",
        aqvc_bands.NEIGHBOURS_SHARE,
        "0.869",
    ),
    _run("aqvc-fig2", "cells of a room that mix orientations", aqvc_bands.MIXED_NORMALS, "0"),
    Recorded(
        figure="aqvc-fig3",
        what="stairs, default: rel_l1 without refinement over that with it",
        band=aqvc_bands.REFINEMENT_GAIN["default"],
        written="2.0",
        page=PAGE,
        section="Claims",
    ),
    Recorded(
        figure="aqvc-fig3",
        what="stairs, paper: rel_l1 without refinement over that with it",
        band=aqvc_bands.REFINEMENT_GAIN["paper"],
        written="2.3",
        page=PAGE,
        section="Claims",
    ),
    _run("aqvc-fig4", "scanline: shift to the right", aqvc_bands.SCANLINE_SHIFT, "0.254"),
    _run("aqvc-fig4", "scanline: shift down", aqvc_bands.SCANLINE_SHIFT, "1.13"),
    _run(
        "aqvc-fig4",
        "hm: length of the shift over that of scanline",
        aqvc_bands.ORDER_CURES,
        "0.132",
    ),
    _run(
        "aqvc-fig4",
        "random: length of the shift over that of scanline",
        aqvc_bands.ORDER_CURES,
        "0.117",
    ),
    _run(
        "aqvc-fig4",
        "with refinement, rel_l1 of scanline over that of hm",
        aqvc_bands.SCANLINE_HURTS_REFINEMENT,
        "4.09",
    ),
    Recorded(
        figure="aqvc-fig5",
        what="bidirectional paths, C_E 12, default: RR",
        band=aqvc_bands.BIDIRECTIONAL_RR,
        written="7.6",
        page=PAGE,
        section="Figure 5",
    ),
    Recorded(
        figure="aqvc-fig5",
        what="bidirectional paths, C_E 12, preset paper: RR",
        band=aqvc_bands.BIDIRECTIONAL_RR,
        written="4.9",
        page=PAGE,
        section="Figure 5",
    ),
    Recorded(
        figure="aqvc-fig5",
        what="courtyard, preset paper: rel_l1, the largest of five",
        band=aqvc_bands.PICTURE_ERROR,
        written=".034",
        page=PAGE,
        section="Figure 5",
    ),
    _hairball("no AA, paper: RR", aqvc_bands.HAIRBALL_RR, "1.5"),
    _hairball("AA, paper: RR", aqvc_bands.HAIRBALL_RR, "3.0"),
    _hairball("no AA, default: speed-up", aqvc_bands.HAIRBALL_SPEEDUP, "1.22"),
    _hairball("AA, default: speed-up", aqvc_bands.HAIRBALL_SPEEDUP, "2.27"),
    _hairball("AA, fast: speed-up", aqvc_bands.HAIRBALL_FAST, "3.91"),
    Recorded(
        figure="aqvc-fig7",
        what="default: largest RR",
        band=aqvc_bands.LARGEST_REDUCTION,
        written="81",
        page=PAGE,
        section="Figure 7",
    ),
    Recorded(
        figure="aqvc-fig7",
        what="default: largest speed-up, in the courtyard",
        band=aqvc_bands.LARGEST_SPEEDUP,
        written="3.70",
        page=PAGE,
        section="Figure 7",
    ),
    Recorded(
        figure="aqvc-fig8",
        what="default: time with maps of 1024² over the cache's",
        band=aqvc_bands.MAPS_SLOWER,
        written="67",
        page=PAGE,
        section="Claims",
    ),
    Recorded(
        figure="aqvc-fig8",
        what="close-up, default: rel_l1 at equal time, map over cache",
        band=aqvc_bands.MAPS_WORSE_CLOSE_UP,
        written="8.4",
        page=PAGE,
        section="Claims",
    ),
    _claim("H1: queries that become rays, default, C_E 36", aqvc_bands.H1_RAYS_LEFT, "1.24 %"),
    _claim("H1: largest RR at rel_l1 3 % and less", aqvc_bands.H1_REDUCTION, "50.3"),
    _claim(
        "H2: share of the apartment's exact frame that is not visibility",
        aqvc_bands.H2_SHADING_SHARE,
        "9 %",
    ),
    _claim("H3: rays, 4 MiB of table a thread over 16 MiB", aqvc_bands.H3_LARGE_TABLES, "1.002"),
    _claim("H4: rays that collisions caused, apartment", aqvc_bands.H4_COLLISIONS, "0.23 %"),
    _claim("H5: speed-up in the Cornell box, paper", aqvc_bands.H5_NO_SPEEDUP, "0.18"),
    _claim(
        "H8: temporal variance of the error, refinement over none, default",
        aqvc_bands.H8_FLICKER,
        "0.54",
    ),
)

#: The page names no single value for these.
MISSING = (
    _missing("aqvc-fig7", aqvc_bands.REDUCTION_RISES, "80 minutes; the page has its ranges"),
    _missing("aqvc-fig7", aqvc_bands.ERROR_RISES, "80 minutes; the page has its ranges"),
    _missing("aqvc-fig7", aqvc_bands.CONFERENCE_GAINS_LESS, "80 minutes; the page has its ranges"),
    _missing("aqvc-claims", aqvc_bands.H2_WITHIN_BOUND, "no value on the page"),
    _missing("aqvc-quality", aqvc_bands.REFINED_ERROR, "no value on the page"),
    _missing("aqvc-quality", aqvc_bands.LEAKING_CELLS["round"], "no value on the page"),
    _missing("aqvc-quality", aqvc_bands.LEAKING_CELLS["floor"], "no value on the page"),
    _missing("aqvc-quality", aqvc_bands.LEAKING_CELLS["octahedral"], "no value on the page"),
    _missing("aqvc-quality", aqvc_bands.PLAIN_BIAS, "no value on the page"),
)
