"""Tables as CSV: numbers are numbers, and text is never a formula to a spreadsheet."""

import csv
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viscache.sweeps.csv_file import append_csv, write_csv
from viscache.sweeps.store import Store
from viscache.sweeps.sweep import sweep

FORMULAS = [
    "=1+1",
    "+1",
    "-1",
    "@SUM(1)",
    "-",
    "\t=1",
    "\r=1",
    "\n=1",
    " =1",
    "\uff1d1",
    '=a,"b"\n=2',
]
PLAIN = ["waves", "a=1", "c-d", "1", "", "'", "'=1", "''", "α"]


def cells(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


@pytest.mark.parametrize("text", FORMULAS)
def test_no_cell_begins_a_formula(text, tmp_path):
    path = tmp_path / "table.csv"
    write_csv(path, [{text: text, "other": 1}], [text, "other"])
    append_csv(path, {text: text}, [text, "other"])
    assert [row[0] for row in cells(path)] == 3 * ["'" + text]


@given(st.one_of(st.sampled_from(FORMULAS + PLAIN), st.text(st.characters(codec="utf-8"))))
def test_a_text_comes_back(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("csv") / "table.csv"
    write_csv(path, [{"a": text, "b": 0}], ["a", "b"])
    assert cells(path)[1][0].removeprefix("'") == text


@pytest.mark.parametrize(
    "number",
    [-1, -0.5, 1e-300, -1e300, True, math.inf, np.float64(-2.5), np.int64(-3), -np.float32(0.1)],
)
def test_numbers_are_as_they_were(number, tmp_path):
    write_csv(tmp_path / "t.csv", [{"a": number, "b": None}], ["a", "b"])
    assert cells(tmp_path / "t.csv") == [["a", "b"], [str(number), ""]]


def test_a_strangers_names_are_no_formulas(fake_vc, tmp_path):
    given = {"over": {"c_e": [4]}, "size": (8, 6), "metrics": ["rel_l1"]}
    sweep("room", "whitted", directory=tmp_path, **given)
    with Store(tmp_path) as store:
        point = store.definition()["points"][0]
        store.put_comparison(point["key"], point["paired"], {"=cmd|/x": 1.0})
    sweep("room", "whitted", directory=tmp_path, **given)
    head, row = cells(tmp_path / "table.csv")
    assert "'=cmd|/x" in head
    assert not any(cell.startswith(("=", "+", "-", "@")) for cell in head + row)


@pytest.mark.parametrize("value", ["=1+1", [1], True])
def test_a_metric_that_is_no_number_is_refused(value, fake_vc, tmp_path):
    given = {"over": {"c_e": [4]}, "size": (8, 6), "metrics": ["rel_l1"]}
    sweep("room", "whitted", directory=tmp_path, **given)
    with Store(tmp_path) as store:
        point = store.definition()["points"][0]
        store.put_comparison(point["key"], point["paired"], {"rel_l1": value})
    with pytest.raises(
        ValueError, match=r"sweep.sqlite.* must be a table of numbers, got .*rel_l1"
    ):
        sweep("room", "whitted", directory=tmp_path, **given)
