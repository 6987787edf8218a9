"""The report in a real browser: Debian's chromium, headless, straight from disk."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "python"))
import fake_renderer as fake

CHROMIUM = next(
    (c for c in ("chromium", "chromium-browser", "google-chrome") if shutil.which(c)), ""
)

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(not CHROMIUM, reason="chromium is not installed"),
]


def chromium(profile: Path, page: Path, fragment: str, *options: str) -> str:
    """Standard output of a headless run on a page, with what it complained about in the console."""
    command = [
        CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
        "--window-size=1200,1600", "--virtual-time-budget=3000", f"--user-data-dir={profile}",
        "--host-resolver-rules=MAP * ~NOTFOUND", "--disable-background-networking",
        "--run-all-compositor-stages-before-draw",
        "--no-first-run", "--disable-sync", *options, f"{page.as_uri()}#{fragment}",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=True)
    return done.stdout


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report of 3 × 2 settings, moved away from its directory."""
    import viscache
    from viscache import report, sources, sweep_work
    from viscache.sweep import sweep

    with pytest.MonkeyPatch.context() as patch:
        for name in ("Whitted", "Embree", "Exact", "Aqvc"):
            patch.setattr(viscache, name, getattr(fake, name), raising=False)
        patch.setattr(sweep_work, "render_function", fake.fake_render)
        patch.setattr(sources, "open_scene", lambda spec, **_: fake.FakeScene(name=spec))
        directory = tmp_path_factory.mktemp("sweep")
        over: dict[str, Any] = {"c_e": [4, 8, 16], "c_n": [4, 8]}
        sweep("room", "whitted", over=over, repeats=2, size=(64, 48), directory=directory,
              metrics=["rel_l1"])  # fmt: skip
    alone = tmp_path_factory.mktemp("alone") / "report.html"
    return report.write(directory, alone)


def picture(tmp_path: Path, page: Path, fragment: str) -> np.ndarray:
    from PIL import Image

    shot = tmp_path / f"{re.sub('[^a-z0-9]', '', fragment)}.png"
    chromium(tmp_path / "profile", page, fragment, f"--screenshot={shot}")
    with Image.open(shot) as image:
        # Down to the pictures; below, a busy machine may leave tiles of the page unpainted.
        return np.asarray(image.convert("RGB"), dtype=int)[:1250]


def test_every_setting_is_a_point_in_both_plots_and_the_chosen_one_is_marked(
    tmp_path: Path, page: Path
) -> None:
    dom = chromium(tmp_path / "profile", page, "select=s3", "--dump-dom")
    circles = re.findall(r'<path class="(point[^"]*)" data-id="(s\d)"', dom)
    assert len(circles) == 2 * 6
    assert {i for classes, i in circles if "selected" in classes} == {"s3"}
    rows = re.findall(r'<tr data-id="(s\d)"[^>]*class="selected"', dom)
    assert rows == ["s3"]
    assert re.search(r'id="chosen"[^>]*>C_E = 8, C_N = 8, seed 0<', dom)


def test_the_slider_changes_pixels_only_where_it_moved(tmp_path: Path, page: Path) -> None:
    less = picture(tmp_path, page, "select=s4&wipe=0.25")
    more = picture(tmp_path, page, "select=s4&wipe=0.75")
    changed = np.abs(less - more).max(axis=2) > 2
    columns = np.nonzero(changed)[1]
    assert changed.sum() > 5000
    # The stage is the left half of the page: the wipe from 25 to 75 % of it moves.
    assert columns.min() > 100 and columns.max() < 560
    assert np.array_equal(less, picture(tmp_path, page, "select=s4&wipe=0.25"))


def test_the_flip_shows_the_reference_alone(tmp_path: Path, page: Path) -> None:
    flipped = picture(tmp_path, page, "select=s4&wipe=1&flip=1")
    whole = picture(tmp_path, page, "select=s4&wipe=1")
    nothing = picture(tmp_path, page, "select=s4&wipe=0")
    assert (np.abs(flipped - whole).max(axis=2) > 2).sum() > 5000
    stage = np.s_[700:900, 60:500]  # away from the buttons
    assert np.array_equal(flipped[stage], nothing[stage])


def test_choosing_another_setting_changes_its_pictures(tmp_path: Path, page: Path) -> None:
    one, other = (picture(tmp_path, page, f"select={s}&wipe=1") for s in ("s0", "s4"))
    assert (np.abs(one - other).max(axis=2) > 2).sum() > 5000


def test_the_script_runs_without_an_error(tmp_path: Path, page: Path) -> None:
    """A page whose last statement ran has shown the setting; the fragment it wrote tells so."""
    broken = tmp_path / "broken.html"
    last = "readFragment(); show();\n</script>"
    text = page.read_text("utf-8")
    assert text.count(last) == 1
    broken.write_text(text.replace(last, "undefined_name();\n</script>"), "utf-8")
    assert 'id="gain">16<' in chromium(tmp_path / "p", page, "", "--dump-dom")
    assert 'id="gain">16<' not in chromium(tmp_path / "p", broken, "", "--dump-dom")
