"""C_E from an error target: the search, the interval, and the error that frames then have."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import viscache as vc
from reference.built import built
from viscache import cli
from viscache.settings.not_given import NotGiven
from viscache.shot.exact_cost import SHARED_LIGHTS
from viscache.shot.render import render_part
from viscache.sweeps import samples
from viscache.sweeps.jointly import MOST_HALVINGS, MOST_TRIALS, with_light_cells
from viscache.sweeps.samples import ratio
from viscache.sweeps.search import MOST_PILOTS, search
from viscache.sweeps.searched import C_E
from viscache.sweeps.tune import Pilot, Tuned


@given(scale=st.floats(1e-4, 1e-2), power=st.floats(0.3, 2.0), target=st.floats(2e-3, 0.1))
def test_the_search_finds_the_c_e_of_any_power_law(scale, power, target):
    def error(c_e):
        return Pilot(c_e, scale * c_e**power, 1.0)

    tried = search(error, target, C_E)
    wanted = (target / scale) ** (1 / power)
    best = min(tried, key=lambda p: abs(math.log(p.error / target)))
    assert len(tried) <= MOST_PILOTS
    if best.error != pytest.approx(target, rel=0.05):
        assert not C_E.low <= wanted <= C_E.high
        assert best.c_e == (C_E.low if wanted < C_E.low else C_E.high)


def test_the_search_follows_a_curve_that_is_no_power_and_jumps():
    tried = search(lambda c: Pilot(c, 0.002 * c**1.6 if c < 6 else 0.03 + 0.01 * c, 1.0), 0.03, C_E)
    below = [p for p in tried if p.error <= 0.03]
    assert max(p.error for p in below) > 0.025


def test_the_interval_of_a_ratio_covers_the_truth_as_often_as_it_says():
    rng = np.random.default_rng(4)
    covered, total = 0, 400
    for _ in range(total):
        light = rng.uniform(0.5, 2.0, 24)
        wrong = light * 0.02 * rng.gamma(4.0, 0.25, 24)
        found, (low, high) = ratio(wrong, light)
        assert low <= found <= high
        covered += low <= 0.02 <= high
    assert 0.90 <= covered / total <= 0.99
    assert ratio([1.0], [4.0]) == (0.25, (0.0, math.inf))


def tuned(error, **changes):
    """What a search for 1 % found; one that is cheaper than exact unless changed."""
    values = {
        "target": 0.01,
        "parameter": "c_e",
        "value": 8.0,
        "visibility": vc.Aqvc(c_e=8),
        "rel_l1": error / 2,
        "rel_l1_reflected": error,
        "interval": (0.75 * error, 1.25 * error),
        "ray_reduction": 5.0,
        "pilots": (Pilot(4.0, 0.005, 3.0), Pilot(8.0, 0.01, 5.0)),
        "samples": 4,
        "groups": {"point": 0.02, "vpl": 0.001},
        "seconds": 1.0,
        "seconds_exact": 4.0,
    }
    return Tuned(**values | changes)


def error_of(scene, integrator, found, **frame):
    exact = vc.render(scene, integrator, **frame)
    cached = vc.render(scene, integrator, visibility=found.visibility, **frame)
    return float(vc.metrics.compare(cached, exact, metrics=[found.metric])[found.metric])


def test_a_small_frame_is_tuned_by_other_eye_samples_and_checked_by_itself():
    scene, whitted = built("room?triangles=3000"), vc.Whitted(n_vpls=32)
    found = vc.tune(scene, whitted, rel_l1_reflected=0.02, size=(96, 60), seed=5)
    assert found.samples == 24 and found.visibility.c_e == found.c_e
    assert found.outcome == "within noise" and not found.reached
    assert found.interval[0] <= found.error <= found.interval[1]
    got = error_of(scene, whitted, found, size=(96, 60), seed=5)
    assert 0.02 / 1.3 <= got <= 0.02 * 1.3 and got == pytest.approx(found.error, rel=1e-5)
    assert "queries per ray" in found._repr_html_() and "c_e=" in repr(found)


def test_other_parameters_stay_and_an_easier_target_takes_fewer_rays():
    scene, direct = built("room?triangles=3000"), vc.Direct()
    base = vc.Aqvc(c_n=4, c_z=2)
    easy, hard = (
        vc.tune(scene, direct, rel_l1_reflected=e, visibility=base, size=(96, 60))
        for e in (0.05, 0.01)
    )
    assert (easy.visibility.c_n, easy.visibility.c_z) == (4, 2)
    assert easy.c_e > hard.c_e and easy.ray_reduction > hard.ray_reduction


def test_a_target_out_of_reach_is_told():
    scene = built("room?triangles=3000")
    found = vc.tune(scene, vc.Direct(), rel_l1_reflected=1e-7, size=(48, 30))
    assert found.c_e < 1.1 * C_E.low and not found.reached
    assert found.pilots[0].c_e == C_E.low
    assert found.message.startswith(
        "No C_E reaches rel_l1_reflected 1e-07: the smallest error found is"
    )
    assert "'point' limits it" in found.message and "pixel's own" not in found.message
    assert found.message in found._repr_html_().replace("&#x27;", "'")


def test_under_a_sky_the_message_names_the_floor_and_what_limits():
    scene = built("apartment?triangles=2000")
    whitted = vc.Whitted(n_vpls=33, n_environment=2, n_brdf=2)
    one = vc.Aqvc(c_l=1, exact_groups=())
    found = vc.tune(scene, whitted, rel_l1_reflected=0.004, size=(48, 36), visibility=one)
    assert found.visibility.c_l == 1
    finest, coarser = (found.pilots[i].error for i in (0, 2))
    assert not found.reached and finest > 0.5 * coarser > 0.004  # no C_E goes below
    assert max(found.groups, key=found.groups.__getitem__) == "environment"
    assert "No C_E reaches rel_l1_reflected 0.004: the smallest error found is" in found.message
    assert "The group 'environment' limits it" in found.message
    assert "light cells bounds their error, not C_E." in found.message
    assert "A smaller c_l makes the cells smaller" in found.message
    assert "so do more samples (n_environment, n_brdf)" in found.message


def test_under_a_sky_light_cells_are_made_as_small_as_the_target_needs():
    scene = built("apartment?triangles=2000")
    whitted = vc.Whitted(n_vpls=33, n_environment=2, n_brdf=2)
    every = vc.Aqvc(exact_groups=())
    found = vc.tune(scene, whitted, rel_l1_reflected=0.008, size=(96, 72), visibility=every)
    assert found.outcome != "missed" and "limits it" not in found.message
    assert found.visibility.c_l is not None and found.visibility.c_l < 1
    assert f"c_l={found.visibility.c_l:.3g}" in repr(found)
    assert found.as_dict()["c_l"] == found.visibility.c_l
    assert error_of(scene, whitted, found, size=(96, 72)) < 0.008 * 1.3
    # Lamps have no light cells
    lamps = vc.tune(
        scene, vc.Direct(n_environment=0, n_brdf=0), rel_l1_reflected=0.02, size=(48, 36)
    )
    assert isinstance(lamps.visibility.c_l, NotGiven) and lamps.as_dict()["c_l"] == 1


def test_light_cells_are_halved_until_they_leave_half_of_the_target():
    def groups(tried):
        return {"environment": 0.08 * tried.resolved()["c_l"], "point": 1.0}

    assert isinstance(with_light_cells(groups, vc.Aqvc(), 0.2).c_l, NotGiven)
    assert with_light_cells(groups, vc.Aqvc(), 0.03).c_l == 1 / 8
    assert with_light_cells(groups, vc.Aqvc(), 1e-9).c_l == 0.5**MOST_HALVINGS
    assert with_light_cells(groups, vc.Aqvc(c_l=2), 1e-9).c_l == 2
    tried = []

    def slow(setting):
        tried.append(setting.resolved()["c_l"])
        return {"environment": 0.08 * tried[-1] ** 0.5}

    with_light_cells(slow, vc.Aqvc(), 0.03)
    assert len(tried) == MOST_TRIALS and tried[0] == 1


def test_what_the_groups_are_off_by_explains_the_error():
    scene = built("room?triangles=3000")
    found = vc.tune(scene, vc.Whitted(n_vpls=32), rel_l1_reflected=0.02, size=(96, 60))
    assert set(found.groups) == {"point", "vpl"} and "limits it" not in found.message
    assert found.error <= sum(found.groups.values()) * (1 + 1e-6)
    assert max(found.groups.values()) <= 1.5 * found.error


def test_an_error_that_only_unseen_pixels_have_is_told_apart_from_a_floor():
    found = tuned(0.02)
    assert "is not confirmed: pilots had 0.01 at C_E = 8" in found.message
    assert "have 0.02 [0.015, 0.025]. The group 'point' limits it, off by 0.02" in found.message
    assert "have 0.007 [0.00525, 0.00875]." in tuned(0.007).message  # below, and no limit
    near = tuned(0.009)
    assert near.outcome == "within noise" and near.message == (
        "rel_l1_reflected 0.01 is reached within noise: the error is 0.009, its 95 % interval"
        " 0.00675 to 0.0112."
    )
    assert tuned(0.0079).reached and tuned(0.0079).message == ""


def test_an_error_below_the_target_is_explained():
    most = tuned(0.004, value=4.0, pilots=(Pilot(2.0, 0.002, 2.0), Pilot(4.0, 0.004, 3.0)))
    assert most.reached and most.message == (
        "The error is below rel_l1_reflected 0.01: no C_E that was tried has more than 0.004, at 4."
    )
    jump = tuned(0.004, value=4.0, pilots=(Pilot(4.0, 0.004, 3.0), Pilot(4.2, 0.03, 3.1)))
    assert "it jumps from 0.004 at C_E = 4 to 0.03 at 4.2" in jump.message


def test_both_times_are_told_where_exact_is_cheaper():
    found = tuned(0.01, seconds=1.25, seconds_exact=1.0)
    says = "Exact visibility is cheaper here: 1 s of the CPU for a frame against 1.25 s"
    assert found.exact_is_cheaper and says in found.message and says in str(found)
    assert found.as_dict()["exact_is_cheaper"] is True and says in found._repr_html_()
    assert not tuned(0.01).exact_is_cheaper and str(tuned(0.008)) == repr(tuned(0.008))


def lamp_in_view():
    d = vc.SceneDescription()
    grey = d.add_material(base_color=(0.5, 0.5, 0.5))
    two = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    for z, half, emission in ((0.0, 4.0, 0.0), (-1.0, 0.5, 30.0)):
        corners = [[-half, z and 1.0, -half + z], [-half, z and 2.0, half + z]]
        corners += [[half, z and 2.0, half + z], [half, z and 1.0, -half + z]]
        light = {"emission": (emission,) * 3, "emits_two_sided": True} if emission else {}
        d.add_mesh(np.array(corners), two, material=grey, **light)
    for x in (-1.0, 0.0, 1.0):
        d.add_mesh(
            np.array([[x, 0, 0.5], [x, 1, 0.5], [x + 0.4, 0.5, 0.5]]), two[:1], material=grey
        )
    d.add_point_light((0.5, 3.0, 1.0), (20.0, 20.0, 20.0))
    d.add_camera((0, 1.2, 3), (0, 0.8, 0), fov_deg=60)
    return vc.Scene.from_description(d)


def test_a_lamp_in_view_does_not_hide_the_error_unless_the_papers_metric_is_asked_for():
    scene, direct = lamp_in_view(), vc.Direct(n_area=2)
    given = {"size": (96, 60)}
    given["visibility"] = vc.Aqvc(exact_groups=())
    found = vc.tune(scene, direct, rel_l1_reflected=0.02, **given)
    papers = vc.tune(scene, direct, rel_l1=0.02, **given)
    assert found.metric == "rel_l1_reflected" and found.error == found.rel_l1_reflected
    assert papers.error == papers.rel_l1 and papers.as_dict()["metric"] == "rel_l1"
    for one in (found, papers):
        assert one.outcome != "missed" and error_of(
            scene, direct, one, size=(96, 60)
        ) == pytest.approx(one.error, rel=1e-4)
    assert found.rel_l1 < 0.8 * found.error  # the lamp is a share of the light
    assert found.ray_reduction < papers.ray_reduction


def test_progress_counts_renderings_and_ends_complete():
    seen = []
    scene = built("room?triangles=2000")
    vc.tune(
        scene,
        vc.Direct(),
        rel_l1_reflected=0.03,
        size=(64, 40),
        progress=lambda *at: seen.append(at),
    )
    done = [at[0] for at in seen]
    assert done[:-1] == list(range(1, len(done))) and seen[-1] == (done[-2], done[-2])
    assert all(d <= total for d, total in seen)


def test_a_dark_picture_and_bad_arguments_are_refused():
    dark = vc.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(ValueError, match="picture must have light"):
        vc.tune(dark, vc.Direct(), size=(16, 16))
    scene = vc.scenes.cube_on_plane()
    for arguments, says in (
        ({"rel_l1_reflected": 0}, r"rel_l1_reflected must lie in \(0, 1\), got 0"),
        ({"rel_l1": math.nan}, "rel_l1 must lie in"),
        ({"visibility": vc.Exact()}, "visibility must have a parameter that is a number"),
        ({"seed": -1}, "seed must be in"),
        ({"size": (0, 4)}, "size must be"),
    ):
        with pytest.raises(ValueError, match=says):
            vc.tune(scene, vc.Direct(), **arguments)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="integrator must be"):
        vc.tune(scene, vc.Bdpt())


def test_the_command_prints_what_was_found(capsys):
    words = ["tune", "room?triangles=2000", "--integrator", "direct", "--size", "64x40"]
    assert cli.main([*words, "--error", "0.03", "--json"]) == 0
    got = json.loads(capsys.readouterr().out)
    assert got["outcome"] == "within noise" and got["target"] == 0.03
    assert cli.main([*words, "--error", "0.00000001"]) == 1
    printed = capsys.readouterr().out
    assert "missed" in printed and "No C_E reaches rel_l1_reflected 1e-08" in printed


def modelled(counters, *, exact):
    """The cost of a frame's visibility in exact queries, by its counters."""
    queries, rays = counters["queries"], counters["rays"]
    return float(queries if exact else SHARED_LIGHTS.of(rays / max(1, queries)) * queries)


@pytest.mark.parametrize(("spp", "n_vpls"), [(1, 64), pytest.param(4, 300, marks=pytest.mark.slow)])
def test_tuning_costs_less_than_twenty_of_the_frames_it_finds(monkeypatch, spp, n_vpls):
    """By counted queries and rays. A frame of few tiles, and one of enough to be halved."""
    spent = []

    def counting(*given, **more):
        made = render_part(*given, **more)
        spent.append(modelled(made.counters, exact=isinstance(given[0].visibility, vc.Exact)))
        return made

    monkeypatch.setattr(samples, "render_part", counting)
    scene, whitted = built("room?triangles=2000"), vc.Whitted(n_vpls=n_vpls)
    frame = {"size": (256, 160), "spp": spp}
    found = vc.tune(scene, whitted, rel_l1_reflected=0.02, **frame)
    final = vc.render(scene, whitted, visibility=found.visibility, **frame)
    assert sum(spent) < 20 * modelled(final.counters, exact=False)
    assert len(spent) >= 5
