"""Bands of all papers are not empty and name their source."""

import math
import re
from pathlib import Path

from lab.figures.every_band import EVERY
from viscache_lab import figures
from viscache_lab.figures.bands import aqvc, trade, vismap, vlf

SOURCES = ("Eq. ", "Fig. ", "Sec. ", "Tab. ", "expected: ")


def test_bands_are_not_empty_and_name_their_source():
    assert {"aqvc.REFINEMENT_GAIN[paper]", "vlf.CHORD_TILES[513]", "vismap.LEAST_WEIGHT"} <= set(
        EVERY
    )
    for name, band in EVERY.items():
        assert band.low <= band.high, name
        assert math.isfinite(band.low) or math.isfinite(band.high), name
        assert band.source.startswith(SOURCES), name


def test_figures_use_every_band():
    """Names are looked up when a figure runs: one that is misspelt is noticed here."""
    used = set()
    for path in Path(figures.__file__).parent.glob("*.py"):
        source = path.read_text("utf-8")
        for paper in re.findall(r"figures.bands import (\w+) as bands", source):
            used |= {(paper, name) for name in re.findall(r"\bbands\.([A-Z]\w+)", source)}
    tables = {"aqvc": aqvc, "vlf": vlf, "vismap": vismap, "trade": trade}
    assert used == {(paper, name) for paper, bands in tables.items() for name in vars(bands)}
