"""Thumbnails of the gallery: one for each figure with a picture, made by the present script."""

import io
import json

import numpy as np
import pytest
from PIL import Image

from codebase.repository import ROOT, module
from viscache_lab import figures

FOLDER = ROOT / "docs" / "gallery" / "thumbnails"
SCRIPT = module("scripts/gallery_thumbnails.py")
#: Difference of two pictures of a figure, as a share of that of another picture: text may move
#: with matplotlib's version, lines may not.
SAME = 0.25
#: Figures without times, a second or so each.
CHEAP = ("aqvc-fig2", "vlf-fig1", "vlf-fig2", "vlf-fig3")


def kept():
    return json.loads((FOLDER / SCRIPT.MANIFEST).read_text("utf-8"))


def stale(made):
    """Figures without an entry, entries without a figure, and entries of an older script."""
    fresh = {n for n in figures.FIGURES if made.get(n, {}).get("recipe") == SCRIPT.recipe(n)}
    return sorted({*figures.FIGURES, *made} - fresh)


def pixels(data):
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), float) / 255


def test_the_thumbnails_are_those_of_the_present_figures():
    assert stale(kept()) == [], "viscache reproduce NAME --quick -o DIR, scripts/gallery_thumbnails"


def test_a_new_figure_and_an_old_script_are_found():
    made = kept()
    assert made.pop("vlf-fig1")
    made["aqvc-fig3"]["recipe"] = "0" * 16
    made["aqvc-fig99"] = {}
    assert stale(made) == ["aqvc-fig3", "aqvc-fig99", "vlf-fig1"]


def test_the_files_are_those_of_the_manifest():
    made = kept()
    files = {p.stem: SCRIPT.digest(p.read_bytes()) for p in FOLDER.glob("*.webp")}
    assert files == {name: e["picture"] for name, e in made.items() if "picture" in e}
    assert len(files) > 30


@pytest.mark.slow
@pytest.mark.parametrize("name", CHEAP)
def test_a_quick_run_gives_the_thumbnail(name, tmp_path):
    figures.reproduce(name, tmp_path, quick=True)
    made = pixels(SCRIPT.thumbnail(tmp_path / f"{name}.png"))
    shown = pixels((FOLDER / f"{name}.webp").read_bytes())
    assert made.shape == shown.shape
    # Nearly white pictures differ little: the same lines upside down say how much another would
    another = np.abs(made - shown[::-1]).mean()
    assert np.abs(made - shown).mean() < SAME * another
