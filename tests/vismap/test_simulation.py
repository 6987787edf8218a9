"""Single pixels estimated many times against the true sum of the texels."""

from functools import cache

import numpy as np
import pytest

import viscache as vc
from viscache import scenes
from viscache._core import AlphaMode, PointSet
from viscache.metrics.variance import variance_ratio
from viscache.vismap import MapSettings, VisibilityMapCache
from viscache_lab.bench.vismap_variance import CASES, add_figures, all_ways, check_means
from viscache_lab.cases.light_product import LUMINANCE
from viscache_lab.cases.simulation import (
    PILOT_SEED,
    PixelEstimates,
    Pixels,
    Way,
    one_shot_passes,
    pooled_alphas,
    simulate,
)
from viscache_lab.experiment import Trial

ONE, STEADY = Way(alpha=1.0), Way(alpha="previous_pass", passes=4)
PRODUCT, GUIDED = Way(), Way(alpha="previous_pass", eta=0.25, passes=4)
ORACLE = Way(alpha="oracle")
ONE_SHOT = Way(alpha="previous_pass", one_shot=True, first="pilot")


@cache
def window_room():
    made = VisibilityMapCache(scenes.window_room(), MapSettings(n_startup=400))
    made.update(size=(96, 72))
    return made


@cache
def estimates():
    ways = [PRODUCT, ONE, STEADY, GUIDED, ORACLE, ONE_SHOT]
    return simulate(window_room(), ways, [30], size=(96, 72), n_pixels=40, replicates=64)


def ratio(way):
    rows = [[r[None, :, None] for r in estimates().estimates[w, 30]] for w in (way, PRODUCT)]
    return variance_ratio(*rows).ratio


@pytest.mark.slow
def test_the_truth_is_what_the_renderer_finds():
    """The mean over pixels of a picture of the room, whose light is white and constant."""
    found = simulate(window_room(), [PRODUCT], [1], size=(28, 21), n_pixels=10**6, replicates=2)
    image = vc.render(scenes.window_room(), vc.Direct(n_environment=4000), size=(28, 21), seed=3)
    surface = image.layers["coverage"][:, :, 0] > 0
    assert found.truth.mean() == pytest.approx(image.image[surface].mean(), rel=0.05)


@pytest.mark.slow
@pytest.mark.stat
def test_every_way_is_unbiased_and_a_wrong_truth_is_found():
    trial = Trial()
    check_means(trial, "room", estimates())
    assert trial.answers_hold
    shifted = PixelEstimates(truth=estimates().truth * 1.2, estimates=estimates().estimates)
    check_means(trial, "shifted", shifted)
    assert [a["holds"] for a in trial.answers] == [True, False]


@pytest.mark.slow
def test_guiding_leaves_little_of_the_variance_and_the_control_variate_some():
    assert ratio(GUIDED) < 0.15
    assert 0.2 < ratio(ONE) < 1.1
    assert ratio(ORACLE) < 1.02 and ratio(ONE_SHOT) < 1.2


@pytest.mark.parametrize("eta", [1.0, 0.25])
def test_the_oracles_alpha_has_the_least_variance_of_all(eta):
    pixels = Pixels(window_room(), None, (96, 72))
    alphas = []
    for pixel in pixels.at(pixels.chosen(12, 3)):
        point = pixel.estimate(pixels.light, eta)
        p = point.probabilities()
        light = pixels.texels.astype(float) @ LUMINANCE * (4 * np.pi / p.size)
        edge = len(p) // len(point.cells())
        z = np.where(p > 0, light * (pixel.b.astype(float) @ LUMINANCE) * pixel.visible, 0)
        w = np.where(
            p > 0, light * point.b_tilde() * np.kron(point.cells(), np.ones((edge, edge))), 0
        )
        best = pixel.oracle_alpha(point)
        alphas.append(best)
        variances = [
            float((np.divide((z - a * w) ** 2, p, out=np.zeros_like(p), where=p > 0)).sum())
            - float((z - a * w).sum()) ** 2
            for a in (best, best - 0.02, best + 0.02)
        ]
        if w.any():
            assert variances[0] < min(variances[1:])
        else:
            assert best == 0
    assert np.count_nonzero(alphas) > 6 and np.std(alphas) > 0.05, "pixels differ"


