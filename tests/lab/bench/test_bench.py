"""`viscache bench`: its JSON, its registry; and speed settings never change an answer."""

import dataclasses
import json
import subprocess
import sys

import numpy as np
import pytest

from viscache import _core, cli
from viscache_lab import bench
from viscache_lab.bench import peers, ray_sets, vlf_ao
from viscache_lab.experiment import Experiment, Trial, amounts

SMALL = [
    "rays",
    "aqvc-frame",
    "aqvc-apartment",
    "aqvc-lookup",
    "shafts",
    "progressive",
    "which-cache",
    "picks",
    "skies",
    "meter",
    "threads",
    "loading",
    "correlation",
    "vlf-build",
    "vlf-ao",
    "vismap-variance",
    "sweep",
    "parity",
    "peers",
]
FIGURE_KEYS = {"name", "value", "unit", "baseline", "ratio", "goal", "holds", "low", "high"}
SCENES = ("room?triangles=3000", "random_triangles?triangles=3000", "courtyard?triangles=30000")


def main(arguments):
    return cli.main(["bench", *arguments])


@pytest.fixture(scope="module", params=SCENES)
def scene(request):
    return amounts.build_scene(request.param)


@pytest.mark.parametrize("name", ray_sets.SETS)
def test_every_packet_width_and_flag_gives_the_same_bytes(scene, name):
    rays = ray_sets.make_ray_set(scene, name, 3001)
    caster = scene.caster()
    usual = scene.occluded(rays.origins, rays.directions, rays.t_max)
    assert usual.any()
    for width in (1, 4, 8, 16):
        for coherent in (False, True):
            given = (rays.origins, rays.directions, rays.t_max, width)
            found = caster.bare_occluded(*given, coherent=coherent)
            assert found.tobytes() == usual.tobytes(), (width, coherent)


@pytest.mark.parametrize("name", ["camera", "hemi"])
def test_trials_and_sorting_do_not_change_answers(scene, name):
    # Enough rays that every thread tries both flags, and sorts those in no order
    rays = ray_sets.make_ray_set(scene, name, 80_000)
    usual = scene.caster().bare_occluded(rays.origins, rays.directions, rays.t_max, 8)
    for threads in (1, 2, 3):
        found = scene.occluded(rays.origins, rays.directions, rays.t_max, threads=threads)
        assert found.tobytes() == usual.tobytes()


def test_rays_of_no_length_hit_nothing_at_any_width(scene):
    rays = ray_sets.make_ray_set(scene, "hemi", 100)
    t_max = np.where(np.arange(100) % 2, 0, np.inf)
    found = scene.occluded(rays.origins, rays.directions, t_max)
    unlimited = scene.occluded(rays.origins, rays.directions)
    assert not found[1::2].any()
    assert (found[::2] == unlimited[::2]).all()
    for width in (1, 4, 8, 16):
        assert not scene.caster().bare_occluded(rays.origins, rays.directions, 0.0, width).any()


def test_a_width_embree_lacks_is_refused(scene):
    rays = ray_sets.make_ray_set(scene, "hemi", 10)
    with pytest.raises(ValueError, match="width must be 1, 4, 8 or 16, got 3"):
        scene.caster().bare_occluded(rays.origins, rays.directions, 1.0, 3)


def test_ray_sets_are_the_same_each_time_and_point_away_from_their_surface(scene):
    for name in ray_sets.SETS:
        a = ray_sets.make_ray_set(scene, name, 500)
        b = ray_sets.make_ray_set(scene, name, 500)
        assert a.origins.tobytes() == b.origins.tobytes()
        assert a.directions.tobytes() == b.directions.tobytes()
        assert abs(len(a) - 500) <= 30
    points, normals = ray_sets.surface_points(scene, 500, np.random.default_rng(0))
    assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-4)
    assert (points >= scene.bounds[0] - 1e-3).all() and (points <= scene.bounds[1] + 1e-3).all()
    with pytest.raises(ValueError, match="ray set must be one of camera, hemi, ao, p2p, got 'sky'"):
        ray_sets.make_ray_set(scene, "sky", 10)


def test_cosine_directions_have_the_cosines_mean():
    scene = amounts.build_scene("cube_on_plane")
    points, normals = ray_sets.surface_points(scene, 40_000, np.random.default_rng(1))
    d = ray_sets._cosine_directions(normals, np.random.default_rng(2))
    cosines = np.sum(d * normals, axis=1)
    assert cosines.min() > 0
    # E[cos] = 2/3, variance 1/18
    assert abs(cosines.mean() - 2 / 3) < 4 * np.sqrt(1 / 18 / len(points)) + 2e-3


def test_the_list_names_all_benches():
    assert set(bench.BENCHES) == set(SMALL)


