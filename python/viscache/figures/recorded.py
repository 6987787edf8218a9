"""Claims of the papers as full runs found them; docs/limits.md lists those that were not found."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from viscache.figures import aqvc_bands, vlf_bands
from viscache.figures.outcome import Band, Row

__all__ = ["RECORDED", "Recorded", "table"]

#: Pages of the documentation that hold the runs.
AQVC, VLF = "performance/quantized-cache.md", "vlf.md"


@dataclass(frozen=True, kw_only=True, slots=True)
class Recorded:
    """A value of a full run that a page of the documentation holds."""

    figure: str
    what: str
    band: Band
    written: str
    """The value as the page writes it, with " %" for percent."""
    page: str
    section: str
    """Heading on the page, which also names the machine."""

    @property
    def measured(self) -> float:
        """The value as a number."""
        number, percent, _ = self.written.partition(" %")
        return float(number) / (100 if percent else 1)

    @property
    def found(self) -> bool | None:
        """Whether the paper's claim is found."""
        return Row(self.what, self.measured, band=self.band).found


def _claim(what: str, band: Band, written: str, section: str = "Claims") -> Recorded:
    return Recorded(
        figure="aqvc-claims", what=what, band=band, written=written, page=AQVC, section=section
    )


def _hairball(what: str, band: Band, written: str) -> Recorded:
    section = "Figure 6: the hairball"
    return Recorded(
        figure="aqvc-fig6", what=what, band=band, written=written, page=AQVC, section=section
    )


#: The values were copied from the pages, which say on which machine they were measured.
RECORDED = (
    _hairball("no AA, default: speed-up", aqvc_bands.HAIRBALL_SPEEDUP, "1.22"),
    _hairball("AA, default: speed-up", aqvc_bands.HAIRBALL_SPEEDUP, "2.27"),
    _hairball("AA, fast: speed-up", aqvc_bands.HAIRBALL_FAST, "3.91"),
    Recorded(
        figure="aqvc-fig7",
        what="default: largest RR",
        band=aqvc_bands.LARGEST_REDUCTION,
        written="81",
        page=AQVC,
        section="Figure 7",
    ),
    Recorded(
        figure="aqvc-fig7",
        what="default: largest speed-up, in the courtyard",
        band=aqvc_bands.LARGEST_SPEEDUP,
        written="3.70",
        page=AQVC,
        section="Figure 7",
    ),
    Recorded(
        figure="aqvc-fig8",
        what="default: time with maps of 1024² over the cache's",
        band=aqvc_bands.MAPS_SLOWER,
        written="67",
        page=AQVC,
        section="Claims",
    ),
    _claim("H1: queries that become rays, default, C_E 36", aqvc_bands.H1_RAYS_LEFT, "1.24 %"),
    _claim("H1: largest RR at rel_l1 3 % and less", aqvc_bands.H1_REDUCTION, "50.3"),
    _claim(
        "H2: share of the apartment's exact frame that is not visibility",
        aqvc_bands.H2_SHADING_SHARE,
        "9 %",
    ),
    _claim("H4: rays that collisions caused, apartment", aqvc_bands.H4_COLLISIONS, "0.23 %"),
    _claim("H5: speed-up in the Cornell box, paper", aqvc_bands.H5_NO_SPEEDUP, "0.18"),
    _claim(
        "H8: temporal variance of the error, refinement over none, default",
        aqvc_bands.H8_FLICKER,
        "0.54",
    ),
    Recorded(
        figure="vlf-tab1",
        what="speed-up of VLF-RT over CRT, the least of five scenes",
        band=vlf_bands.OCCLUSION_SPEEDUP,
        written="0.67",
        page=VLF,
        section="Findings",
    ),
)


def table(recorded: Iterable[Recorded] = RECORDED) -> str:
    """The claims that were not found, as the Markdown table of docs/limits.md."""
    lines = [
        "| command | the paper | measured | found at | full run here |",
        "| --- | --- | --- | --- | --- |",
    ]
    for one in recorded:
        claim = one.band.claim
        if one.found is not False or claim is None:
            continue
        said = one.band.source.partition("; ")[0]
        anchor = one.section.lower().replace(":", "").replace(" ", "-")
        link = f"[{one.written}]({one.page}#{anchor})"
        lines.append(
            f"| `viscache reproduce {one.figure}` | {said} | {one.what} | {_interval(*claim)} "
            f"| {link} |"
        )
    return "\n".join(lines) + "\n"


def _interval(low: float, high: float) -> str:
    if high == math.inf:
        return f"≥ {low:g}"
    return f"≤ {high:g}" if low == 0 else f"{low:g} to {high:g}"
