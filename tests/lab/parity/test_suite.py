"""The suite on few scenes: right ones agree, wrong ones are found, and the page shows them."""

import base64
import io
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from viscache import cli
from viscache_lab import bench
from viscache_lab.experiment import Experiment, Trial
from viscache_lab.parity import judge as judging
from viscache_lab.parity import renderers, zoo
from viscache_lab.parity.judge import Effort, Judged, judge
from viscache_lab.parity.renderers import Loaded

needs_mitsuba = [
    pytest.mark.mitsuba,
    pytest.mark.skipif(renderers.missing() is not None, reason="needs the package mitsuba"),
]
CUBES = "shape/cube-mirror-x"


@pytest.fixture(autouse=True)
def no_shared_scenes(monkeypatch):
    monkeypatch.delenv("VISCACHE_SCENES", raising=False)


def run(folder=None, only=CUBES):
    options = {"only": only, "output": folder}
    return bench.parity.parity(Trial(quick=True, options=options))


def brighter(factor, load):
    """A loader whose pictures are too bright."""

    def wrong(path, threads=None):
        loaded = load(path, threads)
        inner = loaded.render

        def picture(spp, seed):
            return np.asarray(factor * inner(spp, seed), np.float32)

        return Loaded(render=picture, warnings=loaded.warnings)

    return wrong


class TestWithMitsuba:
    pytestmark = needs_mitsuba

    def test_a_cube_agrees_and_five_per_cent_more_light_does_not(self, monkeypatch):
        (right,) = run()
        assert right.verdict == "agrees"
        assert right.compared.power < 0.1
        load = judging.load_viscache
        monkeypatch.setattr(judging, "load_viscache", brighter(1.05, load))
        (wrong,) = run()
        assert wrong.silent_miss and re.fullmatch(r"energy \+[45]\.\d%", wrong.why)

    def test_a_light_that_is_five_per_cent_brighter_in_one_file_is_found(
        self, tmp_path, monkeypatch
    ):
        (case,) = [c for c in zoo.cases() if c.name == "light/point-position"]
        (path,) = zoo.write(tmp_path, [case]).values()
        other = tmp_path / "brighter.xml"
        other.write_text(path.read_text().replace("20,15,10", "21,15.75,10.5"))
        effort = Effort(first=6, most=6)
        with renderers.mitsuba() as mi:
            assert judge(mi, "right", path, effort=effort).verdict == "agrees"
            load = judging.load_viscache
            monkeypatch.setattr(judging, "load_viscache", lambda p, threads: load(other, threads))
            found = judge(mi, "wrong", path, effort=effort)
        assert found.silent_miss
        assert found.compared.energy_difference == pytest.approx(0.05, abs=0.01)

    def test_what_is_warned_of_is_listed_with_its_warning(self):
        outcome = Trial(quick=True, options={"only": "material/principled-default-sky"})
        bench.parity.parity(outcome)
        assert outcome.answers_hold
        (row,) = outcome.skipped
        assert row["what"] == "material/principled-default-sky"
        assert row["reason"].startswith("warned: 'principled' is not modelled in full")

    def test_a_file_that_is_warned_of_gets_the_first_pictures_alone(self, tmp_path):
        pictures = {"material/principled-default-sky": 3, "material/diffuse-colour-sky": 6}
        paths = zoo.write(tmp_path, [case for case in zoo.cases() if case.name in pictures])
        effort = Effort(spp=4, first=3, most=6, power=0.0)
        with renderers.mitsuba() as mi:
            for name, count in pictures.items():
                assert judge(mi, name, paths[name], effort=effort).pictures == count

    def test_a_file_that_is_refused_is_named(self, tmp_path):
        path = tmp_path / "bad.xml"
        path.write_text('<scene version="3.0.0"><shape type="ply"/></scene>')
        with renderers.mitsuba() as mi:
            found = judge(mi, "bad", path)
        assert found.verdict == "not loaded"
        assert "needs a filename" in found.why

    def test_the_page_holds_pictures_and_needs_no_other_file(self, tmp_path):
        from PIL import Image

        found = run(tmp_path, "shape/cube-*")
        page = (tmp_path / "index.html").read_text("utf-8")
        assert not re.search(r"""(src|href)=["']?http|url\(""", page)
        data = re.search(r'id="data" type="application/json">(.*?)</script>', page, re.S)
        pictures = json.loads(data[1])["pictures"]
        assert sorted(pictures) == sorted(r.name for r in found)
        for four in pictures.values():
            sizes = [Image.open(io.BytesIO(base64.b64decode(p))).size for p in four]
            assert sizes == [(64, 64), (64, 64), (64, 64), (8, 8)]


