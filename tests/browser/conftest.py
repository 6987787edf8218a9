"""Fixtures: a report whose pictures are known, and a browser."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from devtools import CHROMIUM, Browser
from known_report import HEIGHT, WIDTH, Report

from sweeps import stand_in


@pytest.fixture(scope="session")
def page(tmp_path_factory):
    """A report of 3 × 2 settings, moved away from its directory."""
    from viscache import report
    from viscache.sweeps.store import Store
    from viscache.sweeps.sweep import sweep

    with pytest.MonkeyPatch.context() as patch:
        stand_in.install(patch)
        directory = tmp_path_factory.mktemp("sweep")
        over = {"c_e": [4, 8, 16], "c_n": [4, 8]}
        sweep(
            "room",
            "whitted",
            over=over,
            repeats=2,
            size=(WIDTH, HEIGHT),
            directory=directory,
            metrics=["rel_l1"],
        )
    alone = tmp_path_factory.mktemp("alone") / "report.html"
    report.write(directory, alone, flip_maps=5)
    with Store(directory) as store:
        points = [p for p in store.definition()["points"] if p["repeat"] == 0]
        pictures = {
            f"s{2 * p['index'][0] + p['index'][1]}": store.frame(p["key"]).image for p in points
        }
        return Report(alone, directory, pictures, store.frame(points[0]["paired"]).image)


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    if not CHROMIUM:
        pytest.skip("chromium is not installed")
    started = Browser(tmp_path_factory.mktemp("profile"))
    yield started
    started.close()


@pytest.fixture
def tab(browser, page):
    """The browser at its usual size. Every test fails on an error of the page or a request."""
    browser.errors.clear()
    browser.size(1200, 1000)
    yield browser
    assert browser.errors == []
