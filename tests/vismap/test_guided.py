"""vismap/guided_density.h: records shape the density, and nothing they hold can bias it."""

import numpy as np
import pytest

from sampling.chi_square import p_value
from viscache._core import AlphaMode, PointSet
from viscache._core.vismap import EnvironmentPyramid, PointEstimate, points
from vismap.analytic import EDGE, Exact, Pixel, exact, world
from vismap.worlds import blended, cosine_lobe, dilations, luminance, shares, sky

RNG = np.random.default_rng(17)
SINGLE = np.zeros((1, 32, 32), bool)
SINGLE[0, 17, 9] = True
MAPS = {
    "random": RNG.random((4, 32, 32)) < 0.4,
    "empty": np.zeros((2, 32, 32), bool),
    "full": np.ones((2, 32, 32), bool),
    "single": SINGLE,
    "64": RNG.random((3, 64, 64)) < 0.1,
}


def point_of(name, eta, light=None):
    maps = MAPS[name]
    return PointEstimate(
        EnvironmentPyramid(sky(EDGE, sun=1e6) if light is None else light),
        cosine_lobe(EDGE),
        maps,
        shares(len(maps)),
        dilated=dilations(maps),
        eta=eta,
    )


@pytest.mark.parametrize("eta", [0.5, 0.25, 0.01])
@pytest.mark.parametrize("name", MAPS)
def test_the_density_is_normalised_and_never_far_below_product_sampling(name, eta):
    plain, guided = point_of(name, 1.0), point_of(name, eta)
    p, d = guided.probabilities(), guided.density()
    assert p.sum() == pytest.approx(1, rel=1e-12)
    assert (d >= (eta if guided.guided else 1)).all()
    assert (p >= eta * plain.probabilities() * (1 - 1e-15)).all()
    assert guided.guided == (name != "empty")


def test_maps_that_say_nothing_are_product_sampling():
    u = points(PointSet.ZERO_TWO, 500)
    plain, guided = (point_of("empty", eta).sample(u) for eta in (1.0, 0.25))
    assert all(np.array_equal(plain[key], guided[key]) for key in plain)
    np.testing.assert_allclose(point_of("full", 0.25).sample(u)["d"], 1, rtol=1e-7)


def test_samples_are_as_frequent_as_the_guided_density():
    light = sky(EDGE, sun=2e3)
    point, n = point_of("single", 0.25, light), 400_000
    s = point.sample(points(PointSet.INDEPENDENT, n))
    counts, expected = np.bincount(s["texel"], minlength=EDGE**2), n * point.probabilities().ravel()
    assert not counts[expected == 0].any()
    assert p_value(counts, expected) > 1e-4
    plain = n * point_of("single", 1.0, light).probabilities().ravel()
    assert p_value(counts, plain) < 1e-9, "the density of product sampling is another one"
    np.testing.assert_array_equal(s["d"], point.density().ravel()[s["texel"]])


