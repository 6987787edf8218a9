"""Corrections by class: expectations, what is learnt, and the layer of their variance."""

import numpy as np
import pytest

import viscache as vc
from oracles.slats import slats
from reference.built import built
from viscache import _core
from viscache.oracles.learned import (
    LEAST_CHECKED,
    N_CLASSES,
    PassMemory,
    best_scale,
    octaves_of,
    unlearnt,
)
from viscache.settings.aqvc import LIGHT_GROUPS
from viscache.shot.render import render_part
from viscache.shot.shot import BareShot

#: Draws of a pixel repeat their turns after so many samples.
CYCLE = 256
CACHE = vc.Aqvc(c_e=16, exact_groups=())


@pytest.fixture(scope="module")
def hall():
    lamps = ((0.3, 0.1, 1.5), (-0.9, 0.6, 1.1), (1.2, -0.7, 2.0))
    return slats([(place, 1) for place in lamps], base_color=(0.5, 0.5, 0.5))


def shot(scene, size, use):
    """Pixels' centres."""
    return BareShot(scene, vc.Direct(centred=True), size=size, visibility=CACHE, use=use)


def frames(scene, memory, size, **use):
    """Frames of samples 0, 1, ..., all at the pixels' centres."""
    asked = shot(scene, size, use=vc.Correct(**use))
    return [render_part(asked, first_sample=n, memory=m) for n, m in enumerate(memory)]


def memory(octaves, epoch=3):
    return PassMemory(_core.KeptLights(), octaves, epoch)


def mixed(seed):
    """Octaves that differ between classes."""
    return np.random.default_rng(seed).integers(0, 5, (len(LIGHT_GROUPS), N_CLASSES)).tolist()


def mean_of(found):
    return np.mean([f.image.astype(np.float64) for f in found], axis=0)


@pytest.mark.parametrize("octaves", [unlearnt(), mixed(1), mixed(2)], ids=["plain", "one", "two"])
def test_all_turns_together_are_the_exact_frame(hall, octaves):
    """Sixteen pixels, three lights: in a cycle each answer is checked 256 q times, exactly.

    So the mean over all draws, weighted by their probabilities, is the exact frame.
    """
    size = (4, 4)
    exact = vc.render(hall, vc.Direct(centred=True), size=size).image
    found = frames(hall, [memory(octaves) for _ in range(CYCLE)], size, certain=2.0)
    cached = vc.render(hall, vc.Direct(centred=True), size=size, visibility=CACHE).image
    assert np.abs(cached - exact).max() > 0.1 * exact.max()
    np.testing.assert_allclose(mean_of(found), exact, atol=1e-5 * float(exact.max()))
    # It is no sum of exact frames: single ones differ
    assert np.mean([np.any(np.abs(f.image - exact) > 0.01) for f in found]) > 0.9


def test_epochs_draw_independently(hall):
    size = (16, 16)
    first, again, other = (
        frames(hall, [memory(unlearnt(), e)], size, certain=2.0)[0] for e in (3, 3, 4)
    )
    assert first.sha256 == again.sha256 != other.sha256


def test_counters_by_class_add_up(hall):
    frame = vc.render(
        hall, vc.Direct(), size=(48, 48), visibility=CACHE, use=vc.Correct(certain=0.5)
    )
    classes = frame.counters["share_by_class"]
    assert list(classes) == ["point"]
    assert len(classes["point"]) == N_CLASSES
    for name, total in (
        ("queries", frame.counters["queries"]),
        ("corrections", frame.counters["corrections"]),
        ("wrong", frame.counters["wrong"]),
    ):
        assert sum(c[name] for c in classes["point"].values()) == total > 0


def test_answers_that_the_cache_doubts_are_wrong_more_often():
    given = {"visibility": vc.Aqvc(c_e=10), "use": vc.Correct(certain=1 / 64)}
    frame = vc.render("room?triangles=3000", vc.Whitted(n_vpls=256), size=(64, 64), **given)
    classes = frame.counters["share_by_class"]["vpl"].items()
    sums = {
        (word, count): sum(c[count] for n, c in classes if n.startswith(word))
        for word in ("agreed", "doubted")
        for count in ("corrections", "wrong")
    }
    wrong = [sums[word, "wrong"] / sums[word, "corrections"] for word in ("agreed", "doubted")]
    assert wrong[1] > 2 * wrong[0] > 0


def test_octaves_follow_the_root_of_the_probability():
    def counted(p, n=10000):
        return {"queries": n, "corrections": n, "wrong": round(p * n)}

    rates = (0.64, 0.16, 0.04, 0.01, 0.0025, 0.0001, 0, 0.16)
    found = octaves_of({"vpl": {str(i): counted(p) for i, p in enumerate(rates)}})
    assert found[LIGHT_GROUPS.index("vpl")] == [0, 1, 2, 3, 4, 4, 4, 1]
    assert found[LIGHT_GROUPS.index("point")] == [1] * N_CLASSES
    few = {str(i): counted(0.0, LEAST_CHECKED - 1) for i in range(N_CLASSES)}
    assert octaves_of({"vpl": few}) == unlearnt()


