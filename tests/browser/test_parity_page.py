"""The page of the parity suite in a real browser: folded pictures, sorting and filters."""

import numpy as np
import pytest

from viscache_lab.parity.blocks import block_means, compare
from viscache_lab.parity.judge import Judged
from viscache_lab.parity.page import write_page

pytestmark = pytest.mark.browser


def result(name, verdict, factor, why=""):
    rng = np.random.default_rng(len(name))
    frames = rng.uniform(0.4, 0.6, (2, 6, 64, 64, 3))
    frames[0] *= factor
    blocks = np.stack([[block_means(f, 8) for f in side] for side in frames])
    return Judged(
        name=name,
        verdict=verdict,
        warnings=[why] if verdict == "warned" else [],
        mitsuba=[],
        why=why,
        compared=compare(blocks[0], blocks[1]),
        ours=frames[0].mean(0),
        theirs=frames[1].mean(0),
        pictures=6,
    )


@pytest.fixture
def opened(tab, tmp_path):
    results = [
        result("shape/cube", "agrees", 1.0),
        result("light/spot", "differs", 1.3, "energy +30.0%"),
        result("material/bump", "warned", 1.1, "x.xml:3: 'bumpmap' is not modelled"),
        Judged(name="shape/odd", verdict="not loaded", warnings=["no"], mitsuba=[], why="no"),
    ]
    write_page(tmp_path / "index.html", results, {"scenes": "4"})
    tab.open(tmp_path / "index.html")
    return tab


NAMES = "[...document.querySelectorAll('tbody:not([hidden])')].map(b => b.dataset.name)"


def test_misses_come_first_and_pictures_appear_when_a_row_opens(opened):
    names = opened.eval(NAMES)
    assert names == ["light/spot", "shape/odd", "material/bump", "shape/cube"]
    assert opened.eval("document.images.length") == 0
    opened.eval("document.querySelector('tbody[data-name=\"light/spot\"] tr').click()")
    assert opened.eval("document.images.length") == 4
    opened.wait_for("[...document.images].every(i => i.complete && i.naturalWidth > 0)")
    # Ours is brighter: the z of blocks are dark red, 256 pixels wide
    shot = opened.screenshot().astype(int)
    assert (shot[..., 0] - shot[..., 2] > 60).sum() > 20_000
    assert opened.errors == []


def test_headings_sort_and_filters_hide(opened):
    opened.eval("document.querySelectorAll('thead button')[4].click()")
    assert opened.eval(NAMES)[:2] == ["light/spot", "material/bump"]
    opened.eval("document.querySelectorAll('thead button')[4].click()")
    assert opened.eval(NAMES)[-2:] == ["material/bump", "light/spot"]
    opened.eval("document.querySelector('[data-verdict=agrees].tool').click()")
    assert "shape/cube" not in opened.eval(NAMES)
    assert opened.text("shown") == "3 of 4 scenes"
    find = "const f = document.getElementById('find'); f.value = 'bumpmap';"
    opened.eval(find + " f.dispatchEvent(new Event('input'))")
    assert opened.eval(NAMES) == ["material/bump"]
    assert opened.errors == []
