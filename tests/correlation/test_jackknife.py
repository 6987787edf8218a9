"""Statistics from integer sums, and standard errors that cover the truth."""

import itertools

import numpy as np
import pytest
from scipy.stats import t as student

from viscache.correlation.pairs import SCALE
from viscache.correlation.statistics import Sums, jackknife, statistics


def sums_of(rho, group):
    """Sums of a symmetric matrix of ρ in one bin; NaN is undefined."""
    i, j = np.triu_indices(len(rho), 1)
    q = np.rint(np.nan_to_num(rho[i, j]) * SCALE).astype(np.int64)
    defined = np.isfinite(rho[i, j])
    labels = list(itertools.combinations_with_replacement(range(group.max() + 1), 2))
    a, b = np.minimum(group[i], group[j]), np.maximum(group[i], group[j])
    own = [(a == g) & (b == h) for g, h in labels]

    def cells(values):
        return np.array([values[pairs].sum() for pairs in own])[:, None, None]

    return Sums(
        n=cells(defined.astype(np.int64)),
        n_undefined=cells((~defined).astype(np.int64)),
        q=cells(q * defined),
        q2=np.array([[sum(int(v) ** 2 for v in q[defined])]], dtype=object),
        first=np.array([g for g, _ in labels]),
        second=np.array([h for _, h in labels]),
    )


def draw(rng, groups=16, points=10):
    """Pairs whose points share a point effect, a group effect, and noise; their true mean."""
    group = np.repeat(np.arange(groups), points)
    shared = rng.normal(0, 0.05, groups)[group] + rng.normal(0, 0.05, len(group))
    rho = 0.3 + shared[:, None] + shared[None] + rng.normal(0, 0.1, (len(group), len(group)))
    return sums_of(np.clip(rho, -1, 1), group), 0.3


def test_mean_sigma_and_naive_error_are_those_of_the_pairs():
    rng = np.random.default_rng(0)
    rho = np.rint(rng.uniform(-1, 1, (24, 24)) * SCALE) / SCALE
    rho[3] = rho[:, 3] = np.nan
    sums = sums_of(rho, np.repeat(np.arange(4), 6))
    pairs = rho[np.triu_indices(24, 1)]
    known = pairs[np.isfinite(pairs)]
    found = statistics(sums)
    assert found.n.item() == known.size == 253 and found.n_undefined.item() == 23
    assert found.mean.item() == pytest.approx(known.mean(), rel=1e-13)
    assert found.sigma.item() == pytest.approx(known.std(), rel=1e-13)
    assert found.mean_square.item() == pytest.approx((known**2).mean(), rel=1e-13)
    assert found.se_naive.item() == pytest.approx(known.std() / np.sqrt(known.size), rel=1e-13)


def test_sigma_of_nearly_equal_values_does_not_cancel():
    rho = np.full((300, 300), 1.0)
    rho[0, 1] = 1.0 - 1 / SCALE
    n = 300 * 299 / 2
    found = statistics(sums_of(rho, np.zeros(300, int)))
    assert found.sigma.item() == pytest.approx(np.sqrt((n - 1) / n**2) / SCALE, rel=1e-12)


def test_the_jackknife_leaves_out_every_pair_with_an_end_in_the_group():
    rng = np.random.default_rng(1)
    rho = np.rint(rng.uniform(-1, 1, (20, 20)) * SCALE) / SCALE
    group = np.sort(rng.integers(0, 5, 20))
    means = []
    for g in range(5):
        left = rho[np.ix_(group != g, group != g)]
        means.append(left[np.triu_indices(len(left), 1)].mean())
    expected = np.sqrt(4 / 5 * ((np.array(means) - np.mean(means)) ** 2).sum())
    assert jackknife(sums_of(rho, group)).item() == pytest.approx(expected, rel=1e-10)


def test_no_error_is_claimed_where_it_cannot_be_known():
    rho = np.zeros((4, 4))
    assert np.isnan(jackknife(sums_of(rho, np.zeros(4, int))).item())
    # Without group 0 no pair is left
    assert np.isnan(jackknife(sums_of(rho[:2, :2], np.array([0, 1]))).item())
    empty = statistics(sums_of(np.full((4, 4), np.nan), np.array([0, 0, 1, 1])))
    assert empty.n.item() == 0 and empty.n_undefined.item() == 6
    assert all(np.isnan(getattr(empty, v).item()) for v in ("mean", "sigma", "se", "se_naive"))


@pytest.mark.slow
@pytest.mark.stat
def test_the_jackknife_covers_the_truth_and_the_naive_error_does_not():
    rng = np.random.default_rng(2)
    factor = student.ppf(0.975, 15)
    covered = {"se": 0, "se_naive": 0}
    for _ in range(200):
        sums, truth = draw(rng)
        found = statistics(sums)
        for name in covered:
            miss = abs(found.mean.item() - truth)
            covered[name] += miss <= factor * getattr(found, name).item()
    assert 0.88 * 200 <= covered["se"] <= 0.99 * 200
    assert covered["se_naive"] < 0.5 * 200
