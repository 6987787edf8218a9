"""sampling/distribution.h: indices with given probabilities."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

from core import testing
from sampling.chi_square import p_value

Distribution = testing.Distribution1D
weights_strategy = arrays(
    np.float64, st.integers(1, 40), elements=st.one_of(st.just(0.0), st.floats(1e-6, 1e6))
).filter(lambda w: w.sum() > 0)
LAST = np.nextafter(1.0, 0.0)


@given(weights=weights_strategy, u=st.lists(st.floats(0, LAST), min_size=1, max_size=20))
def test_an_index_of_weight_zero_is_never_chosen(weights, u):
    distribution = Distribution(weights)
    index, pmf, rest = distribution.sample(np.array([*u, 0.0, LAST]))
    assert (weights[index] > 0).all()
    assert (pmf > 0).all()
    assert pmf.tolist() == [distribution.pmf(int(i)) for i in index]
    assert (rest >= 0).all() and (rest < 1).all()


@given(weights=weights_strategy)
def test_probabilities_are_the_shares_of_the_weights(weights):
    distribution = Distribution(weights)
    pmf = np.array([distribution.pmf(i) for i in range(len(distribution))])
    assert pmf == pytest.approx(weights / weights.sum(), rel=1e-6, abs=1e-12)
    assert distribution.total == pytest.approx(weights.sum())


@pytest.mark.extreme
@pytest.mark.parametrize("n", [3, 7, 49, 1000])
def test_numbers_beside_a_boundary_find_their_side_of_it(n):
    """u·n may round up to an integer while u·total stays below the boundary."""
    weights = np.where(np.arange(n) % 3 == 1, 0.0, np.random.default_rng(n).random(n) + 0.1)
    distribution = Distribution(weights)
    edges = np.concatenate([np.arange(1, n) / n, np.cumsum(weights)[:-1] / weights.sum()])
    u = np.concatenate([np.nextafter(edges, 0), edges, np.nextafter(edges, 1)])
    index, _, rest = distribution.sample(u)
    assert rest.min() >= 0 and rest.max() < 1
    assert (weights[index] > 0).all()
    cumulative = np.concatenate([[0], np.cumsum(weights)])
    assert (cumulative[index] <= u * distribution.total).all()
    assert (u * distribution.total < cumulative[index + 1]).all()


@pytest.mark.stat
def test_indices_follow_the_weights_and_the_rest_is_uniform():
    weights = np.random.default_rng(1).random(50) ** 3
    weights[[0, 7, 49]] = 0
    index, _, rest = Distribution(weights).sample(np.random.default_rng(2).random(200_000))
    counts = np.bincount(index, minlength=50)
    assert p_value(counts, 200_000 * weights / weights.sum()) >= 1e-3
    for i in (1, 20, 48):
        assert stats.kstest(rest[index == i], "uniform").pvalue >= 1e-3 / 3
    # Negative control: other weights
    assert p_value(counts[1:7], counts[1:7].sum() * np.full(6, 1 / 6)) < 1e-6


@pytest.mark.parametrize(
    "weights", [[], [0.0, 0.0], [1.0, -1.0, 3.0], [np.nan], [np.inf, 1.0], [1e308, 1e308]]
)
def test_unusable_weights_are_refused(weights):
    with pytest.raises(ValueError, match="weights must"):
        Distribution(np.array(weights))


def test_numbers_outside_the_unit_interval_are_refused():
    with pytest.raises(ValueError, match=r"u must be in \[0, 1\), got 1"):
        Distribution(np.ones(3)).sample(np.array([1.0]))
