"""vismap/control_variate.h, point_estimate.h: unbiased, and better where visibility correlates."""

import numpy as np
import pytest

from core import testing
from viscache._core import AlphaMode, PointSet
from viscache._core.vismap import EnvironmentPyramid, PointEstimate, points
from vismap.analytic import EDGE, Pixel, exact, world
from vismap.worlds import blended, coarser, dilations, directions, luminance, shares

K, MOST = 4, 1.5


def alpha_of(z, w, var_w):
    """Section 5.2 in NumPy: rows of samples, both less μ_W."""
    n = z.shape[-1]
    c = (z * w).sum(-1) - z.sum(-1) * w.sum(-1) / n
    q = (w * w).sum(-1) - w.sum(-1) ** 2 / n
    return np.clip((c + K * var_w) / (q + K * var_w), 0, MOST)


def leave_one_out(z, w, var_w):
    """Mean of z − α_{−i} w over every row; z and w less μ_W."""
    n = z.shape[-1]
    total = np.zeros(len(z))
    for i in range(n):
        rest = np.arange(n) != i
        total += z[:, i] - alpha_of(z[:, rest], w[:, rest], var_w) * w[:, i]
    return total / n


def rows_of_samples(made, pixel, kind, n, replicates, seed=0):
    """z·V, w (replicates, n), and the texels."""
    point = made.estimate(pixel)
    u = np.concatenate([points(kind, n, pixel=r, seed=seed) for r in range(replicates)])
    s = point.sample(u)
    z = s["z"] * pixel.visible.ravel()[s["texel"]]
    shape = (replicates, n)
    return point, z.reshape(shape), s["w"].reshape(shape), s["texel"].reshape(shape)


def pooled_z(errors):
    """z of the sum of all pixels' mean errors, and the largest |z| of one pixel."""
    means = np.array([e.mean() for e in errors])
    sigma = np.array([e.std(ddof=1) / np.sqrt(len(e)) for e in errors])
    return float(means.sum() / np.sqrt((sigma**2).sum())), float(np.abs(means / sigma).max())


def test_equations_are_those_of_the_paper():
    rng = np.random.default_rng(3)
    z, w = rng.normal(size=(2, 50_000))
    w = 0.6 * z + 0.8 * w
    var_z, var_w, cov = z.var(), w.var(), np.cov(z, w, ddof=0)[0, 1]
    for alpha in (0.0, 0.3, 1.0, 1.7):
        expected = (z - alpha * w).var()
        assert testing.residual_variance(var_z, var_w, cov, alpha) == pytest.approx(expected, 1e-9)
        got = testing.control_variate_estimate(z.sum(), w.sum(), 0.25, alpha, len(z))
        assert got == pytest.approx((z - alpha * w).mean() + alpha * 0.25, abs=1e-12)
    best = testing.best_alpha(var_w, cov)
    rho = testing.correlation(var_z, var_w, cov)
    assert rho == pytest.approx(np.corrcoef(z, w)[0, 1], 1e-12)
    least = testing.least_residual_variance(var_z, rho)
    assert least == pytest.approx((z - best * w).var(), 1e-9)
    assert all((z - (best + e) * w).var() > least for e in (-0.01, 0.01))
    assert testing.product_terms(0.8, 1, 0.3, 0.5) == (1.6, 0.6)
    assert testing.product_terms(0.8, 0, 0.3) == (0, 0.3)
    assert testing.best_alpha(0, 0) == testing.correlation(0, 1, 0) == 0


def test_alpha_is_the_regression_with_a_prior():
    rng = np.random.default_rng(5)
    for n in (1, 2, 10, 100):
        z, w = rng.normal(size=(2, 1, n))
        z += 0.4 * w
        expected = alpha_of(z, w, 0.7)[0]
        assert testing.regressed_alpha(z[0], w[0], 0.7) == pytest.approx(expected, rel=1e-12)
    assert testing.regressed_alpha(z[0], w[0], 0.0) == 0
    assert testing.regressed_alpha(9 * w[0], w[0], 0.1) == MOST
    assert testing.regressed_alpha(-9 * w[0], w[0], 0.1) == 0


