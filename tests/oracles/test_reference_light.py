"""Shares of corrections follow what a wrong answer would do to the picture."""

import numpy as np
import pytest

import viscache as vc
from oracles.slats import slats
from viscache import _core

SIZE, CERTAIN = (48, 48), 0.25
CACHE = vc.Aqvc(c_e=16, exact_groups=())
#: The mean over the picture comes from a smaller one.
NEAR = 1.15


def hall(roughness):
    """A grey floor, diffuse or with a lobe, below lamps of very different power."""
    rng = np.random.default_rng(7)
    lamps = [
        ((rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5), rng.uniform(0.8, 2.5)), 4.0 ** (k % 4))
        for k in range(64)
    ]
    look = {"base_color": (0.2, 0.2, 0.2)}
    if roughness is not None:
        lobe = {"specular": (0.3,) * 3, "roughness": roughness}
        look |= {"kind": _core.MaterialKind.GLOSSY, **lobe}
    return slats(lamps, **look)


def checked(scene):
    """Contributions (N, M), what the cache answers, and 1/q where a check changed it, else 0."""
    asked = vc.connections(scene, vc.Direct(), size=SIZE)
    c = asked.contributions("point").astype(np.float64).mean(axis=2)
    cached = np.asarray(asked.answers(CACHE)["point"], float)
    found = asked.answers(CACHE, use=vc.Correct(certain=CERTAIN))["point"]
    weight = np.where(found.visible, found.weights, 0).astype(np.float64)
    return c, cached, np.where(c > 0, np.abs(weight - cached), 0)


@pytest.mark.parametrize("roughness", [None, 0.15], ids=["diffuse", "lobe"])
def test_shares_count_from_the_light_that_the_cache_sees(roughness):
    """q = 2^-h where c is below h of certain·R, certain·R/2, …: R = min(√(a·(b + m/20)), m)."""
    c, cached, inverse = checked(hall(roughness))
    changed = inverse > 0
    assert changed.sum() > 2000
    h = np.log2(inverse, where=changed, out=np.zeros_like(inverse))
    np.testing.assert_array_equal(h, np.round(h))
    a, b = c.sum(axis=1), (c * cached).sum(axis=1)
    m = a.sum() / (SIZE[0] * SIZE[1])

    def agrees(contributions, reference):
        """Share of the changed answers whose h follows, up to the noise of m."""
        next_bound = CERTAIN * reference[:, None] * 2.0**-h
        below = (contributions <= 2 * next_bound * NEAR) | (h == 0)
        above = (contributions > next_bound / NEAR) | (h == 8)
        return float((below & above)[changed].mean())

    reference = np.minimum(np.sqrt(a * (b + m / 20)), m)
    assert agrees(c, reference) > 0.999
    # Negative controls: other references, and contributions without the lobe
    assert agrees(c, a) < 0.95
    assert agrees(c, np.full_like(b, m)) < 0.95
    if roughness is not None:
        diffuse, _, _ = checked(hall(None))
        assert agrees(diffuse, reference) < 0.9


def test_lobes_add_no_rare_large_noise():
    """The noise of a frame's corrections is not that of a few pixels."""
    scene = hall(0.05)
    exact = vc.render(scene, vc.Direct(), size=SIZE).image
    squares = np.zeros(SIZE[0] * SIZE[1])
    for seed in range(8):
        use = vc.Correct(certain=2.0)
        same = vc.render(scene, vc.Direct(), size=SIZE, seed=seed).image
        frame = vc.render(scene, vc.Direct(), size=SIZE, seed=seed, visibility=CACHE, use=use)
        squares += np.square(frame.image - same).mean(axis=2).ravel()
    largest = np.sort(squares)[::-1]
    assert largest[:10].sum() < 0.5 * largest.sum()
    assert largest.sum() > 1e-6 * np.square(exact).sum()
