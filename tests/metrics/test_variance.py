"""Ratios of variances: exact in a closed form, intervals that cover, refusals."""

import numpy as np
import pytest

from viscache.base.tonemap import luminance
from viscache.metrics.variance import variance_ratio


def renders(n, sigma, seed, *, size=(6, 8)):
    """Grey images of mean 1 with independent Gaussian pixels."""
    rng = np.random.default_rng(seed)
    return [np.repeat(1 + sigma * rng.normal(size=(*size, 1)), 3, axis=2) for _ in range(n)]


def test_the_ratio_is_that_of_the_sums_of_sample_variances():
    a, b = renders(5, 1.0, 0), renders(7, 2.0, 1)
    expected = [np.var([luminance(i) for i in s], axis=0, ddof=1).sum() for s in (a, b)]
    found = variance_ratio(a, b)
    assert found.ratio == pytest.approx(expected[0] / expected[1])
    assert found.renders == (5, 7)
    assert found.gains[1] == pytest.approx(1 / found.ratio)
    assert found.gains == sorted(found.gains)
    assert found.low < found.ratio < found.high
    scaled = variance_ratio([3 * i for i in a], [3 * i for i in b])
    assert scaled.ratio == pytest.approx(found.ratio)


@pytest.mark.slow
@pytest.mark.stat
def test_the_interval_covers_the_truth_about_as_often_as_it_says():
    """200 pairs of 16 renders, true ratio 1/4; half of the interval's width covers far less."""
    hits = half = 0
    for k in range(200):
        found = variance_ratio(renders(16, 1.0, 2 * k), renders(16, 2.0, 2 * k + 1))
        hits += found.low < 0.25 < found.high
        reach = (found.high - found.low) / 4
        half += abs(found.ratio - 0.25) < reach
    assert 0.85 < hits / 200 < 0.99
    assert half / 200 < 0.8


def test_the_interval_of_two_or_three_renders_is_finite():
    for n in (2, 3):
        found = variance_ratio(renders(n, 1.0, 0), renders(n, 2.0, 1))
        assert 0.05 < found.low <= found.ratio * 1.0001
        assert found.ratio * 0.9999 <= found.high < 2


def test_draws_of_equal_renders_are_left_out_of_the_interval():
    black = np.zeros((6, 8, 3))
    found = variance_ratio(renders(4, 1.0, 0), [black, black, black, renders(1, 2.0, 1)[0]])
    assert 0 < found.low <= found.high < np.inf


def test_a_pixel_that_flares_up_is_left_out_of_the_trimmed_ratio():
    a, b = (renders(8, 1.0, k, size=(40, 50)) for k in (0, 1))
    a[0][3, 3] += 1000
    found = variance_ratio(a, b)
    assert found.ratio > 10
    assert found.trimmed == pytest.approx(1, abs=0.1)


def test_only_the_chosen_pixels_count():
    a, b = renders(8, 1.0, 0), renders(8, 1.0, 1)
    left = np.zeros((6, 8), bool)
    left[:, :4] = True
    expected = variance_ratio([i[:, :4] for i in a], [i[:, :4] for i in b])
    for image in a:
        image[:, 4:] *= 5
    found = variance_ratio(a, b, pixels=left)
    assert found.ratio == pytest.approx(expected.ratio)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high))
    assert variance_ratio(a, b).ratio > 3 * expected.ratio


def test_energy_is_about_zero_for_equal_means_and_found_otherwise():
    a, b = renders(12, 0.2, 0), renders(12, 0.2, 1)
    assert abs(variance_ratio(a, b).energy_z) < 4
    shifted = variance_ratio([i + 0.1 for i in a], b)
    assert shifted.energy == pytest.approx(0.1, abs=0.03)
    assert shifted.energy_z > 5


TWO = renders(2, 1.0, 0)


@pytest.mark.parametrize(
    ("ours", "baseline", "pixels", "says"),
    [
        (TWO[:1], TWO, None, "ours must be at least 2 renders, got 1"),
        (TWO, [np.ones((6, 8, 3))] * 2, None, "baseline must vary, got 0"),
        (TWO, renders(2, 1.0, 0, size=(5, 5)), None, "same pixels"),
        (TWO, [TWO[0], np.full((6, 8, 3), np.nan)], None, "baseline must be finite"),
        (TWO, TWO, np.zeros((6, 8), bool), "pixels must hold one pixel"),
    ],
)
def test_what_cannot_be_compared_is_refused(ours, baseline, pixels, says):
    with pytest.raises(ValueError, match=says):
        variance_ratio(ours, baseline, pixels=pixels)
