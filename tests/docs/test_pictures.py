"""Pictures of the documentation: made by the present recipes, small, and shown with words."""

import io
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from codebase.repository import ROOT, module, paths, sources

IMAGES = ROOT / "docs" / "images"
LARGEST, ALL = 200_000, 3_000_000
#: Mean difference of pictures in [0, 1] made by the same recipe: rounding, and text of another
#: matplotlib. Pages in a browser show times as well.
SAME, SAME_PAGE = 0.02, 0.06
#: All others take more processor time: they are made again before a release alone.
EACH_TIME = {"how-aqvc", "how-correlation", "how-sweep"}
SCRIPT = module("scripts/doc_pictures.py")
SHOWN = re.compile(r"!\[(.*?)\]\((\S+?)\)", re.S)


def stale(folder, recipe=SCRIPT.recipe):
    """Pictures that are missing, changed by hand, or made by another text of the script."""
    made = json.loads((folder / SCRIPT.MANIFEST).read_text("utf-8"))
    fresh = [
        name
        for name in SCRIPT.PICTURES
        if (path := folder / f"{name}.webp").is_file()
        and made.get(name) == {"recipe": recipe(name), "picture": SCRIPT.digest(path.read_bytes())}
    ]
    return sorted({*SCRIPT.PICTURES, *made} - {*fresh})


def difference(one, other):
    """Mean absolute difference of two pictures in [0, 1]; 1 if their sizes differ."""
    a, b = (np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), float) for data in (one, other))
    return float(np.abs(a - b).mean() / 255) if a.shape == b.shape else 1.0


def test_pictures_were_made_by_the_present_script():
    assert stale(IMAGES) == [], "run scripts/doc_pictures.py"


def test_an_old_or_changed_picture_is_found(tmp_path):
    assert stale(IMAGES, lambda _: "0" * 16) == sorted(SCRIPT.PICTURES)
    for path in IMAGES.glob("how-*.webp"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / SCRIPT.MANIFEST).write_text((IMAGES / SCRIPT.MANIFEST).read_text("utf-8"))
    with (tmp_path / "how-vlf.webp").open("ab") as file:
        file.write(b"0")
    assert stale(tmp_path) == ["how-vlf"]


def test_every_picture_is_shown_with_words():
    shown = {
        Path(target).name: words
        for page in sources(".md", under="docs/").values()
        for words, target in SHOWN.findall(page)
    }
    for name in SCRIPT.PICTURES:
        assert len(shown.get(f"{name}.webp", "")) > 40, name


def test_pictures_are_small():
    sizes = {path.name: path.stat().st_size for path in IMAGES.rglob("*.*")}
    assert [name for name in SCRIPT.PICTURES if sizes[f"{name}.webp"] > LARGEST] == []
    every = paths(".webp", ".png", ".svg", under="docs/")
    assert len(every) > 30 and sum((ROOT / path).stat().st_size for path in every) < ALL


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if name in EACH_TIME else pytest.mark.release)
        for name in sorted(SCRIPT.PICTURES)
    ],
)
def test_the_script_makes_the_committed_pictures(name):
    of_browser = name in SCRIPT.OF_BROWSERS
    if of_browser and not any(shutil.which(program) for program in SCRIPT.pages.BROWSERS):
        pytest.skip("chromium is not installed")
    made = SCRIPT.webp(SCRIPT.PICTURES[name]())
    kept = (IMAGES / f"{name}.webp").read_bytes()
    assert difference(made, kept) < (SAME_PAGE if of_browser else SAME)


def test_another_picture_of_the_same_size_is_told_apart():
    kept = (IMAGES / "how-vlf.webp").read_bytes()
    turned = io.BytesIO()
    Image.open(io.BytesIO(kept)).rotate(180).save(turned, "WEBP", quality=75)
    assert difference(kept, kept) == 0
    assert difference(kept, turned.getvalue()) > SAME


def test_another_page_is_told_apart():
    one, other = (IMAGES / name for name in ("how-report.webp", "how-pytest.webp"))
    pages = [Image.open(path).convert("RGB").crop((0, 0, 1100, 700)) for path in (one, other)]
    a, b = io.BytesIO(), io.BytesIO()
    for page, out in zip(pages, (a, b), strict=True):
        page.save(out, "WEBP", quality=75)
    assert difference(a.getvalue(), b.getvalue()) > SAME_PAGE
