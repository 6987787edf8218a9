"""Bands of all papers are not empty and name their source."""

import math
import re
from pathlib import Path

from viscache_lab import figures
from viscache_lab.experiment import Band
from viscache_lab.figures.bands import aqvc, trade, vismap, vlf

TABLES = {"aqvc": aqvc, "vlf": vlf, "vismap": vismap, "trade": trade}
#: Bands of all figures by table, name and, in a table of a band for each case, key.
EVERY = {
    f"{table}.{name}" + f"[{key}]" * (key is not None): band
    for table, bands in TABLES.items()
    for name, value in vars(bands).items()
    for key, band in ({None: value} if isinstance(value, Band) else value).items()
}
SOURCES = ("Eq. ", "Fig. ", "Sec. ", "Tab. ", "expected: ")


def test_bands_are_not_empty_and_name_their_source():
    some = {"aqvc.REFINEMENT_GAIN[paper]", "vlf.CHORD_TILES[513]", "vismap.LEAST_WEIGHT"}
    assert some | {"trade.GAIN[room]", "trade.NEVER_WORSE", "trade.UNBIASED"} <= set(EVERY)
    for name, band in EVERY.items():
        assert band.low <= band.high, name
        assert math.isfinite(band.low) or math.isfinite(band.high), name
        assert band.source.startswith(SOURCES), name
        # No paper prints what our own trade should be
        if name.startswith("trade."):
            assert math.isfinite(band.low) and band.source.startswith("expected: "), name


def test_figures_use_every_band():
    """Names are looked up when a figure runs: one that is misspelt is noticed here."""
    used = set()
    for path in Path(figures.__file__).parent.glob("*.py"):
        source = path.read_text("utf-8")
        for paper in re.findall(r"figures.bands import (\w+) as bands", source):
            used |= {(paper, name) for name in re.findall(r"\bbands\.([A-Z]\w+)", source)}
    assert used == {(paper, name) for paper, bands in TABLES.items() for name in vars(bands)}
