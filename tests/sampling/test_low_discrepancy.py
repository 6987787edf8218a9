"""sampling/low_discrepancy.h: the scrambled (0, 2)-sequence and radical inverses."""

from fractions import Fraction

import numpy as np
import pytest
from scipy import stats

from core import testing

SEEDS = [(0, 0), (1, 2), (0xFFFFFFFF, 0x80000000), (0x12345678, 0x9ABCDEF0)]


def is_net(points, m):
    """Whether each elementary interval of area 2^-m holds exactly one of 2^m points."""
    for k in range(m + 1):
        cell = (points[:, 0] * 2**k).astype(int) * 2 ** (m - k) + (
            points[:, 1] * 2 ** (m - k)
        ).astype(int)
        if not np.array_equal(np.sort(cell), np.arange(2**m)):
            return False
    return True


@pytest.mark.parametrize("seeds", SEEDS)
@pytest.mark.parametrize("m", [0, 1, 4, 7, 10])
def test_every_aligned_run_is_a_net(seeds, m):
    for run in (0, 1, 5, 12345):
        index = (np.arange(2**m) + run * 2**m).astype(np.uint32)
        assert is_net(testing.sobol02(index, *seeds), m)


def test_random_points_are_not_a_net():
    """Negative control."""
    assert not is_net(np.random.default_rng(0).random((128, 2), dtype=np.float32), 7)


def test_points_stay_below_one():
    rng = np.random.default_rng(3)
    index = np.concatenate([np.arange(1 << 16), 2**32 - 1 - np.arange(1 << 16)]).astype(np.uint32)
    for seeds in rng.integers(0, 2**32, (16, 2)):
        points = testing.sobol02(index, int(seeds[0]), int(seeds[1]))
        assert points.min() >= 0 and points.max() < 1


@pytest.mark.stat
def test_over_seeds_each_point_is_uniform():
    rng = np.random.default_rng(4)
    for index in (0, 1, 7, 100):
        seeds = rng.integers(0, 2**32, (4096, 2))
        points = np.array([testing.sobol02(np.array([index]), int(a), int(b))[0] for a, b in seeds])
        cell = (points[:, 0] * 16).astype(int) * 16 + (points[:, 1] * 16).astype(int)
        assert stats.chisquare(np.bincount(cell, minlength=256)).pvalue >= 1e-3 / 4


@pytest.mark.stat
def test_sequences_of_different_seeds_are_uncorrelated():
    index = np.arange(16, dtype=np.uint32)
    seeds = np.random.default_rng(5).integers(0, 2**32, (2048, 4))
    a = np.array([testing.sobol02(index, int(s[0]), int(s[1])) for s in seeds])
    b = np.array([testing.sobol02(index, int(s[2]), int(s[3])) for s in seeds])
    # Points of one net are stratified, so 2048 independent nets are the sample size
    assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 4 / np.sqrt(2048)


@pytest.mark.parametrize("base", [2, 3, 5, 29])
def test_radical_inverse_mirrors_the_digits(base):
    for i in [0, 1, 2, 3, 10, 12345, 2**40 + 17]:
        expected, digit, rest = Fraction(0), Fraction(1, base), i
        while rest:
            expected, digit, rest = expected + rest % base * digit, digit / base, rest // base
        assert testing.radical_inverse(base, i) == pytest.approx(float(expected), rel=1e-14)


def test_radical_inverse_stays_below_one():
    for base in (2, 3, 7):
        power = base
        while power * base < 2**64:
            power *= base
        assert testing.radical_inverse(base, power - 1) < 1
        assert testing.radical_inverse(base, 2**64 - 1) < 1


def test_radical_inverse_refuses_bases_below_two():
    with pytest.raises(ValueError, match="base must be >= 2, got 1"):
        testing.radical_inverse(1, 3)