@pytest.mark.stat
def test_the_layer_of_variance_has_the_variance_as_its_expectation(hall):
    """Frames of independent draws: their spread, and the mean of the layer."""
    size, n = (24, 24), 192
    asked = shot(hall, size, use=vc.Correct(certain=1.0))
    found = [render_part(asked, memory=PassMemory(_core.KeptLights(), None, e)) for e in range(n)]
    spread = np.var([f.image.astype(np.float64) for f in found], axis=0, ddof=1).sum()
    layers = np.array([f.layers["variance"].astype(np.float64).sum() for f in found])
    error = layers.std(ddof=1) / np.sqrt(n)
    # The spread of the spread: pixels are independent, so it is small beside 10 %
    assert abs(layers.mean() - spread) < 0.1 * spread + 4 * error
    # Negative control: without the weights it would be far less
    assert error < 0.05 * layers.mean()
    assert layers.mean() / 2 < spread


def test_exact_and_replaced_frames_have_no_variance(hall):
    for use in (None, "replace"):
        frame = vc.render(hall, vc.Direct(), size=(8, 8), visibility=CACHE, use=use)
        assert "variance" not in frame.layers
    whole = vc.render(hall, vc.Direct(), size=(8, 8), visibility=CACHE, use=vc.Correct(share=1))
    assert not whole.layers["variance"].any()


def test_later_passes_use_what_the_first_ones_found():
    """Same bytes for any threads; with "same", passes differ from the third on."""
    options = {"size": (40, 24), "visibility": vc.Aqvc(c_e=12)}
    scene, light = built("room?triangles=3000"), vc.Whitted(n_vpls=128)
    one, two = (vc.Progressive(scene, light, threads=n, **options) for n in (1, 3))
    same = vc.Progressive(scene, light, use=vc.Correct(classes="same"), **options)
    assert one.passes(2).sha256 == two.passes(2).sha256 == same.passes(2).sha256
    assert one.passes(2).sha256 == two.passes(2).sha256 != same.passes(2).sha256
    assert len(set(one._sums.shares.octaves[LIGHT_GROUPS.index("vpl")])) > 1
    assert same._sums.shares.octaves is None


def scale_of(others, of_corrections, *, rows_are_kept=False, **counters):
    """The scale for pictures of ones with such noise."""
    ones = np.ones((10, 10, 3))
    given = {"queries": 1000, "rays": 30, "corrections": 20, "groups": {}} | counters
    variance = ones * (others + of_corrections)
    return best_scale(variance, ones * of_corrections, ones, given, rows_are_kept=rows_are_kept)


def test_the_scale_of_shares_balances_noise_and_rays():
    # (1/2 + A/s)(40 + 40 s) is least at s = sqrt(2 A)
    assert scale_of(1.0, 0.5) == 1.0
    assert scale_of(1.0, 2.1) == 2.0
    assert scale_of(1.0, 0.034) == 0.5
    assert scale_of(1.0, 0.0) == 1.0
    # Exact rays of 1000 queries cost less: (1/2 + 20/s)(40 + 40 s) is above 500
    assert scale_of(1.0, 20.0) == np.inf
    # All that could be wrong is checked: exact visibility, unless that costs less than exact rays
    assert scale_of(1.0, 0.0, rays=900, corrections=890) == np.inf
    assert scale_of(1.0, 0.0, rays=200, corrections=190) == 1.0
    # Few queries for as many rays: exact ones cost less
    exact = {"point": {"queries": 50, "rays": 50}}
    assert scale_of(1.0, 1.0, queries=100, rays=80, corrections=20, groups=exact) == np.inf
    # 400 misses in two passes cost more than exact rays, unless later passes have fewer
    assert scale_of(1.0, 0.5, rays=420) == np.inf
    assert scale_of(1.0, 0.5, rays=420, rows_are_kept=True) == 2.0
    # Edges of lamps do not hide what corrections add elsewhere
    variance, of_corrections = np.ones((10, 10, 3)), np.full((10, 10, 3), 0.6)
    variance[0, :4] = 1e6
    counters = {"queries": 10000, "rays": 300, "corrections": 200, "groups": {}}
    assert best_scale(variance, of_corrections, np.ones((10, 10, 3)), counters) == 2.0


@pytest.mark.parametrize(
    ("height", "learning"), [(0.9, 1), (0.4, 2)], ids=["even light", "in stripes, like noise"]
)
def test_passes_that_cannot_win_become_exact_and_say_so(height, learning, tmp_path):
    """Slats finer than cells: a cache is hardly right there."""
    rng = np.random.default_rng(4)
    lamps = np.column_stack([rng.uniform(-1, 1, (64, 2)), rng.uniform(1, 2, 64)])
    given = {"count": 200, "height": height, "width": 0.01}
    scene = slats([(place, 1) for place in lamps], base_color=(0.5, 0.5, 0.5), **given)
    options = {"size": (48, 48), "visibility": CACHE}
    picture = vc.Progressive(scene, vc.Direct(), **options)
    first = picture.passes(learning)
    assert first.counters["corrections"] > 0
    picture.save(tmp_path / "state.npz")
    more = picture.passes(2)
    text = f"exact visibility from pass {learning + 1} on"
    assert any(text in w for w in more.warnings), more.warnings
    assert more.counters["corrections"] == first.counters["corrections"]
    later = more.counters["queries"] - first.counters["queries"]
    assert more.counters["rays"] - first.counters["rays"] == later
    # As much from a state, and never with a number
    again = vc.Progressive(scene, vc.Direct(), **options)
    again.load(tmp_path / "state.npz")
    assert again.passes(2).sha256 == more.sha256
    kept = vc.Progressive(scene, vc.Direct(), use=vc.Correct(certain=1 / 64), **options)
    assert kept.passes(4).counters["corrections"] > first.counters["corrections"]
