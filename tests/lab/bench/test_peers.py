"""`viscache bench peers`: what it asks of peers, and that wrong answers are refused."""

import contextlib
import dataclasses
import json
import sys

import numpy as np
import pytest

import viscache as vc
from viscache import cli
from viscache_lab import bench
from viscache_lab.bench import against_peers, peer_cases, peer_page, peers
from viscache_lab.bench.errors import log_interval
from viscache_lab.bench.text import text as table
from viscache_lab.experiment import Trial, amounts


class Fake(contextlib.AbstractContextManager):
    """A peer in this process: our own frames, `factor` times as bright, `slow` times as long.

    `built` times a frame's time of that is a build.
    """

    about = {"jobs": ["ao", "any_hit", "nearest"], "version": "9"}  # noqa: RUF012

    def __init__(self, case=None, scene=None, *, factor=1.0, slow=3.0, flip=0.0, built=0.0):
        self.case, self.scene = case, scene
        self.factor, self.slow, self.flip, self.built = factor, slow, flip, built

    def give(self, **arrays):
        self.given = arrays

    def run(self, job):
        if job["job"] == "ao":
            frame = self.case.render(job["spp"], job["seed"])
            self.made = {"image": self.factor * frame.image.mean(axis=2)}
            cpu = frame.timings["cpu_s"]
        else:
            origins, directions = self.given["origins"], self.given["directions"]
            if job["job"] == "any_hit":
                found = self.scene.occluded(origins, directions, self.given["t_max"])
                wrong = np.arange(len(found)) < self.flip * len(found)
                self.made = {"occluded": found ^ wrong}
            else:
                t = self.scene.intersect(origins, directions).t
                self.made = {"t": self.factor * t}
            cpu = 1e-3
        report = {"build_cpu_s": self.built * cpu} if self.built else {}
        return amounts.Sample(wall_s=self.slow * cpu, cpu_s=self.slow * cpu), report

    def result(self):
        return self.made

    def __exit__(self, *_):
        pass


@pytest.fixture(scope="module")
def case():
    return peer_cases.picture_cases(quick=True)[0]


def compared(case, **how):
    trial = Trial()
    against_peers.compare_pictures(trial, {"fake": Fake(case, **how)}, case, 4)
    return trial


def test_a_peer_that_agrees_has_a_figure_with_an_interval(case):
    trial = compared(case)
    assert trial.answers_hold
    (figure,) = trial.figures
    assert figure["version"] == "9" and figure["spp"] == case.spp
    assert figure["equal_error_low"] < figure["equal_error"] < figure["equal_error_high"]
    # The same renderer with other seeds
    assert figure["relative_rmse"] == pytest.approx(figure["baseline_relative_rmse"], rel=0.1)


def test_a_build_is_told_apart_and_not_done_again_for_more_samples(case):
    (figure,) = compared(case, slow=11.0, built=10.0).figures
    assert figure["build_s"] == pytest.approx(figure["baseline"] * 10 / 11)
    assert figure["ratio_without_build"] == pytest.approx(figure["ratio"] / 11, rel=0.01)
    # The same renderer: a share of eleven follows the errors, and the errors differ by chance
    rest = figure["equal_error_without_build"]
    assert figure["equal_error_low"] <= figure["equal_error"] <= figure["equal_error_high"]
    assert 10 * rest / 2 < figure["equal_error"] < 2 * 11 * rest


def test_a_cache_takes_turns_with_its_error(case):
    half = peer_cases.Way(
        label="half", render=lambda spp, seed: halved(case.render(spp, seed)), biased=True
    )
    first, second = compared(dataclasses.replace(case, ways=(half,))).figures
    assert (first["name"], second["name"]) == (f"{case.name} vs fake", f"{case.name}, half vs fake")
    assert second["rel_l1"] == pytest.approx(0.5, rel=1e-3)
    assert "equal_error" not in second


def test_another_unbiased_way_takes_turns_to_equal_error(case):
    # Four times the samples: as much more time, and at most as much less error
    more = peer_cases.Way(label="more", render=lambda spp, seed: case.render(4 * spp, seed + 50))
    first, second = compared(dataclasses.replace(case, ways=(more,))).figures
    assert second["name"] == f"{case.name}, more vs fake" and "rel_l1" not in second
    assert second["relative_rmse"] < 0.75 * first["relative_rmse"]
    assert second["ratio"] < 0.75 * first["ratio"]
    assert second["equal_error_low"] < second["equal_error"] < second["equal_error_high"]