@pytest.mark.parametrize("eta", [1.0, 0.5, 0.25, 0.01])
@pytest.mark.parametrize("what", ["true", "random", "full", "empty", "inverted"])
def test_the_exact_expectation_is_the_integral_whatever_the_records_hold(what, eta):
    made = world("courtyard")
    rng = np.random.default_rng(8)
    for pixel in made.pixels[:6]:
        maps = {
            "true": pixel.maps,
            "random": rng.random(pixel.maps.shape) < 0.3,
            "full": np.ones_like(pixel.maps),
            "empty": np.zeros_like(pixel.maps),
            "inverted": ~pixel.maps,
        }[what]
        pixel = Pixel(pixel.b, pixel.visible, maps, pixel.beta, dilations(maps))
        point = made.estimate(pixel, eta)
        assert point.guided == (eta < 1 and what != "empty")
        sums = exact(made, pixel, point)
        assert sums.p.sum() == pytest.approx(1, rel=1e-12)
        for alpha in (0.0, 1.0, 1.7):
            y = np.where(sums.p > 0, sums.f - alpha * sums.g, 0).sum() + alpha * point.j_luminance
            assert y == pytest.approx(sums.truth, rel=1e-12)
        assert (sums.p[sums.f > 0] > 0).all()
        # What is drawn are the terms of these sums
        s = point.sample(points(PointSet.INDEPENDENT, 2000, seed=2))
        at = s["texel"]
        p = sums.p.ravel()[at]
        light = luminance(made.light).ravel()[at] * (4 * np.pi / EDGE**2)
        f = light * luminance(pixel.b).ravel()[at] / p
        np.testing.assert_allclose(luminance(s["f"]), f, rtol=1e-9)
        np.testing.assert_allclose(luminance(s["g"]), sums.g.ravel()[at] / p, rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(s["z"] * point.l_ns, luminance(s["f"]), rtol=1e-12)


@pytest.mark.stat
def test_what_is_biased_is_found_out():
    """Negative controls: α from the very samples, leave-one-out of even points, shifted cells."""
    made = world("courtyard")
    same, loo_even, shifted, control = [], [], [], []
    for pixel in made.pixels[:24]:
        point, z, w, texel = rows_of_samples(made, pixel, PointSet.ZERO_TWO, 10, 1500)
        truth = exact(made, pixel, point).truth / point.l_ns
        zc, wc = z - point.mean_w, w - point.mean_w
        loo_even.append(leave_one_out(zc, wc, point.variance_w) + point.mean_w - truth)
        point, z, w, texel = rows_of_samples(made, pixel, PointSet.INDEPENDENT, 10, 1500)
        zc, wc = z - point.mean_w, w - point.mean_w
        alpha = alpha_of(zc, wc, 1e-3 * point.variance_w + 1e-9)
        same.append(z.mean(1) - alpha * wc.mean(1) - truth)
        control.append(leave_one_out(zc, wc, point.variance_w) + point.mean_w - truth)
        moved = np.roll(blended(pixel.maps, pixel.beta, EDGE), 4, axis=1).ravel()[texel]
        shifted.append((z - moved).mean(1) + point.mean_w - truth)
    together, worst = pooled_z(control)
    assert abs(together) < 3.3 and worst < 4.5
    for biased in (same, loo_even, shifted):
        assert pooled_z(biased)[1] > 4.5


def test_leave_one_out_is_its_slow_transcription():
    made = world("courtyard")
    pixel = made.pixels[2]
    point, z, w, _ = rows_of_samples(made, pixel, PointSet.INDEPENDENT, 12, 50, seed=4)
    slow = leave_one_out(z - point.mean_w, w - point.mean_w, point.variance_w) + point.mean_w
    fast = point.simulate(pixel.visible, n=12, replicates=50, mode=AlphaMode.LEAVE_ONE_OUT, seed=4)
    np.testing.assert_allclose(luminance(fast)[:, 0], slow * point.l_ns, rtol=1e-6)
    with pytest.raises(ValueError, match="independent points"):
        point.simulate(pixel.visible, n=12, mode=AlphaMode.LEAVE_ONE_OUT, set=PointSet.ZERO_TWO)


def test_previous_pass_regresses_on_all_passes_before():
    made = world("courtyard")
    pixel = made.pixels[5]
    point = made.estimate(pixel)
    got = luminance(
        point.simulate(pixel.visible, n=16, passes=3, mode=AlphaMode.PREVIOUS_PASS, seed=9)
    )[0]
    zs, ws = np.zeros((2, 0))
    for pass_ in range(3):
        s = point.sample(points(PointSet.INDEPENDENT, 16, seed=9, pass_=pass_))
        z, w = s["z"] * pixel.visible.ravel()[s["texel"]] - point.mean_w, s["w"] - point.mean_w
        alpha = alpha_of(zs, ws, point.variance_w) if len(zs) else 1.0
        expected = (z.mean() - alpha * w.mean() + point.mean_w) * point.l_ns
        assert got[pass_] == pytest.approx(expected, rel=1e-6)
        zs, ws = np.append(zs, z), np.append(ws, w)


@pytest.mark.stat
@pytest.mark.parametrize("eta", [1.0, 0.25])
def test_the_variance_of_independent_samples_is_the_exact_sum(eta):
    made, n, replicates = world("courtyard"), 16, 4000
    scores = []
    for i, pixel in enumerate(made.pixels[:12]):
        point = made.estimate(pixel, eta)
        sums = exact(made, pixel, point)
        for alpha in (0.0, 1.0):
            found = luminance(
                point.simulate(pixel.visible, n=n, replicates=replicates, alpha=alpha, seed=i)
            )[:, 0]
            d = (found - sums.truth) ** 2
            scores.append((d.mean() - sums.variance(alpha) / n) / (d.std() / np.sqrt(replicates)))
    assert np.abs(scores).max() < 4.5 and abs(np.mean(scores)) < 3.3 / np.sqrt(len(scores))


@pytest.mark.parametrize("eta", [1.0, 0.25])
def test_in_a_furnace_maps_that_know_everything_leave_no_variance(eta):
    """Light 1 on albedo 1, nothing in the way, Ṽ = V and B̃ = B: every estimate is one."""
    cosine = coarser(np.maximum(directions(EDGE)[..., 2].astype(np.float64), 0), 32) / 16
    seen = cosine > 1e-2
    b, visible = (np.kron(a, np.ones((4, 4))) for a in (cosine / np.pi * seen, seen))
    table = np.repeat(b[..., None], 3, axis=-1).astype(np.float32)
    light, one = EnvironmentPyramid(np.ones((EDGE, EDGE, 3), np.float32)), np.ones(1, np.float32)

    def found(maps, kind):
        point = PointEstimate(light, table, maps, one, dilated=dilations(maps), eta=eta)
        args = {"n": 8, "passes": 2, "replicates": 200, "alpha": 1.0, "set": kind}
        return luminance(point.simulate(visible.astype(bool), **args))

    exact_value = b.sum() * 4 * np.pi / EDGE**2
    assert exact_value == pytest.approx(1, rel=1e-3)
    for kind in (PointSet.INDEPENDENT, PointSet.ZERO_TWO):
        np.testing.assert_allclose(found(seen[None], kind), exact_value, rtol=1e-6)
    # With one cell of the maps wrong they scatter
    wrong = seen[None].copy()
    wrong[0, 16, 16] ^= True
    assert found(wrong, PointSet.INDEPENDENT).std() > 1e-4


@pytest.mark.slow
@pytest.mark.stat
def test_the_gain_is_the_same_for_any_number_of_independent_samples_and_shrinks_for_even_ones():
    """Eq. 4 knows no N; even points take what is smooth from the baseline too (Table 3)."""
    made, samples, batches = world("courtyard"), (4, 10, 30, 100, 300), 12
    slopes = {}
    for kind in (PointSet.INDEPENDENT, PointSet.ZERO_TWO):
        squares = np.zeros((2, len(samples), batches))
        for i, pixel in enumerate(made.pixels):
            point = made.estimate(pixel)
            truth = exact(made, pixel, point).truth
            for row, alpha in enumerate((1.0, 0.0)):
                for column, n in enumerate(samples):
                    found = luminance(
                        point.simulate(
                            pixel.visible,
                            n=n,
                            replicates=batches * 16,
                            set=kind,
                            alpha=alpha,
                            seed=1000 * n + i,
                        )
                    )
                    squares[row, column] += ((found[:, 0] - truth) ** 2).reshape(batches, -1).sum(1)
        ratios = squares[0] / squares[1]
        slopes[kind] = np.polyfit(np.log(samples), np.log(ratios), 1)[0]
        if kind == PointSet.INDEPENDENT:
            sums = [exact(made, p, made.estimate(p)) for p in made.pixels]
            expected = sum(s.variance(1) for s in sums) / sum(s.variance(0) for s in sums)
            mean, error = ratios.mean(1), ratios.std(1, ddof=1) / np.sqrt(batches)
            assert (np.abs(mean - expected) < 4 * error + 0.01 * expected).all()
    t = {kind: s.mean() / (s.std(ddof=1) / np.sqrt(batches)) for kind, s in slopes.items()}
    assert abs(t[PointSet.INDEPENDENT]) < 3.5
    # The trend is there, and this test can see one
    assert t[PointSet.ZERO_TWO] > 5 and slopes[PointSet.ZERO_TWO].mean() > 0.02


def test_degenerate_maps_and_lights():
    made = world("courtyard")
    pixel = made.pixels[0]
    blocked = np.zeros_like(pixel.maps)
    for maps in (blocked, np.ones_like(pixel.maps)):
        point = made.estimate(pixel, maps=maps)
        assert point.variance_w == pytest.approx(0, abs=1e-12)
        args = {"n": 20, "replicates": 5, "seed": 3}
        found = point.simulate(pixel.visible, mode=AlphaMode.PREVIOUS_PASS, **args)
        zero = point.simulate(pixel.visible, alpha=0.0, **args)
        np.testing.assert_array_equal(found, zero)
    # A sun behind a wrong bit
    light = made.light.copy()
    light[tuple(np.argwhere(pixel.visible)[100])] = 1e6
    sun, grown = EnvironmentPyramid(light), dilations(blocked)
    point = PointEstimate(sun, pixel.b, blocked, pixel.beta, dilated=grown, eta=0.25)
    found = point.simulate(pixel.visible, n=30, passes=3, mode=AlphaMode.PREVIOUS_PASS)
    assert np.isfinite(found).all()
    black = EnvironmentPyramid(np.zeros((EDGE, EDGE, 3), np.float32))
    point = PointEstimate(black, pixel.b, pixel.maps, pixel.beta)
    assert point.l_ns == 0 and point.j == [0, 0, 0]
    assert not point.simulate(pixel.visible, n=5).any()
    none = PointEstimate(made.pyramid, pixel.b, pixel.maps[:0], shares(1)[:0])
    assert none.variance_w == 0 and none.j == [0, 0, 0]
    for mode in (AlphaMode.FIXED, AlphaMode.LEAVE_ONE_OUT, AlphaMode.PREVIOUS_PASS):
        got = none.simulate(pixel.visible, n=8, mode=mode, seed=1)
        np.testing.assert_array_equal(got, none.simulate(pixel.visible, n=8, alpha=0.0, seed=1))
