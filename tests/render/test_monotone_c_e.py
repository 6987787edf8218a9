"""C_E is a knob: with a larger one rays fall and the error rises, and neither turns back."""

from itertools import combinations

import numpy as np
import pytest
from scipy import stats

import viscache as vc
from render import quantized as q

LAMPS = vc.Direct()
VPLS = vc.Whitted(n_vpls=24)
#: Scene, its parameters, and an integrator whose lights all pixels share.
CASES = {
    "room": ("room", {"triangles": 4000, "lights": 8}, LAMPS),
    "apartment": ("apartment", {"triangles": 10000}, VPLS),
    "conference": ("conference", {"triangles": 10000}, VPLS),
}
FEW = (2.0, 4.0, 6.0, 7.0, 8.0, 16.0, 28.0, 32.0, 64.0)
MANY = tuple(float(c) for c in np.geomspace(2, 64, 13))


def list_ends_at_c_finest(c_e):
    """The default."""
    return {"c_e": c_e}


def list_ends_where_division_ends(c_e):
    """The rule until version 0.1: below 2·c_finest there is one level, below 32 there are two."""
    if c_e < 8:
        return {"c_e": c_e, "refinement": "off"}
    return {"c_e": c_e, "c_finest": max(4.0, c_e / 4)}


def coarse_alone_below_a_pixel(c_e):
    """The rule for 64 samples per pixel until version 0.1: no refinement if C_E² <= 64."""
    return {"c_e": c_e, "refinement": "off" if c_e <= 8 else "on"}


def trade(name, rule, c_es, seeds, size=(96, 96), spp=1, **aqvc):
    """Logarithms of error and of queries per ray, by C_E and seed of samples and grid."""
    scene, parameters, integrator = CASES[name]
    made = q.scene(scene, **parameters)
    found = np.empty((2, len(c_es), seeds))
    for s in range(seeds):
        exact = vc.render(made, integrator, seed=s, size=size, spp=spp).image
        for i, c_e in enumerate(c_es):
            given = rule(c_e) | aqvc | {"grid_seed": s + 1, "spp": spp}
            frame = q.render(made, integrator, seed=s, size=size, **given)
            found[0, i, s] = np.log(q.rel_l1(frame.image, exact))
            found[1, i, s] = np.log(frame.counters["ray_reduction"])
    return found[0], found[1]


def turned_back(logs, c_es, confidence=0.99):
    """Pairs of C_E whose larger one has the smaller mean, beyond the noise over seeds.

    The noise is what remains of the logarithms after the means by C_E and by seed. The confidence
    holds for all pairs together.
    """
    n, seeds = logs.shape
    rest = logs - logs.mean(1, keepdims=True) - logs.mean(0) + logs.mean()
    freedom = (n - 1) * (seeds - 1)
    noise = np.sqrt((rest**2).sum() / freedom * 2 / seeds)
    pairs = list(combinations(range(n), 2))
    bound = noise * stats.t.ppf(confidence ** (1 / len(pairs)), freedom)
    mean = logs.mean(1)
    return [
        f"{c_es[i]:.4g} to {c_es[j]:.4g}: {np.expm1(mean[j] - mean[i]):+.1%}, noise {noise:.1%}"
        for i, j in pairs
        if mean[j] - mean[i] < -bound
    ]


def assert_monotone(name, c_es, seeds, **options):
    """Neither error nor reduction turns back, and over the whole range both rise."""
    for logs in trade(name, list_ends_at_c_finest, c_es, seeds, **options):
        assert turned_back(logs, c_es) == []
        assert logs.mean(1)[-1] > logs.mean(1)[0] + np.log(1.3)


def test_error_and_reduction_do_not_turn_back():
    assert_monotone("room", FEW, seeds=8)


def test_a_list_that_ends_where_division_ends_turns_back():
    """The negative control: C_E 7 errs more than 8, for it has no level of 4 eye samples."""
    error, reduction = trade("room", list_ends_where_division_ends, FEW, 8)
    for logs in (error, reduction):
        assert any(pair.startswith("7 to 8:") for pair in turned_back(logs, FEW))


def test_clusters_smaller_than_a_pixel_do_not_turn_it_back():
    """C_E = 8 is a pixel here. The control refines larger clusters only."""
    c_es = (6.0, 8.0, 8.1)
    many = {"size": (20, 20), "spp": 64}
    for logs in trade("room", list_ends_at_c_finest, c_es, 4, **many):
        assert turned_back(logs, c_es) == []
    for logs in trade("room", coarse_alone_below_a_pixel, c_es, 4, **many):
        assert any(pair.startswith("8 to 8.1:") for pair in turned_back(logs, c_es))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "preset"),
    [
        pytest.param(name, preset, marks=() if name == short else pytest.mark.release)
        for preset, short in (("default", "apartment"), ("fast", "room"))
        for name in CASES
    ],
)
def test_error_and_reduction_do_not_turn_back_in_fine_steps(name, preset):
    assert_monotone(name, MANY, seeds=6, size=(128, 128), preset=preset)