def test_peers_may_have_another_number_of_samples_to_converge(case):
    class Counting(Fake):
        asked = ()

        def run(self, job):
            self.asked += (job["spp"],)
            return super().run(job)

    fake = Counting(case)
    other = dataclasses.replace(case, peer_reference_spp=case.reference_spp + 1)
    against_peers.compare_pictures(Trial(), {"fake": fake}, other, 2)
    assert fake.asked == (case.reference_spp + 1, *[case.spp] * 3)


def test_a_case_may_go_without_a_peer_by_name(case):
    trial = Trial()
    two = {"slow": Fake(case), "fake": Fake(case)}
    other = dataclasses.replace(case, without={"slow": "hours", "absent": "days"})
    against_peers.compare_pictures(trial, two, other, 2)
    assert [f["name"] for f in trial.figures] == [f"{case.name} vs fake"]
    assert trial.skipped == [{"what": f"{case.name} vs slow", "reason": "hours"}]


def halved(frame):
    frame.layers["color"] *= 0.5
    return frame


@pytest.mark.parametrize("jobs", [0, 3], ids=["at once", "between turns"])
def test_a_peer_that_ends_is_left_out_and_the_others_are_compared(case, jobs, monkeypatch):
    class Ends(Fake):
        left = jobs

        def run(self, job):
            self.left -= 1
            if self.left < 0:
                raise peers.PeerError("the other program ended with status -6", "mitsuba")
            return super().run(job)

    monkeypatch.setattr(against_peers, "PEERS", {"mitsuba": ("a", ""), "cycles": ("b", "")})
    monkeypatch.setattr(against_peers, "interpreter", lambda package, folder: sys.executable)
    made = {"mitsuba": Ends, "cycles": Fake}
    monkeypatch.setattr(against_peers, "Peer", lambda name, scene, python: made[name](case))
    trial = Trial()

    def compare(found, able):
        against_peers.compare_pictures(found, able, case, 4)

    against_peers._with_peers(trial, case.name, case.scene, None, compare)
    assert [f["name"] for f in trial.figures] == [f"{case.name} vs cycles"]
    why = "the other program ended with status -6"
    assert trial.skipped == [{"what": f"{case.name} vs mitsuba", "reason": why}]


@pytest.mark.parametrize("factor", [0.97, 1.03, float("nan")])
def test_a_peer_whose_frames_differ_is_refused(case, factor):
    trial = compared(case, factor=factor)
    assert not trial.answers_hold
    assert trial.figures == []


@pytest.mark.parametrize(("how", "holds"), [({}, 4), ({"flip": 0.01}, 2), ({"factor": 1.01}, 2)])
def test_rays_that_are_answered_otherwise_are_refused(how, holds):
    scene = amounts.build_scene("random_triangles?triangles=3000")
    trial = Trial()
    fake = Fake(scene=scene, **how)
    against_peers.compare_rays(trial, {"fake": fake}, "rays", scene, 4000, 2)
    assert len(trial.figures) == holds
    assert trial.answers_hold == (holds == 4)


def test_jobs_that_a_peer_does_not_have_are_not_asked(case):
    fake = Fake(case)
    fake.about = {"jobs": []}
    trial = Trial()
    against_peers.compare_pictures(trial, {"fake": fake}, case, 2)
    assert trial.figures == [] and trial.answers_hold


def test_ratios_have_the_interval_of_their_logarithms():
    mean, low, high = log_interval([1.0, 4.0])
    assert mean == pytest.approx(2.0)
    # t(1, 97.5 %) = 12.706, standard error ln 2
    assert (low, high) == pytest.approx((2 * 2**-12.7062, 2 * 2**12.7062), rel=1e-3)
    for bad in ([2.0], [1.0, 0.0], [1.0, float("nan")], [1.0, float("inf")]):
        with pytest.raises(ValueError, match="ratios must be"):
            log_interval(bad)


def test_interpreters_are_those_of_the_folder_or_this_one(tmp_path, monkeypatch):
    assert str(peers.interpreter("numpy", tmp_path)) == sys.executable
    assert peers.interpreter("no_such_package", tmp_path) is None
    own = tmp_path / "no_such_package" / "bin" / "python"
    own.parent.mkdir(parents=True)
    own.touch()
    assert peers.interpreter("no_such_package", tmp_path) == own


