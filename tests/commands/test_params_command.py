"""`viscache params`: every parameter of every setting, with what its docstring says."""

import json

import pytest

from viscache import cli
from viscache.settings import by_name
from viscache.settings.parameter_docs import parameter_docs

NAMES = [(role, name) for role, known in by_name.NAMES.items() for name in known]


@pytest.mark.parametrize(("role", "name"), NAMES)
def test_every_parameter_is_documented_and_can_be_set(role, name):
    made = by_name.make(role, name)
    found = parameter_docs(type(made))
    assert {p.name for p in found} == set(by_name.parameters(made))
    assert [p.name for p in found if not (p.kind and p.text)] == []
    # What is printed as the default is what `--set` would take for the same settings
    for p in found:
        assert p.default == by_name.plain({p.name: by_name.parameters(made)[p.name]})[p.name]


def test_params_prints_symbol_default_range_and_meaning(capsys):
    assert cli.main(["params", "aqvc"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("aqvc: visibility, vc.Aqvc")
    assert "c_e = 12.0   (float > 0, default 12.0)" in text
    assert "vpl_key = " in text  # of PaperForm
    assert cli.main(["params", "aqvc", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    c_n = next(p for p in told["parameters"] if p["name"] == "c_n")
    assert (told["role"], told["class"]) == ("visibility", "Aqvc")
    assert c_n["default"] == 8 and "C_N" in c_n["text"]


def test_params_without_a_name_lists_the_names(capsys):
    assert cli.main(["params", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {r: list(n) for r, n in by_name.NAMES.items()}


def test_an_unknown_name_is_refused_with_the_nearest(capsys):
    assert cli.main(["params", "aqcv"]) == 2
    assert capsys.readouterr().err == "viscache: unknown name 'aqcv'; did you mean 'aqvc'?\n"
