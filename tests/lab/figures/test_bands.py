"""Bands of all papers are not empty and name their source."""

from __future__ import annotations

import math
from types import ModuleType

import pytest

from lab.figures.every_band import all_bands
from viscache_lab.figures import aqvc_bands, vismap_bands, vlf_bands

SOURCES = ("Eq. ", "Fig. ", "Sec. ", "Tab. ", "expected: ")


@pytest.mark.parametrize(
    ("bands", "some"),
    [
        (aqvc_bands, {"SAMPLES_PER_CELL", "REFINEMENT_GAIN[paper]", "H8_FLICKER"}),
        (vlf_bands, {"OCCLUSION_SPEEDUP", "CHORD_TILES[513]", "UPDATE_PAYS"}),
        (vismap_bands, {"GARAGE_GUIDED[10]", "GARAGE_GUIDED[30]", "LEAST_WEIGHT"}),
    ],
)
def test_bands_are_not_empty_and_name_their_source(bands: ModuleType, some: set[str]) -> None:
    assert some <= set(all_bands(bands))
    for name, band in all_bands(bands).items():
        assert band.low <= band.high, name
        assert math.isfinite(band.low) or math.isfinite(band.high), name
        assert band.source.startswith(SOURCES), name