def test_the_default_folder_is_among_the_users_caches(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert peers.default_folder() == tmp_path / "viscache" / "peers"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert peers.default_folder() == tmp_path / ".cache" / "viscache" / "peers"


def test_environments_that_cannot_be_made_say_why(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(peers, "PACKAGES", {"x": ("x",)})
    (tmp_path / "x").write_text("in the way")
    status = cli.main(["bench", "peers", "--make-environments", "--environments", str(tmp_path)])
    said = capsys.readouterr().out
    assert status == 1 and said.startswith("x: ") and "made" not in said


def test_without_peers_all_are_skipped_by_name(tmp_path, monkeypatch):
    monkeypatch.setattr(against_peers, "interpreter", lambda package, folder: None)
    result = bench.run_bench("peers", quick=True)
    assert result["figures"] == [] and result["answers_hold"] and result["answers_checked"]
    skipped = {s["what"].rpartition(" vs ")[2] for s in result["skipped"]}
    assert skipped == set(peers.PEERS)
    packages = ("mitsuba", "embreex", "bpy", "pyluxcore")
    reasons = {f"{package} is not installed" for package in packages}
    assert {s["reason"] for s in result["skipped"]} == reasons


def test_a_peer_that_ends_is_an_error_with_its_status(monkeypatch):
    monkeypatch.setitem(peers.PEERS, "gone", ("numpy", "viscache_lab.bench.no_such_module"))
    with pytest.raises(peers.PeerError, match="status 1"):
        peers.Peer("gone", amounts.build_scene("cube_on_plane"))


@pytest.mark.parametrize(
    "arguments",
    [
        ["peers", "--threads", "1"],
        ["rays", "--environments", "x"],
        ["rays", "--make-environments"],
        ["rays", "-o", "x"],
        ["rays", "--only", "x"],
    ],
)
def test_options_of_other_benches_are_refused(arguments, capsys):
    assert cli.main(["bench", *arguments]) != 0
    assert "option of the bench" in capsys.readouterr().err


def test_chosen_cases_are_compared_alone(monkeypatch):
    compared_names = []
    monkeypatch.setattr(
        against_peers, "_with_peers", lambda trial, name, *_: compared_names.append(name)
    )
    against_peers.against_peers(Trial(quick=True, options={"only": "environment, [rs]*"}))
    assert compared_names == [
        "environment, stairs 32x32, 4 + 4 samples",
        "environment, room with a window 32x32, 4 + 4 samples",
    ]
    del compared_names[:]
    against_peers.against_peers(Trial(quick=True, options={"only": "rays, *"}))
    assert compared_names == ["rays, room", "rays, random_triangles"]
    with pytest.raises(ValueError, match="no case of the bench peers is named like 'x'"):
        against_peers.against_peers(Trial(quick=True, options={"only": "x"}))


def test_pages_show_figures_and_what_was_left_out(tmp_path):
    result = {
        "machine": {"processor": "A <b>", "cores": 2, "load": 0.5},
        "answers": [{"what": "frame", "value": 0.5, "limit": 0.01, "holds": False}],
        "notes": ["a note"],
        "skipped": [{"what": "AO vs x", "reason": "x is not installed"}],
        "figures": [
            {
                **amounts.figure("AO vs y", 1.0, "s", baseline=2.0, ratios=[2.0, 3.0]),
                **{"equal_error": 4.0, "equal_error_low": 3.25, "equal_error_high": 5.0},
                **{"build_s": 1.5, "ratio_without_build": 1.25, "equal_error_without_build": 2.0},
            }
        ],
    }
    peer_page.write_pages(tmp_path, result)
    text = (tmp_path / "index.html").read_text("utf-8")
    assert "A &lt;b&gt;" in text and "4.00 [3.25, 5.00], without its build 2.00<" in text
    assert "2.50 [2.00, 3.00], without its build 1.25<" in text
    assert "without its build of 1.5 s 1.25x, 2.00x" in table({**result, "bench": "peers"})
    assert "x is not installed" in text and "frame: 0.5, at most 0.01" in text
    assert json.loads((tmp_path / "peers.json").read_text("utf-8")) == result


@pytest.mark.bench
@pytest.mark.parametrize("name", list(peers.PEERS))
def test_real_peers_agree_in_every_case(name, monkeypatch):
    package = peers.PEERS[name][0]
    if peers.interpreter(package, peers.default_folder()) is None:
        pytest.skip(f"{package} is not installed")
    monkeypatch.setattr(against_peers, "PEERS", {name: peers.PEERS[name]})
    trial = Trial(quick=True)
    against_peers.against_peers(trial)
    assert trial.answers_hold, trial.answers
    if trial.skipped:  # no LLVM, or one that does not suit Mitsuba
        pytest.skip(trial.skipped[0]["reason"])
    assert trial.figures


def test_cases_hand_over_the_scene_that_we_render(case):
    assert isinstance(case.scene, vc.Scene)
    assert set(case.job) == {"job", "samples", "reach", "side", "fov_rad"}
    np.testing.assert_allclose(np.linalg.norm(case.arrays["camera"][1:], axis=1), 1, atol=1e-6)
