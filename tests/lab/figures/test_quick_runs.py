"""Quick runs of all figures and tables: all rows are measured, bands hold, files exist."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from viscache import cli
from viscache_lab import figures
from viscache_lab.experiment.run import finished

#: Rows with a band, and files beside table and record by what follows the figure's name.
QUICK: dict[str, tuple[int, tuple[str, ...]]] = {
    "aqvc-fig2": (8, (".png",)),
    "aqvc-fig3": (4, (".png",)),
    "aqvc-fig4": (7, (".png", ".csv")),
    "aqvc-fig5": (
        12,
        (
            "-courtyard.png",
            "-conference.png",
            "-apartment.png",
            "-delta.png",
            "-bidirectional.png",
        ),
    ),
    "aqvc-fig6": (2, (".png", "-aa.png")),
    "aqvc-fig7": (40, (".png", ".csv")),
    "aqvc-fig8": (2, (".png", "-trade.png", ".csv")),
    "aqvc-claims": (12, (".png", ".csv")),
    "aqvc-quality": (5, (".csv", "-bias.csv")),
    "aqvc-correct": (9, (".png", ".csv")),
    "aqvc-nee": (15, (".png", ".csv")),
    "aqvc-temporal": (14, (".png", ".csv")),
    "vlf-fig1": (3, (".png",)),
    "vlf-fig2": (4, (".png",)),
    "vlf-fig3": (2, (".png",)),
    "vlf-fig4": (2, (".png",)),
    "vlf-fig5": (1, (".png", ".csv")),
    "vlf-fig6": (1, (".png", ".csv")),
    "vlf-fig7": (2, (".png",)),
    "vlf-fig8": (3, (".png",)),
    "vlf-tab1": (6, (".csv",)),
    "vlf-x1": (2, (".png", ".csv")),
    "vlf-x2": (3, (".png", "-bands.png", ".csv")),
    "vlf-x3": (3, (".png", ".csv")),
    "vlf-x4": (1, (".png", ".csv")),
    "vlf-x5": (3, (".png", ".csv")),
    "vismap-fig1": (1, (".png",)),
    "vismap-fig3": (5, ("-table.png", "-slices.png")),
    "vismap-fig4": (12, (".png",)),
    "vismap-fig5": (4, (".png",)),
    "vismap-fig8": (2, (".png",)),
    "vismap-fig10": (1, (".png",)),
    "vismap-fig12": (1, ("-garden1.png", "-dynamics.png")),
    "vismap-tab2": (7, ()),
    "vismap-fig11": (2, (".png",)),
    "vismap-fig13": (1, (".png",)),
    "vismap-tab3": (1, ()),
    "vismap-sweep": (2, (".png",)),
    "vismap-temporal": (2, (".png",)),
    "trade": (5, (".png", ".csv")),
    "extremes": (66, (".png", ".csv")),
}
#: Rows that need scenes by other authors.
SKIPPED = {
    "vismap-fig4": ["living-room", "sanmiguel-part"],
    "vismap-tab2": ["living-room, noon", "living-room, sunset"],
    "vismap-tab3": ["living-room, noon", "living-room, sunset"],
}


#: Ways in which a row may have the wrong sense.
INVERSIONS: dict[str, Callable[[float], float]] = {
    "sign": lambda measured: -measured,
    "ratio": lambda measured: 1 / measured if measured else math.inf,
}
#: Ratios of two counts that should be equal: their inverse is hardly another number.
OF_EQUALS = {"vlf-x3"}


def test_every_figure_has_a_quick_run_with_a_band() -> None:
    assert set(QUICK) == set(figures.FIGURES)
    assert [name for name, (n_banded, _) in QUICK.items() if n_banded == 0] == []


def broken(rows: list[dict[str, Any]], how: str) -> list[str]:
    """Rows whose band notices that the measured value has the wrong sense."""
    wrong = []
    for row in rows:
        if row["band"] is None:
            continue
        low, high = (end if end is not None else math.inf for end in row["band"])
        if not low <= INVERSIONS[how](row["measured"]) <= high:
            wrong.append(row["what"])
    return wrong


def test_a_band_that_holds_any_sense_notices_no_wrong_one() -> None:
    wide = {"what": "x", "measured": 2.0, "band": [-9.0, 9.0]}
    tight = wide | {"band": [1.0, None]}
    assert [broken([wide], how) for how in INVERSIONS] == [[], []]
    assert [broken([tight], how) for how in INVERSIONS] == [["x"], ["x"]]
    assert broken([wide | {"band": None}], "sign") == []


def quick_result(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> dict[str, Any]:
    """The figure's result: one that this code left in VISCACHE_QUICK_FIGURES, or a run."""
    known = os.environ.get("VISCACHE_QUICK_FIGURES")
    result = finished(Path(known), name, quick=True, size=None) if known else None
    if result:
        return result
    monkeypatch.setenv("VISCACHE_SCENES", str(folder / "none"))
    status = cli.main(["reproduce", name, "-o", str(folder), "--quick", "--json"])
    made: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert status == (0 if made["holds"] else 1)
    return made


@pytest.mark.figure
@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_a_quick_run_measures_every_row_holds_and_draws(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    got = quick_result(name, tmp_path, monkeypatch, capsys)
    assert [row for row in got["rows"] if row["holds"] is False] == []
    assert got["holds"]

    n_banded, endings = QUICK[name]
    assert sum(row["band"] is not None for row in got["rows"]) == n_banded
    assert all(row["measured"] is not None for row in got["rows"])
    assert [left["what"] for left in got["skipped"]] == SKIPPED.get(name, [])

    for how in INVERSIONS:
        assert broken(got["rows"], how) or (how == "ratio" and name in OF_EQUALS), how

    files = {name + ending for ending in (*endings, ".md", ".json")}
    assert {Path(file).name for file in got["files"]} == files
    for file in map(Path, got["files"]):
        assert file.stat().st_size > 0
        if file.suffix == ".png":
            assert file.read_bytes()[:4] == b"\x89PNG"
