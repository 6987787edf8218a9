"""Correction by contribution: who is drawn, and with which weight."""

import dataclasses

import numpy as np
import pytest

import viscache as vc
from viscache.oracles.learned import unlearnt
from viscache.settings.aqvc import LIGHT_GROUPS

#: Contributions of the lights of one eye point, and their shares. Most are dim; the mean is near 2.
BANDS = np.array([0.3, 0.7, 1.5, 3, 6, 12, 24, 48, 100, 200, 400], np.float32)
SHARES = [0.5, 0.25, 0.12, 0.06, 0.04, 0.015, 0.008, 0.004, 0.0015, 0.001, 0.0005]


@pytest.fixture(scope="module")
def wall():
    """A large plane between all eye points (below) and all lights (above)."""
    corners = [[-100, -100, 0], [100, -100, 0], [100, 100, 0], [-100, 100, 0]]
    return vc.Scene.from_arrays(np.array(corners, np.float32), np.array([[0, 1, 2], [0, 2, 3]]))


def weights_of(scene, contributions, seed, shape=(0, 0)):
    """Weights of answers that are all wrong: 1, or 1 - 1/q where a query was drawn."""
    rng = np.random.default_rng(seed)
    n, m = shape if contributions is None else contributions.shape
    points = np.column_stack([rng.uniform(-1, 1, (n, 2)), np.full(n, -1)]).astype(np.float32)
    eyes = vc.EyePoints(points, np.tile(np.float32([0, 0, 1]), (n, 1)))
    ends = np.column_stack([rng.uniform(-1, 1, (m, 2)), np.full(m, 1)]).astype(np.float32)
    use = "correct" if contributions is None else vc.Correct(certain=64 / 1024)
    oracle = scene.oracle(vc.Unoccluded(), use=use, seed=seed)
    answer = oracle.block(eyes, vc.FarEnds.points(ends), contributions=contributions)
    return np.where(answer.visible, answer.weights, 0)


def lights(n, seed):
    """Contributions (n, 1024), and those over the reference where all is seen, in means."""
    rng = np.random.default_rng(seed)
    c = rng.choice(BANDS, (n, 1024), p=SHARES)
    # Exact in any order of summation: small multiples of 1/10, scaled to whole numbers
    c = np.round(c * 10).astype(np.float32)
    return c, over_reference(c, np.ones(1024, bool))


def over_reference(c, seen):
    """Contributions over min(√(a·(b + m/20)), m), times their number (reference_light.h)."""
    a = c.sum(axis=1, dtype=np.float64)
    b = c[:, seen].sum(axis=1, dtype=np.float64)
    reference = np.minimum(np.sqrt(a * (b + a.mean() / 20)), a.mean())
    return c.shape[1] * c / reference[:, None]


@pytest.mark.stat
def test_draws_of_neighbours_are_independent(wall):
    """Neighbouring bits of a word, the same bit of the next word, and the next eye point."""
    n = 4096
    c = np.full((n, 1024), 1, np.float32)  # all at the mean: h = 7
    c[:, ::16] = 6  # mean 1.3: the others in the band of h = 7, these at h = 4
    drawn = weights_of(wall, c, 5) != 1
    q = drawn.mean(axis=0)
    for first, second in (
        (drawn[:, :-16], drawn[:, 16:]),
        (drawn[:, :-64], drawn[:, 64:]),
        (drawn[:-1], drawn[1:]),
    ):
        both = np.logical_and(first, second)[:, ::16].mean()
        expected = float((q[::16] ** 2).mean())
        spread = np.sqrt(expected / first[:, ::16].size)
        assert abs(both - expected) < 5 * spread
    other = weights_of(wall, c, 6) != 1
    assert abs((drawn & other)[:, ::16].mean() - 2.0**-8) < 5 * np.sqrt(2.0**-8 / (n * 64))


def test_without_contributions_a_tenth_is_drawn(wall):
    weight = weights_of(wall, None, 0, (512, 512))
    drawn = weight != 1
    assert abs(drawn.mean() - 0.1) < 5 * np.sqrt(0.09 / drawn.size)
    np.testing.assert_allclose(weight[drawn], -9, rtol=1e-6)


class Stripes:
    """An oracle with answers of both kinds, and neighbours that agree or differ."""

    def block(self, eyes, lamps, wanted):
        return np.broadcast_to(stripes(len(lamps)), wanted.shape)


def stripes(n):
    k = np.arange(n)
    return np.where(k < n // 2, k % 2 == 0, k // 8 % 2 == 0)


@pytest.mark.stat
@pytest.mark.parametrize("truth", ["blocked", "visible"])
def test_each_class_and_band_is_drawn_with_its_share(wall, truth):
    """Answers of four classes, each with an octave of its own; behind the wall, or before it."""
    c, _ = lights(2048, 2)
    n, m = c.shape
    side = -1 if truth == "blocked" else 1
    rng = np.random.default_rng(3)
    points = np.column_stack([rng.uniform(-1, 1, (n, 2)), np.full(n, side)]).astype(np.float32)
    eyes = vc.EyePoints(points, np.tile(np.float32([0, 0, -side]), (n, 1)))
    ends = np.column_stack([rng.uniform(-1, 1, (m, 2)), np.full(m, 0.5)]).astype(np.float32)
    octaves = unlearnt()
    octaves[LIGHT_GROUPS.index("point")][:4] = [3, 0, 1, 4]
    oracle = wall.oracle(Stripes(), use=vc.Correct(certain=64 / 1024), seed=11)
    oracle._context = dataclasses.replace(oracle._context, octaves=octaves)
    answer = oracle.block(eyes, vc.FarEnds.points(ends), contributions=c)
    weight = np.where(answer.visible, answer.weights, 0)

    seen = stripes(m)
    other = np.zeros(m, bool)
    other[1:] |= seen[1:] != seen[:-1]
    other[:-1] |= seen[1:] != seen[:-1]
    k = 2 * seen + other  # the class, as nobody doubts an answer here
    octave = np.array(octaves[LIGHT_GROUPS.index("point")])[k]
    wrong = seen != (truth == "visible")
    relative = over_reference(c, seen)
    bounds = 64 * 2.0 ** (octave[:, None] - 1 - np.arange(8))
    h = (relative[..., None] <= bounds).sum(axis=-1)
    drawn = weight != seen
    assert not drawn[:, ~wrong].any()
    for one in np.unique(k[wrong]):
        for band in range(9):
            mine = (h == band) & (k == one) & wrong
            q, count = 0.5**band, int(mine.sum())
            if count * q < 100:
                continue
            spread = np.sqrt(q * (1 - q) / count)
            assert abs(drawn[mine].mean() - q) <= 4.5 * spread
            # Negative control: the octave of any other class is told apart
            if band:
                assert abs(drawn[mine].mean() - 2 * q) > 5 * spread
            want = 2.0**band if truth == "visible" else 1 - 2.0**band
            np.testing.assert_array_equal(weight[mine & drawn], np.float32(want))

    def z(weights):
        away = (weights - float(truth == "visible"))[:, wrong].sum(dtype=np.float64)
        return float(abs(away) / np.sqrt((2.0**h - 1)[:, wrong].sum()))

    assert z(weight) < 4.5
    # Negative control: one class is never checked
    for one in np.unique(k[wrong]):
        assert z(np.where(k == one, seen, weight)) > 10