def test_an_unknown_bench_is_refused_with_the_nearest_name(capsys):
    with pytest.raises(ValueError, match="unknown bench 'ray'; did you mean 'rays'"):
        bench.run_bench("ray")
    assert main(["ray"]) == 2
    assert main(["list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["benches"]
    assert [b["bench"] for b in listed] == list(bench.BENCHES)


def test_a_bench_that_is_gone_names_what_takes_its_place(capsys):
    assert not bench.BENCHES.keys() & bench.BENCHES.gone.keys()
    for name, instead in bench.BENCHES.gone.items():
        assert main([name]) == 2
        assert f"the bench {name!r} is gone: use {instead}" in capsys.readouterr().err


def test_a_bench_of_cases_takes_them_with_their_scenes_and_its_note_comes_last():
    seen = []
    one = Experiment(
        description="",
        function=lambda trial, case, scene: seen.append((case, scene.triangles)),
        cases=("cube_on_plane",),
        quick_cases=("cube_on_plane", "no-such/scene.xml"),
        note="a note",
    )
    trial = Trial(quick=True)
    one.fill(trial)
    assert [case for case, _ in seen] == ["cube_on_plane"] and trial.notes == ["a note"]
    assert [left["what"] for left in trial.skipped] == ["no-such/scene.xml"]


def test_figures_are_medians_of_ratios_with_their_bounds():
    ours = [amounts.Sample(wall_s=t, cpu_s=2 * t) for t in (1.0, 2.0, 1.0)]
    theirs = [amounts.Sample(wall_s=t, cpu_s=3 * t) for t in (4.0, 2.0, 3.0)]
    row = amounts.ratio_figure("x vs y", ours, theirs, clock="wall_s", work=6e6, goal=2.5)
    assert row["ratio"] == 3 and row["low"] == 1 and row["high"] == 4
    assert row["value"] == 6 and row["baseline"] == 2 and row["unit"] == "Mray/s"
    assert row["holds"] is True and row["ratio_cpu"] == 4.5
    assert amounts.ratio_figure("x vs y", ours, theirs, goal=5)["holds"] is False
    assert set(row) >= FIGURE_KEYS


def test_a_wrong_answer_makes_the_bench_fail(monkeypatch, capsys):
    def wrong(trial):
        trial.check("pixels", float("nan"), 1.0)

    info = Experiment(description="", function=wrong)
    monkeypatch.setitem(bench.BENCHES, "rays", info)
    assert main(["rays"]) == 1
    assert "WRONG pixels" in capsys.readouterr().out
    trial = Trial()
    trial.check("pixels", 0.5, 1.0)
    assert trial.answers_hold
    trial.check("pixels", 1.5, 1.0)
    assert not trial.answers_hold


def test_the_machine_is_described_without_its_name():
    import socket

    text = json.dumps(amounts.machine())
    assert socket.gethostname() not in text
    assert _core.embree_version() in text


def test_peers_that_are_missing_are_named(monkeypatch):
    scene = amounts.build_scene("cube_on_plane")
    monkeypatch.setitem(peers.PEERS, "mitsuba", ("no_such_package", "x"))
    assert peers.missing("mitsuba", scene) == "no_such_package is not installed"
    instanced = amounts.build_scene("courtyard?triangles=30000")
    assert "instances" in str(peers.missing("embreex", instanced))


@pytest.mark.bench
@pytest.mark.slow
@pytest.mark.parametrize("name", SMALL)
def test_every_bench_runs_quickly_and_finds_right_answers(name):
    command = [sys.executable, "-m", "viscache", "bench", name, "--quick", "--json"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["bench"] == name
    assert result["answers_checked"] is True
    assert all(a["holds"] for a in result["answers"])
    assert result["figures"] or result["skipped"]
    for row in result["figures"]:
        assert set(row) >= FIGURE_KEYS
        assert row["value"] > 0
        if "at_most" in row:  # an amount, not a ratio
            assert row["at_most"] is None or row["holds"] == (row["value"] <= row["at_most"])
            continue
        if row["ratio"] is None and name == "meter":  # a cost or coverage without a goal
            continue
        assert row["low"] <= row["ratio"] <= row["high"]
        assert row["goal"] is None or row["holds"] == (row["ratio"] >= row["goal"])
        assert " vs " in row["name"] or name == "meter"  # coverage


@pytest.mark.slow
def test_the_living_rooms_frame_is_measured_and_embrees():
    trial = Trial(quick=True)
    living_room = vlf_ao.CASES[-1]
    for case, scene in trial.scenes([dataclasses.replace(living_room, side=32)]):
        vlf_ao.vlf_ao(trial, case, scene)
    if trial.skipped:
        pytest.skip(trial.skipped[0]["reason"])
    (figure,) = trial.figures
    assert figure["name"] == "AO living-room 32x32 frame vs embree"
    assert figure["engine"]["name"] in ("batch", "embree")
    assert all(a["holds"] for a in trial.answers)
