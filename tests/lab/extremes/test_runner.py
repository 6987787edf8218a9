"""Families run in processes: crashes and hangs are failed checks and take nothing with them."""

import json
from pathlib import Path

import pytest

from viscache import cli
from viscache_lab import extremes
from viscache_lab.experiment import FAMILIES, Experiment, children
from viscache_lab.experiment.checks import Case, Check, checked
from viscache_lab.extremes.compare import differences


@pytest.fixture
def broken(monkeypatch):
    monkeypatch.setattr(children, "CHILD", (str(Path(__file__).with_name("broken_child.py")),))
    for name in ("broken", "stops", "ends"):
        family = Experiment(description="made up", function=lambda full: iter(()))
        monkeypatch.setitem(FAMILIES, name, family)


def test_a_crash_a_hang_and_an_exception_fail_their_check_alone(broken):
    told = []
    found = extremes.run(["broken"], limit_s=3, told=told.append)
    assert found == told
    states = {check.name.removeprefix("broken: "): check for check in found}
    assert list(states) == [
        *("fine", "crashes", "hangs", "raises", "no number", "too large", "fine again")
    ]
    assert [n for n, check in states.items() if check.holds] == ["fine", "fine again"]
    assert states["crashes"].error == "ended by SIGSEGV" and states["crashes"].value is None
    assert states["hangs"].error == "no answer within 3 s"
    assert "RuntimeError: something is wrong" in states["raises"].error
    assert states["no number"].error == "not a number"
    assert states["too large"].value == 2 and states["too large"].error == ""
    assert all(check.limit == 1 and check.why == "made up" for check in found)


@pytest.mark.parametrize(
    ("name", "says"), [("stops", "RuntimeError: no more cases"), ("ends", "status 3")]
)
def test_a_process_that_ends_too_early_is_a_failed_check(broken, name, says):
    fine, failed = extremes.run([name])
    assert fine.holds and fine.name == f"{name}: fine"
    assert not failed.holds and says in failed.error
    assert failed.name == f"{name}: the process starts and ends by itself"


def test_an_unknown_family_is_refused_with_the_nearest_name():
    with pytest.raises(ValueError, match=r"family must be known.*'scales'"):
        extremes.run(["scale"])


@pytest.mark.parametrize(
    ("value", "limit", "holds"),
    [
        (0.0, 0, True),
        (1e-30, 0, False),
        (1.0, 1, True),
        (0.5, (0.4, 2.0), True),
        (0.3, (0.4, 2.0), False),
        (2.1, (0.4, 2.0), False),
        (float("inf"), 1e30, False),
        (float("nan"), 1e30, False),
    ],
)
def test_a_value_holds_up_to_its_limit(value, limit, holds):
    check = checked(Case(name="a", measure=lambda: value, limit=limit, why="made up"))
    assert check.holds == holds
    again = Check.from_dict(json.loads(json.dumps(check.as_dict())))
    assert again == check and check.as_dict()["holds"] == holds
    assert check.line().startswith("ok " if holds else "FAIL")


def report(**values):
    checks = [{"name": n, "value": v, "limit": 1, "holds": v is not None and v <= 1}
              for n, v in values.items()]  # fmt: skip
    machine = {"cpu": "a CPU", "isa": {"active": "avx2"}, "versions": {"embree": "3"}}
    return {"checks": checks, **machine}


def test_two_reports_differ_where_states_or_values_do():
    a = report(same=0.5, near=0.3, far=0.1, fails=0.5, gone=0.0, crashed=0.5, tiny=1e-12)
    b = report(same=0.5, near=0.4, far=0.3, fails=2.0, new=0.0, crashed=None, tiny=0.0)
    assert differences(a, a) == []
    assert differences(a, b) == [
        ("far", "value", 0.1, 0.3),
        ("fails", "holds", True, False),
        ("gone", "there", True, False),
        ("crashed", "holds", True, False),
        ("new", "there", False, True),
    ]


def test_doctor_compares_two_files(capsys, tmp_path):
    paths = [str(tmp_path / name) for name in ("a.json", "b.json", "c.json")]
    for path, made in zip(paths, (report(x=0.1), report(x=0.9), report(x=2.0)), strict=True):
        Path(path).write_text(json.dumps(made))
    assert cli.main(["doctor", "--compare", paths[0], paths[1]]) == 0
    assert "x: value 0.1 and 0.9\n1 differences" in capsys.readouterr().out
    assert cli.main(["doctor", "--compare", paths[0], paths[2], "--json"]) == 1
    held = {"name": "x", "what": "holds", "a": True, "b": False}
    assert json.loads(capsys.readouterr().out) == {"differences": [held]}
    Path(paths[0]).write_text("{}")
    assert cli.main(["doctor", "--compare", paths[0], paths[2]]) == 2
    assert "must be an output of viscache doctor --json" in capsys.readouterr().err


def test_doctor_prints_a_line_and_a_record_per_check(capsys, monkeypatch):
    made = [
        Check(name="a: fine", value=0.0, limit=0, family="a"),
        Check(name="a: bad", value=2.0, limit=(0.0, 1.0), family="a"),
    ]

    def run(names, *, full, told):
        for check in made:
            told(check)
        return made

    monkeypatch.setattr(extremes, "run", run)
    assert cli.main(["doctor", "--extremes", "--json"]) == 1
    captured = capsys.readouterr()
    got = json.loads(captured.out)
    bad = {"name": "a: bad", "value": 2.0, "limit": [0.0, 1.0], "holds": False, "family": "a"}
    assert got["checks"][-1] == bad
    assert got["isa"]["active"] and got["cpu"] and got["versions"]["embree"] and not got["ok"]
    assert "FAIL a: bad (2, limit 0 … 1)" in captured.err
    made.pop()
    assert cli.main(["doctor", "--extremes"]) == 0
    assert "ok   a: fine (0, limit 0)" in capsys.readouterr().out
