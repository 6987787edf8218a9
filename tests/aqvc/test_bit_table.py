"""The lossy table: AQVC Sec. 4.1."""

import numpy as np
import pytest

from core import testing


def random_keys(n, seed=1):
    return np.random.default_rng(seed).integers(0, 2**20, (n, 15)).astype(np.int32)


def test_a_table_gives_back_what_was_put_and_nothing_else():
    table = testing.BitTable(10007)
    keys, bits = random_keys(20), np.arange(20) % 3 == 0
    assert (table.get(keys) == -1).all()
    table.put(keys, bits)
    np.testing.assert_array_equal(table.get(keys), bits)
    assert (table.get(random_keys(20, seed=2)) == -1).all()
    table.clear()
    assert (table.get(keys) == -1).all() and table.occupied == 0


@pytest.mark.extreme
def test_a_table_of_one_slot_holds_the_last_key():
    table = testing.BitTable(1)
    keys = random_keys(5)
    for i in range(5):
        counts = table.put(keys[i : i + 1], [True])
        assert counts["evictions"] == (i > 0)
        assert (table.get(keys) >= 0).tolist() == [j == i for j in range(5)]


@pytest.mark.extreme
def test_one_bit_digests_work_and_are_never_empty():
    """Digest 0 is stored as 1, so half of the keys do not vanish."""
    table = testing.BitTable(10007, 1)
    keys = random_keys(200)
    table.put(keys, np.zeros(200, bool))
    assert (table.get(keys) == 0).sum() > 190


def test_sizes_are_primes():
    """κ mod a prime: low bits of κ do not decide alone."""
    assert [testing.largest_prime(n) for n in (0, 1, 2, 4, 100, 2**20)] == [1, 1, 2, 3, 97, 1048573]


def test_occupancy_follows_the_number_of_writes():
    """1 − e^(−n/C_T)."""
    table = testing.BitTable(testing.largest_prime(2**14))
    table.put(random_keys(2**14), np.ones(2**14, bool))
    assert table.occupied / table.slots == pytest.approx(1 - np.exp(-1), abs=0.01)
