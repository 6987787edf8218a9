"""n11: and, popcount, add in every instruction set."""

import numpy as np
import pytest

from reference.isas import AVAILABLE
from reference.vismap import packed
from viscache import _core
from viscache.correlation import pairs


def brute_force(a, b):
    return a.astype(np.int64) @ b.astype(np.int64).T


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("n_directions", [1, 63, 64, 65, 128, 129, 500, 513, 4097, 9216])
def test_counts_equal_brute_force(isa, n_directions):
    random = np.random.default_rng(n_directions)
    a = random.random((37, n_directions)) < random.random((37, 1))
    b = random.random((50, n_directions)) < random.random((50, 1))
    # Rows of zeros, ones, one bit, the last bits alone, and a patch
    for rows in (a, b):
        rows[0], rows[1], rows[2], rows[3] = 0, 1, 0, 0
        rows[2, n_directions // 2] = 1
        rows[3, -3:] = 1
        rows[4, : n_directions // 2] = 0
    found = pairs.intersections(packed(a), packed(b), isa=isa)
    np.testing.assert_array_equal(found, brute_force(a, b))


@pytest.mark.parametrize("isa", AVAILABLE)
def test_every_bit_counts_once(isa):
    """A wrong carry, a missed word or a unit skipped by mistake shows at some single bit."""
    one = np.eye(1280, dtype=bool)
    full = np.ones((3, 1280), bool)
    found = pairs.intersections(packed(one), packed(full), isa=isa)
    np.testing.assert_array_equal(found, np.ones((1280, 3)))
    np.testing.assert_array_equal(
        pairs.intersections(packed(one), packed(one), isa=isa), np.eye(1280)
    )


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("skip_dead", [True, False])
def test_totals_are_those_of_the_columns(isa, skip_dead):
    """Σ n11 over all pairs = Σ over directions of (rows of a that see it)·(rows of b)."""
    random = np.random.default_rng(0)
    a, b = random.random((400, 700)) < 0.3, random.random((333, 700)) < 0.6
    a[100:200, :512] = 0
    total = _core.correlation.total_intersections(
        packed(a), packed(b), isa=isa, skip_dead=skip_dead
    )
    assert total == int(a.sum(0) @ b.sum(0))


def test_phi_is_the_correlation_of_numpy():
    random = np.random.default_rng(3)
    rows = random.random((60, 900)) < random.random((60, 1))
    rows[7] = rows[5]
    rows[8] = ~rows[5]
    rho = pairs.phi(packed(rows[:20]), packed(rows), 900)
    expected = np.corrcoef(rows.astype(float))[:20]
    np.testing.assert_allclose(rho, expected, atol=1e-6)
    assert rho[5, 7] == 1 and rho[5, 8] == -1
    # Words that are no multiple of 8, all of them directions
    words = np.ascontiguousarray(packed(rows)[9:14, :3])
    expected = np.corrcoef(rows[9:14, :192].astype(float))
    np.testing.assert_allclose(pairs.phi(words, words, 192), expected, atol=1e-6)


def test_phi_is_undefined_where_all_bits_are_equal():
    rows = np.zeros((3, 100), bool)
    rows[1], rows[2, :50] = 1, 1
    rho = pairs.phi(packed(rows), packed(rows), 100)
    assert np.isnan(rho[:2]).all() and np.isnan(rho[:, :2]).all() and rho[2, 2] == 1


def test_rows_of_other_lengths_are_refused():
    a, b = np.zeros((2, 3), np.uint64), np.zeros((2, 4), np.uint64)
    with pytest.raises(ValueError, match=r"same length, got \(2, 3\) and \(2, 4\)"):
        pairs.intersections(a, b)
    with pytest.raises(ValueError, match="bits_a must be uint64, got"):
        pairs.intersections(a.astype(np.int64), b)
    with pytest.raises(ValueError, match="n_directions must be a whole number in"):
        pairs.phi(a, a, 193)
    with pytest.raises(ValueError, match="isa must be portable, avx2 or avx512, and this CPU"):
        pairs.intersections(a, a, isa="sse9")
    with pytest.raises(ValueError, match="at most 725 words a row, got 800"):
        pairs.intersections(np.zeros((1, 800), np.uint64), np.zeros((1, 800), np.uint64))


def test_no_rows_have_no_pairs():
    none, some = np.zeros((0, 2), np.uint64), np.zeros((5, 2), np.uint64)
    assert pairs.intersections(none, some).shape == (0, 5)
    assert pairs.intersections(some, none).shape == (5, 0)
