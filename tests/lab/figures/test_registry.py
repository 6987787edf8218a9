"""`viscache reproduce`: the list, the JSON, and bands that fail with status 1."""

import json
import math
from pathlib import Path

import pytest

from viscache import cli
from viscache_lab import figures
from viscache_lab.experiment import Band, Experiment, Registry, Row
from viscache_lab.experiment.claim_rules import Claim
from viscache_lab.experiment.rows import text

BAND = Band(0.8, math.inf, "the paper says so")


@pytest.fixture
def made_up(monkeypatch):
    """A figure `made-up` whose rows the test fills in."""
    rows = []

    def function(trial):
        (trial.folder / "made-up.png").write_bytes(b"picture")
        trial.rows += rows
        trial.files.append(trial.folder / "made-up.png")
        trial.skip("far away", "absent")

    info = Experiment(description="made up", function=function)
    monkeypatch.setitem(figures.FIGURES, "made-up", info)
    return rows


def test_every_figure_is_listed_in_the_order_of_the_papers(capsys):
    assert cli.main(["reproduce", "list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["figures"]
    assert listed == [{"figure": name} for name in figures.FIGURES]
    names = list(figures.FIGURES)
    assert names[:7] == [f"aqvc-fig{n}" for n in range(2, 9)]
    first = names.index("vlf-fig1")
    assert names[first : first + 9] == [*(f"vlf-fig{n}" for n in range(1, 9)), "vlf-tab1"]
    last = [f"vismap-{n}" for n in ("fig13", "tab2", "tab3", "sweep", "temporal")]
    assert names[-7:] == [*last, "trade", "extremes"]
    assert cli.main(["reproduce", "list"]) == 0
    assert "aqvc-fig6 (fine geometry: the hairball)\n" in capsys.readouterr().out


def test_a_decorated_function_is_an_experiment():
    made = Registry("figure", "lab.figures", ("aqvc", "vlf"))

    @made.add("vlf-x9", "made up", sized=True)
    @made.add("vlf-fig10", "made up")
    @made.add("aqvc-x1", "made up")
    def function(trial):
        pass

    ordered = sorted(made, key=made._place)
    assert ordered == ["aqvc-x1", "vlf-fig10", "vlf-x9"]
    assert made["vlf-x9"] == Experiment(description="made up", function=function, sized=True)
    assert not made["vlf-fig10"].sized
    with pytest.raises(ValueError, match="name must be its own, got 'vlf-x9'"):
        made.add("vlf-x9", "twice")
    with pytest.raises(ValueError, match=r"paper must be one of .*got 'fig1'"):
        made.add("fig1", "of no paper")
    with pytest.raises(ValueError, match="unknown figure 'vlf-x8'; did you mean 'vlf-x9'"):
        made.find("vlf-x8")


def test_the_json_has_the_rows_and_the_files_that_were_written(made_up, tmp_path, capsys):
    made_up.append(Row(what="speed", measured=3.0, printed=2.0, band=BAND, note="here"))
    made_up.append(Row(what="count", measured=7, printed="1 to 2"))
    assert cli.main(["reproduce", "made-up", "-o", str(tmp_path / "new"), "--json"]) == 0
    got = json.loads(capsys.readouterr().out)
    first, second = got["rows"]
    assert got["figure"] == "made-up" and got["skipped"][0]["what"] == "far away"
    known = {"what": "speed", "printed": 2.0, "measured": 3.0, "ratio": 1.5, "band": [0.8, None]}
    known |= {"holds": True, "note": "here; the paper says so"}
    assert first == known | dict.fromkeys(("claim", "rule", "because", "said", "found"))
    assert (second["ratio"], second["band"], second["holds"]) == (None, None, None)
    assert all(Path(file).is_file() for file in got["files"])
    assert {Path(file).suffix for file in got["files"]} == {".png", ".md", ".json"}
    assert json.loads((tmp_path / "new" / "made-up.json").read_text())["rows"] == got["rows"]


def test_a_figure_prints_and_records_two_verdicts(made_up, tmp_path, capsys):
    band = Band(2.0, math.inf, "Sec. 5.2: 8", claimed=Claim.by("at_least", 8.0))
    made_up.append(Row(what="speed", measured=3.0, band=band))
    assert cli.main(["reproduce", "made-up", "-o", str(tmp_path)]) == 0  # a band decides, no claim
    line = "The paper's claim: not found (0 of 1). Our expectation: holds (1 of 1)."
    assert line in capsys.readouterr().out.splitlines()
    got = json.loads((tmp_path / "made-up.json").read_text())
    said = {kind: part["verdict"] for kind, part in got["verdicts"].items()}
    assert said == {"claim": "not found", "expectation": "holds"}
    assert got["rows"][0]["claim"] == [8.0, None] and got["rows"][0]["found"] is False


@pytest.mark.parametrize("measured", [0.79, math.nan, None])
def test_a_band_that_fails_is_status_1(made_up, measured, tmp_path, capsys):
    made_up.append(Row(what="speed", measured=measured, band=BAND))
    assert cli.main(["reproduce", "made-up", "-o", str(tmp_path)]) == 1
    assert "| **no** |" in capsys.readouterr().out


def test_ends_of_a_band_belong_to_it():
    band = Band(1.0, 2.0, "")
    values = [Row(what="x", measured=v, band=band).holds for v in (1.0, 2.0, 0.999, 2.001)]
    assert values == [True, True, False, False]


def test_the_table_says_what_was_printed_and_what_was_measured():
    table = text("made-up", [Row(what="speed", measured=3.0, printed=2.0, band=BAND)])
    assert "| speed | 2 | 3 | 1.5 | 0.8 … ∞ | yes | the paper says so |" in table


def test_unknown_figures_are_refused(tmp_path, capsys):
    out = ["-o", str(tmp_path / "none")]
    assert cli.main(["reproduce", "vismap-fig33", *out]) == 2
    assert "did you mean 'vismap-fig3'" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()


def test_a_size_reaches_the_figures_it_is_for_and_is_refused_by_others(
    tmp_path, monkeypatch, capsys
):
    sizes = []

    def function(trial):
        sizes.append(trial.size)

    info = Experiment(description="made up", function=function, sized=True)
    fixed = Experiment(description="made up", function=lambda trial: None)
    for name in list(figures.FIGURES):
        monkeypatch.delitem(figures.FIGURES, name)
    monkeypatch.setitem(figures.FIGURES, "sized", info)
    monkeypatch.setitem(figures.FIGURES, "fixed", fixed)
    out = ["-o", str(tmp_path), "--json"]
    assert cli.main(["reproduce", "sized", "--size", "64x40", *out]) == 0
    assert json.loads(capsys.readouterr().out)["size"] == [64, 40]
    assert cli.main(["reproduce", "sized", *out]) == 0
    assert cli.main(["reproduce", "all", "--size", "8x4", *out]) == 0
    assert sizes == [(64, 40), None, (8, 4)]
    assert cli.main(["reproduce", "fixed", "--size", "8x4", *out]) == 2
    assert "size must be left out for fixed; it is for sized" in capsys.readouterr().err


@pytest.mark.parametrize(("name", "instead"), figures.FIGURES.gone.items())
def test_a_figure_that_is_no_more_names_what_to_use(name, instead, tmp_path, capsys):
    assert name not in figures.FIGURES
    assert cli.main(["reproduce", name, "-o", str(tmp_path)]) == 2
    assert f"the figure {name!r} is gone: use {instead}" in capsys.readouterr().err
