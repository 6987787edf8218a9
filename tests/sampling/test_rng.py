"""sampling/rng.h: counter-based random numbers."""

import numpy as np
import pytest
from scipy import stats

from core import testing

MASK = (1 << 64) - 1
N_KEYS = 1 << 14


def mix64(x):
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & MASK
    return x ^ (x >> 31)


def transcription(seed, purpose, pixel, pass_, count):
    k = mix64((seed + 0x9E3779B97F4A7C15) & MASK)
    k = mix64(k ^ mix64((purpose + 0xD1B54A32D192ED03) & MASK))
    k = mix64(k ^ mix64((pixel + 0x8CB92BA72F3D8DD7) & MASK))
    state = mix64(k ^ mix64((pass_ + 0xABC98388FB8FAC03) & MASK))
    step = mix64(state ^ 0x2545F4914F6CDD1D) | 1
    return [mix64((state + (i + 1) * step) & MASK) >> 32 for i in range(count)]


def keys(vary, n=N_KEYS):
    """Keys (7, 3, 5, 2) with component `vary` counting from zero (purposes from 0 to 10)."""
    k = np.tile(np.array([7, 3, 5, 2], dtype=np.uint64), (n, 1))
    k[:, vary] = np.arange(n)
    return k


def test_streams_are_the_same_bits_everywhere():
    for key in [(0, 0, 0, 0), (1, 2, 3, 4), (MASK, 10, MASK, MASK), (1 << 40, 5, 1 << 33, 99)]:
        got = testing.random_u32(np.array([key], dtype=np.uint64), 5)[0]
        assert got.tolist() == transcription(*key, 5)


def test_floats_are_the_upper_24_bits():
    bits = testing.random_u32(keys(2), 8)
    floats = testing.random(keys(2), 8)
    assert np.array_equal(floats, (bits >> 8).astype(np.float32) * np.float32(2.0**-24))
    assert floats.min() >= 0 and floats.max() < 1


def uniformity(values, bins=256):
    return float(
        stats.chisquare(np.bincount((values.ravel() * bins).astype(int), minlength=bins)).pvalue
    )


def pair_uniformity(a, b, bins=32):
    cell = (a.ravel() * bins).astype(int) * bins + (b.ravel() * bins).astype(int)
    return float(stats.chisquare(np.bincount(cell, minlength=bins * bins)).pvalue)


@pytest.mark.stat
@pytest.mark.parametrize("vary", [0, 2, 3], ids=["seed", "pixel", "pass"])
def test_streams_of_neighbouring_keys_are_uniform_and_uncorrelated(vary):
    values = testing.random(keys(vary), 8)
    for draw in range(8):
        assert uniformity(values[:, draw]) >= 1e-3 / 24
    assert pair_uniformity(values[:-1], values[1:]) >= 1e-3 / 6  # across keys
    assert pair_uniformity(values[:, :-1], values[:, 1:]) >= 1e-3 / 6  # along streams
    for lag in (1, 2, 64, 1024):
        r = np.corrcoef(values[:-lag].ravel(), values[lag:].ravel())[0, 1]
        assert abs(r) < 4 / np.sqrt(values.size)


@pytest.mark.stat
def test_streams_of_different_purposes_are_uncorrelated():
    k = keys(2, 4096)
    values = []
    for purpose in range(11):
        k[:, 1] = purpose
        values.append(testing.random(k, 4).ravel())
    r = np.corrcoef(values) - np.eye(11)
    assert np.abs(r).max() < 4.5 / np.sqrt(values[0].size)


@pytest.mark.stat
def test_every_bit_is_set_half_of_the_time():
    bits = testing.random_u32(keys(2), 8).ravel()
    share = [np.mean((bits >> b) & 1) for b in range(32)]
    assert np.abs(np.array(share) - 0.5).max() < 4 * 0.5 / np.sqrt(bits.size)


@pytest.mark.stat
def test_a_poor_generator_is_found():
    """Negative controls: a counter without mixing, and a stream a few percent off uniform."""
    counter = ((np.arange(N_KEYS) * 2654435761) % 2**32 / 2**32).astype(np.float32)
    assert pair_uniformity(counter[:-1], counter[1:]) < 1e-6
    good = testing.random(keys(2), 8)
    assert uniformity(good ** np.float32(1.07)) < 1e-6
    assert np.corrcoef(good.ravel(), good.ravel())[0, 1] > 4 / np.sqrt(good.size)


def test_keys_must_have_four_columns():
    with pytest.raises(ValueError, match=r"keys must have shape \(N, 4\), got \(2, 3\)"):
        testing.random(np.zeros((2, 3), dtype=np.uint64), 1)