def judged_of(monkeypatch, ours, theirs, *, noise=0.01, mitsubas=()):
    """The verdict on even pictures of two levels, without a renderer."""

    def loaded(level, said=()):
        def picture(_, seed):
            rng = np.random.default_rng([seed, round(100 * level)])
            return np.asarray(level * (1 + noise * rng.normal(0, 8, (64, 64, 3))), np.float32)

        return Loaded(render=picture, warnings=list(said))

    monkeypatch.setattr(judging, "load_viscache", lambda *_: loaded(ours))
    monkeypatch.setattr(judging, "load_mitsuba", lambda *_: loaded(theirs, mitsubas))
    return judge(None, "even", Path("even.xml"), effort=Effort(first=6, most=12))


def test_pictures_that_compare_nothing_do_not_agree(monkeypatch):
    black = judged_of(monkeypatch, 0, 0)
    assert (black.verdict, black.why) == ("not comparable", "both pictures are black")
    said = judged_of(monkeypatch, 1, 0, mitsubas=("the sun is below the horizon",))
    assert said.verdict == "not comparable"
    assert said.why == "Mitsuba's picture is black: the sun is below the horizon"
    noisy = judged_of(monkeypatch, 1, 1, noise=3)
    assert noisy.verdict == "not comparable"
    assert noisy.why.startswith("the noise hides differences of less than")
    # Power: lit pictures agree, and light where Mitsuba has none is a silent miss
    assert judged_of(monkeypatch, 1, 1).verdict == "agrees"
    assert judged_of(monkeypatch, 1.05, 1).verdict == "differs"
    assert judged_of(monkeypatch, 1, 0).verdict == "differs"


def miss(share):
    """A result that needs no renderer."""
    from viscache_lab.parity.blocks import compare

    ours = np.random.default_rng(1).normal(1, 0.01, (6, 8, 8, 3))
    theirs = np.random.default_rng(2).normal(1, 0.01, (6, 8, 8, 3))
    compared = replace(compare(ours, theirs), share=share)
    return Judged(name=f"x/{share}", verdict="differs", warnings=[], mitsuba=[], compared=compared)


def test_silent_misses_come_worst_first():
    trial = Trial()
    bench.parity.record(trial, [miss(0.9), miss(0.2), miss(0.5)], 1.0)
    named = [a["what"].partition(",")[0] for a in trial.answers[1:]]
    assert named == ["x/0.2", "x/0.5", "x/0.9"]


def test_a_silent_miss_fails_the_bench(monkeypatch, capsys):
    info = Experiment(
        description="", function=lambda trial: bench.parity.record(trial, [miss(0.2)], 1.0)
    )
    monkeypatch.setitem(bench.BENCHES, "parity", info)
    assert cli.main(["bench", "parity", "--quick"]) == 1
    shown = capsys.readouterr().out
    assert "WRONG scenes that differ without a warning: 1 > 0" in shown
    assert "WRONG x/0.2" in shown


def test_without_mitsuba_the_bench_says_so(monkeypatch):
    monkeypatch.setattr(renderers, "missing", lambda: "Mitsuba 3 is not installed")
    result = bench.run_bench("parity", quick=True, only="shape/*")
    assert result["skipped"] == [{"what": "parity", "reason": "Mitsuba 3 is not installed"}]
    assert result["answers_hold"]
    # Formulas judge all the same
    (found,) = run(only="ply/encoding-*")
    assert found.verdict == "agrees"


def test_no_threads_are_refused(capsys):
    assert cli.main(["bench", "parity", "--threads", "0"]) == 2
    assert "threads must be >= 1, got 0" in capsys.readouterr().err


def test_a_pattern_that_matches_nothing_is_refused():
    if renderers.missing() is not None:
        pytest.skip("needs the package mitsuba")
    with pytest.raises(ValueError, match="no quick scene has a name like 'nothing'"):
        run(only="nothing")