@pytest.mark.slow
def test_a_frame_of_few_samples_is_parted_and_all_of_them_count():
    for n in range(1, 400):
        sizes = one_shot_passes(n)
        assert sum(sizes) == n and (len(sizes) == 1 or min(sizes) >= 10)
    assert one_shot_passes(300) == [10, 20, 40, 80, 150]
    pixels = Pixels(window_room(), None, (96, 72))
    found = simulate(window_room(), [ONE_SHOT], [10, 30], size=(96, 72), n_pixels=3, replicates=6)
    (alpha,) = pooled_alphas(pixels, [(1.0, PointSet.ZERO_TWO)], PILOT_SEED)
    assert 0.1 < alpha < 1.5
    for i, pixel in enumerate(pixels.at(pixels.chosen(3, 0))):
        point = pixel.estimate(pixels.light, 1.0)
        args = {"set": PointSet.ZERO_TWO, "replicates": 6, "seed": i}
        first = point.simulate(pixel.visible, n=10, alpha=alpha, **args)[:, 0] @ LUMINANCE
        np.testing.assert_allclose(found.estimates[ONE_SHOT, 10][:, i], first, rtol=1e-12)
        # A second pass of twenty, alone: its α comes from the first ten
        both = (
            point.simulate(
                pixel.visible, sizes=[10, 20], mode=AlphaMode.PREVIOUS_PASS, alpha=alpha, **args
            )
            @ LUMINANCE
        )
        np.testing.assert_allclose(both[:, 0], first, rtol=1e-12)
        mean = both @ [1 / 3, 2 / 3]
        np.testing.assert_allclose(found.estimates[ONE_SHOT, 30][:, i], mean, rtol=1e-12)
    with pytest.raises(ValueError, match="sizes and replicates must be >= 1"):
        point.simulate(pixel.visible, sizes=[10, 0])


def test_the_papers_first_pass_has_alpha_one():
    assert list(map(one_shot_passes, (10, 30, 100))) == [[10], [10, 20], [10, 20, 40, 30]]
    paper = Way(alpha="previous_pass", one_shot=True)
    found = simulate(
        window_room(), [paper, ONE, ONE_SHOT], [10, 30], size=(96, 72), n_pixels=3, replicates=4
    )
    # Sums of colours by a matrix product, whose order depends on how many there are
    np.testing.assert_allclose(found.estimates[paper, 10], found.estimates[ONE, 10], rtol=1e-12)
    assert not np.allclose(found.estimates[paper, 30], found.estimates[ONE, 30], rtol=1e-9)
    assert not np.allclose(found.estimates[paper, 10], found.estimates[ONE_SHOT, 10], rtol=1e-9)


@pytest.mark.slow
def test_figures_have_the_goals_of_their_case_as_gains():
    case = next(c for c in CASES if c.name == "window_room")
    found = simulate(window_room(), all_ways(), [30], size=(96, 72), n_pixels=4, replicates=4)
    trial = Trial()
    add_figures(trial, case, found, [30], len(window_room()))
    with_goal = [f for f in trial.figures if f["goal"] is not None]
    assert [f["name"] for f in with_goal] == [
        "window_room, guided, rqmc, 30 samples vs product sampling"
    ]
    assert with_goal[0]["goal"] == pytest.approx(20)
    assert with_goal[0]["ratio"] == pytest.approx(1 / with_goal[0]["value"])
    assert with_goal[0]["low"] <= with_goal[0]["ratio"] <= with_goal[0]["high"]


def test_the_same_seed_gives_the_same_bytes_for_any_number_of_threads():
    one, three = (
        simulate(window_room(), [GUIDED], [10], size=(96, 72), n_pixels=3, replicates=5, threads=t)
        for t in (1, 3)
    )
    np.testing.assert_array_equal(one.estimates[GUIDED, 10], three.estimates[GUIDED, 10])


def test_what_cannot_be_estimated_is_refused():
    with pytest.raises(ValueError, match=r"eta must be in \(0, 1\], got 0"):
        Way(eta=0)
    with pytest.raises(ValueError, match='alpha="loo" needs points="iid", got \'rqmc\''):
        Way(alpha="loo")
    for bad, message in (
        ({"one_shot": True, "alpha": 1.0}, 'alpha must be "previous_pass" with one_shot'),
        ({"one_shot": True, "alpha": "previous_pass", "passes": 2}, "passes must be 1 with one_sh"),
        ({"alpha": "best"}, "alpha must be a number"),
    ):
        with pytest.raises(ValueError, match=message):
            Way(**bad)
    with pytest.raises(ValueError, match="replicates must be >= 2, got 1"):
        simulate(window_room(), [ONE], [1], replicates=1)
    lamps = VisibilityMapCache(scenes.cornell_box(), MapSettings(n_startup=10))
    with pytest.raises(ValueError, match="lit by its environment alone"):
        simulate(lamps, [ONE], [1])
