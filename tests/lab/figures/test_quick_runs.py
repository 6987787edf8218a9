"""Quick runs of all figures and tables: all rows are measured, bands hold, files exist."""

import json
import math
import os
import re
from pathlib import Path

import pytest

from viscache import cli
from viscache_lab import figures
from viscache_lab.experiment.run import finished

#: Of each figure: rows with a band, tables, and what the axes of each picture show (title, label of
#: x and y, names of series, number of images), numbers in titles left out.
QUICK = json.loads(Path(__file__).with_name("quick_runs.json").read_text("utf-8"))
#: Rows that need scenes by other authors.
SKIPPED = {
    "vismap-fig4": ["living-room", "sanmiguel-part"],
    "vismap-tab2": ["living-room, noon", "living-room, sunset"],
    "vismap-tab3": ["living-room, noon", "living-room, sunset"],
}


#: Ways in which a row may have the wrong sense.
INVERSIONS = {
    "sign": lambda measured: -measured,
    "ratio": lambda measured: 1 / measured if measured else math.inf,
}


def test_every_figure_has_a_quick_run_with_a_band():
    assert set(QUICK) == set(figures.FIGURES)
    assert [name for name, quick in QUICK.items() if quick["banded"] == 0] == []


def broken(rows, how):
    """Rows whose band notices that the measured value has the wrong sense."""
    wrong = []
    for row in rows:
        if row["band"] is None:
            continue
        low, high = (end if end is not None else math.inf for end in row["band"])
        if not low <= INVERSIONS[how](row["measured"]) <= high:
            wrong.append(row["what"])
    return wrong


def test_a_band_that_holds_any_sense_notices_no_wrong_one():
    wide = {"what": "x", "measured": 2.0, "band": [-9.0, 9.0]}
    tight = wide | {"band": [1.0, None]}
    assert [broken([wide], how) for how in INVERSIONS] == [[], []]
    assert [broken([tight], how) for how in INVERSIONS] == [["x"], ["x"]]
    assert broken([wide | {"band": None}], "sign") == []


def quick_result(name, folder, monkeypatch, capsys):
    """The figure's result: one that this code left in VISCACHE_QUICK_FIGURES, or a run."""
    known = os.environ.get("VISCACHE_QUICK_FIGURES")
    result = finished(Path(known), name, quick=True, size=None) if known else None
    if result:
        return result
    monkeypatch.setenv("VISCACHE_SCENES", str(folder / "none"))
    status = cli.main(["reproduce", name, "-o", str(folder), "--quick", "--json"])
    made = json.loads(capsys.readouterr().out)
    assert status == (0 if made["holds"] else 1)
    return made


@pytest.mark.figure
@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_a_quick_run_measures_every_row_holds_and_draws(name, tmp_path, monkeypatch, capsys):
    got = quick_result(name, tmp_path, monkeypatch, capsys)
    assert [row for row in got["rows"] if row["holds"] is False] == []
    assert got["holds"]

    expected = dict(QUICK[name])
    assert sum(row["band"] is not None for row in got["rows"]) == expected.pop("banded")
    assert all(row["measured"] is not None for row in got["rows"])
    assert [left["what"] for left in got["skipped"]] == SKIPPED.get(name, [])

    for how in INVERSIONS:
        assert broken(got["rows"], how), how

    files = [*expected.pop("tables"), *expected, f"{name}.md", f"{name}.json"]
    assert sorted(Path(file).name for file in got["files"]) == sorted(files)
    assert all(Path(file).stat().st_size > 0 for file in got["files"])
    assert {file: [shown(one) for one in axes] for file, axes in got["drawn"].items()} == expected


def shown(axes):
    """What axes show, without the numbers of the title."""
    title = re.sub(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?", "#", axes["title"])
    return [title, axes["x"], axes["y"], axes["series"], axes["images"]]