def test_guided_even_points_are_even():
    """Counts of 64 points in the quarters of the map scatter far less than by chance."""
    point = point_of("64", 0.25, sky(EDGE))
    share = point.probabilities().reshape(2, EDGE // 2, 2, EDGE // 2).sum(axis=(1, 3)).ravel()
    scatter = []
    for kind in (PointSet.INDEPENDENT, PointSet.ZERO_TWO):
        u = np.concatenate([points(kind, 64, pixel=i) for i in range(2000)])
        texel = point.sample(u)["texel"]
        quarter = (texel // EDGE // (EDGE // 2) * 2 + texel % EDGE // (EDGE // 2)).reshape(2000, 64)
        counts = np.stack([(quarter == q).sum(axis=1) for q in range(4)], axis=1)
        np.testing.assert_allclose(counts.mean(axis=0), 64 * share, atol=0.5)
        scatter.append((counts.var(axis=0) / (64 * share * (1 - share)))[share > 0.05].max())
    assert 0.85 < scatter[0] < 1.15 and scatter[1] < 0.2


def sums_of(made, pixel, eta):
    plain, guided = made.estimate(pixel), made.estimate(pixel, eta)
    return exact(made, pixel, plain), exact(made, pixel, guided), guided


def test_the_density_of_one_component_fails_the_exact_sum():
    """Negative control: dividing by the density of the chosen component is not unbiased."""
    made = world("room")
    wrong = []
    for pixel in made.pixels[:10]:
        plain, guided, _ = sums_of(made, pixel, 0.25)
        mixture = np.where(guided.p > 0, guided.f, 0).sum()
        assert mixture == pytest.approx(guided.truth, rel=1e-12)
        part = (guided.p - 0.25 * plain.p) / 0.75
        with np.errstate(divide="ignore", invalid="ignore"):
            chosen = np.where(part > 1e-18, guided.f * guided.p / part, 0).sum()
        wrong.append(abs(chosen / guided.truth - 1))
    assert min(wrong) > 1e-3


@pytest.mark.parametrize("eta", [0.5, 0.25, 0.1])
@pytest.mark.parametrize("name", ["room", "courtyard"])
def test_the_variance_is_bounded_at_every_pixel(name, eta):
    made = world(name)
    rng = np.random.default_rng(4)
    for i, pixel in enumerate(made.pixels):
        if i % 2:  # records that are as wrong as can be
            maps = rng.random(pixel.maps.shape) < 0.1
            pixel = Pixel(pixel.b, pixel.visible, maps, pixel.beta, dilations(maps))
        plain, guided, _ = sums_of(made, pixel, eta)
        bound = plain.variance(0) / eta + plain.truth**2 * (1 / eta - 1)
        assert guided.variance(0) <= bound * (1 + 1e-9)


def raw_density(point, pixel, plain, eta):
    """The maps themselves as density: what dilation is there to prevent."""
    seen = blended(pixel.maps, pixel.beta, EDGE)
    mu = (plain.p * seen).sum()
    d = eta + (1 - eta) * seen / mu if mu > 1e-9 else np.ones_like(seen)
    return Exact(plain.p * d, plain.f, plain.g)


def test_maps_that_are_not_grown_are_worse_than_no_guiding():
    """Negative control: at η = 0.1 the window's border arrives with weight ten."""
    made = world("room", pixels=120)
    raw = base = 0.0
    for pixel in made.pixels:
        plain, _, point = sums_of(made, pixel, 0.25)
        sums = raw_density(point, pixel, plain, 0.1)
        raw, base = raw + sums.variance(sums.best_alpha), base + plain.variance(0)
    assert raw / base > 1


def error_ratio(made, n, replicates, **plainly):
    """Mean squared error of guided even points over that of plain ones, in the third pass."""
    args = {"n": n, "passes": 3, "replicates": replicates, "set": PointSet.ZERO_TWO}
    steady = {"mode": AlphaMode.PREVIOUS_PASS}
    guided = plain = 0.0
    for i, pixel in enumerate(made.pixels):
        _, sums, point = sums_of(made, pixel, 0.25)
        found = luminance(point.simulate(pixel.visible, seed=i, **args, **steady))[:, -1]
        guided += ((found - sums.truth) ** 2).mean()
        other = made.estimate(pixel).simulate(pixel.visible, seed=i, **args, **(plainly or steady))
        plain += ((luminance(other)[:, -1] - sums.truth) ** 2).mean()
    return guided / plain


@pytest.mark.slow
@pytest.mark.stat
def test_the_merged_warp_keeps_the_points_even():
    """Under even points guiding costs nothing in the open: one tree, one warp, no split square."""
    assert error_ratio(world("garden", records=100, pixels=20), 64, 80) < 1.1


@pytest.mark.stat
@pytest.mark.parametrize("n", [10, 30])
def test_in_a_room_guiding_gains_under_even_points_too(n):
    assert error_ratio(world("room", pixels=60), n, 40, alpha=0.0) < 1 / 15
