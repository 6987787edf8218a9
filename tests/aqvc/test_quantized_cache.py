"""The quantized cache as a whole: limits, invariance, edge cases."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aqvc import tiles
from reference import aqvc as reference
from viscache import _core

FORMS = [
    {"form": "waves"},
    {"form": "pairs"},
    {"form": "pairs", "storage": "exact", "batch": 1},
    {"form": "waves", "normal_mode": "octahedral"},
    {"form": "waves", "normal_mode": "single"},
    {"form": "pairs", "queue": 64},
]
EXACT_KINDS = ["point", "directional", "vpl", "ambient"]


def block(kind, count=12, *, eyes=None, exact=False, **options):
    """Visible bits, counters and wanted bits of a block."""
    eyes = eyes or tiles.eye_points()
    far = tiles.lights(kind, count)
    wanted = tiles.facing(eyes, far)
    visible, counters = tiles.tile_run(eyes, **options).block(far, wanted, exact=exact)
    return visible, counters, wanted


@pytest.mark.parametrize("form", FORMS, ids=str)
@pytest.mark.parametrize("kind", EXACT_KINDS)
@pytest.mark.parametrize("c_e", [1e-3, 1e-9])
def test_tiny_clusters_give_the_exact_bits_with_one_ray_per_query(form, kind, c_e):
    visible, counters, wanted = block(kind, c_e=c_e, **form)
    np.testing.assert_array_equal(visible, block(kind, exact=True)[0])
    assert counters["rays"] == counters["queries"] == wanted.sum()
    assert (counters["clamped_high"] > 0) == (c_e < 1e-6)


@pytest.mark.parametrize("form", FORMS, ids=str)
@pytest.mark.parametrize("kind", [*EXACT_KINDS, "area", "environment"])
def test_answers_stay_within_what_was_asked_and_counts_add_up(form, kind):
    visible, c, wanted = block(kind, c_e=10, **form)
    assert not (visible & ~wanted).any()
    group = c["groups"][tiles.GROUPS[kind]]
    assert group["queries"] == wanted.sum()
    assert group["occluded"] == wanted.sum() - visible.sum()
    assert group["rays"] == c["rays"] == sum(c["rays_per_level"]) + c["leftover_rays"]
    assert c["hits"] <= c["lookups"] and c["bypassed"] == 0


@pytest.mark.parametrize("kind", ["vpl", "environment", "area"])
def test_lights_that_share_a_cell_share_a_column(kind):
    options = {"c_e": 10, "vpl_key": "surface"}
    exact = block(kind, 60, exact=True)[0]
    waves, c, wanted = block(kind, 60, **options)
    pairs, c2, _ = block(kind, 60, form="pairs", **options)
    error, error2 = (waves != exact).sum(), (pairs != exact).sum()
    assert 0.5 < error / error2 < 2 and 0.5 < c["rays"] / c2["rays"] < 2
    point_keys = block(kind, 60, c_e=10)[1]["rays"]
    assert c["rays"] < point_keys if kind == "vpl" else c["rays"] == point_keys
    assert c["queries"] == wanted.sum()


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_the_same_tile_gives_the_same_answers_again(form):
    eyes, far = tiles.eye_points(), tiles.lights("point")
    wanted = tiles.facing(eyes, far)
    run = tiles.tile_run(eyes, c_e=10, **form)
    visible, counters = run.block(far, wanted)
    run.begin_tile()
    again, counters2 = run.block(far, wanted)
    np.testing.assert_array_equal(visible, again)
    assert counters == counters2


@pytest.mark.stat
@pytest.mark.parametrize("density", [50.0, 400.0])
def test_random_samples_fill_cells_as_poisson_says(density):
    """Distinct cells per cell area = 1 − e^(−D w²); mean occupation tends to C_E²."""
    rng = np.random.default_rng(1)
    side, c_e = 6.0, 5.0
    n = rng.poisson(density * side * side)
    x = rng.uniform(-side / 2, side / 2, (n, 3)).astype(np.float32)
    x[:, 1] = 0
    up = np.tile(np.float32([0, 1, 0]), (n, 1))
    r = _core.aqvc.resolution_eye(density, c_e, 7.5)
    keys = _core.aqvc.full_keys(
        _core.aqvc.AqvcParameters(), (0, 0, 0), 7.5, x, up, np.full(n, r), 0, x * 0, up, np.ones(n)
    )[0]
    width = 15.0 / keys[0, 7]
    # Whole cells inside the square only.
    v, count = np.unique(keys[:, 4:6], axis=0, return_counts=True)
    inner = ((v > v.min(0)) & (v < v.max(0))).all(1)
    cells = int(np.prod(v.max(0) - v.min(0) - 1))
    share = 1 - np.exp(-density * width**2)
    sigma = np.sqrt(share * (1 - share) / cells)
    assert inner.sum() / cells == pytest.approx(share, abs=3 * sigma + 1e-9)
    assert count[inner].mean() == pytest.approx(c_e**2, rel=0.2)


@pytest.mark.extreme
@pytest.mark.parametrize("form", FORMS, ids=str)
@pytest.mark.parametrize("c_e", [1e4, 1e30])
def test_huge_clusters_are_one_cell_per_normal_bin_and_slab(form, c_e):
    visible, c, wanted = block("point", c_e=c_e, refinement="off", **form)
    assert 0 < c["rays"] < 0.1 * wanted.sum() and c["clamped_low"] > 0
    assert not (visible & ~wanted).any()


@pytest.mark.extreme
@pytest.mark.parametrize("form", FORMS[:2], ids=str)
def test_densities_of_far_ends_out_of_range_are_counted(form):
    eyes = tiles.eye_points()
    far = tiles.lights("area", 12)
    wanted = tiles.facing(eyes, far)
    counts = []
    for density in (far["density"], np.full(12, np.nan, np.float32)):
        run = tiles.tile_run(eyes, c_e=8, **form)
        counts.append(run.block({**far, "density": density}, wanted)[1]["clamped_nan"])
    assert counts[0] == 0 < counts[1]


@pytest.mark.extreme
@pytest.mark.parametrize("form", FORMS, ids=str)
@pytest.mark.parametrize("density", [0.0, np.nan, np.inf, -1.0, 1e30, 1e-30])
def test_densities_out_of_range_are_answered_and_counted(form, density):
    eyes = tiles.eye_points(12, 12)
    eyes["density"][::3] = density
    visible, c, wanted = block("point", eyes=eyes, c_e=1.5, **form)
    assert c["queries"] == wanted.sum() and not (visible & ~wanted).any()
    assert (c["clamped_nan"] > 0) == (not density >= 0)
    assert (c["clamped_low"] > 0) == (0 <= density < 1e-9)
    assert (c["clamped_high"] > 0) == (density >= 1e30)


@pytest.mark.extreme
@pytest.mark.parametrize("form", FORMS, ids=str)
def test_eye_points_without_normal_bypass_the_cache_and_are_exact(form):
    eyes, far = tiles.eye_points(12, 12), tiles.lights("point")
    wanted = tiles.facing(eyes, far)
    eyes["normal"][5:20] = 0
    run = tiles.tile_run(eyes, c_e=8, **form)
    visible, c = run.block(far, wanted)
    exact, _ = run.block(far, wanted, exact=True)
    np.testing.assert_array_equal(visible[5:20], exact[5:20])
    assert c["bypassed"] == wanted[5:20].sum() > 0


@pytest.mark.extreme
@pytest.mark.parametrize("form", FORMS, ids=str)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e17])
def test_ends_that_are_not_finite_get_no_ray(form, bad):
    eyes, far = tiles.eye_points(12, 12), tiles.lights("point")
    wanted = tiles.facing(eyes, far)
    good, _ = tiles.tile_run(eyes, c_e=1e-3, **form).block(far, wanted)
    eyes["position"][7], far["far"][3] = bad, (bad, 0, 1)
    visible, c = tiles.tile_run(eyes, c_e=1e-3, **form).block(far, wanted)
    touched = np.zeros_like(wanted)
    touched[7], touched[:, 3] = True, True
    assert not visible[touched].any()
    np.testing.assert_array_equal(visible[~touched], good[~touched])
    assert c["bypassed"] == (wanted & touched).sum()
    assert c["rays"] == (wanted & ~touched).sum()


@pytest.mark.extreme
@pytest.mark.parametrize("form", FORMS, ids=str)
def test_empty_tiles_and_blocks_are_answered(form):
    eyes, far = tiles.eye_points(8, 8), tiles.lights("point")
    run = tiles.tile_run(eyes, **form)
    visible, c = run.block(far, np.zeros((len(eyes["density"]), 8), bool))
    assert not visible.any() and c["rays"] == c["queries"] == 0
    none = {k: v[:0] if isinstance(v, np.ndarray) else v for k, v in far.items()}
    assert run.block(none, np.zeros((len(eyes["density"]), 0), bool))[1]["rays"] == 0
    empty = {k: v[:0] if isinstance(v, np.ndarray | list) else v for k, v in eyes.items()}
    assert tiles.tile_run(empty, **form).block(far, np.zeros((0, 8), bool))[1]["rays"] == 0


def test_refinement_follows_the_light_group_and_the_samples_per_pixel():
    """Auto: shared lights only, with clusters larger than a pixel or the finest level's."""
    p = _core.aqvc.AqvcParameters(c_e=16, c_e_groups={"vpl": 9})
    assert [len(p.level_list(g)) for g in range(8)] == [2, 2, 1, 1, 2, 1, 1, 1]
    assert p.level_list(0) == [16, 4] and p.level_list(4) == [9, 4]
    assert len(p.level_list(0, spp=256)) == len(p.level_list(0, spp=255)) == 2
    small = _core.aqvc.AqvcParameters(c_e=3)
    assert small.level_list(0, spp=9, lift=2) == [6]
    assert small.level_list(0, spp=8, lift=2) == [6, 4]


def test_refinement_can_be_set_for_single_light_groups():
    own = {"point": "off", "area": "on", "vpl": "auto"}
    p = _core.aqvc.AqvcParameters(c_e=16, refinement=own)
    assert [len(p.level_list(g)) for g in range(8)] == [1, 2, 2, 1, 2, 1, 1, 1]
    assert p.refinement == {"point": "off", "area": "on"}
    q = _core.aqvc.AqvcParameters(c_e=16, refinement="on")
    assert [len(q.level_list(g)) for g in range(8)] == [2] * 8 and q.refinement == "on"
    with pytest.raises(ValueError, match="refinement must be one of auto, on, off, got yes"):
        p.refinement = {"point": "yes"}
    with pytest.raises(ValueError, match="c_e_groups must be of light groups, got lamp"):
        p.c_e_groups = {"lamp": 3}


@given(
    c_e=st.floats(0.01, 1e4),
    step=st.sampled_from([1.6, 2.0, 3.0, 4.0, 10.0]),
    finest=st.floats(0.05, 100),
    lift=st.sampled_from([1.0, 2.0]),
)
def test_a_larger_c_e_only_puts_levels_in_front(c_e, step, finest, lift):
    options = {"level_step": step, "c_finest": finest, "refinement": "on"}
    levels = _core.aqvc.AqvcParameters(c_e=c_e, **options).level_list(0, lift=lift)
    want = reference.level_list(lift * c_e, step, finest)
    np.testing.assert_allclose(levels, want, rtol=1e-12)
    assert levels[-1] == min(lift * c_e, finest)
    kept = _core.aqvc.AqvcParameters(c_e=0.7 * c_e, **options).level_list(0, lift=lift)[1:]
    assert kept == (levels[-len(kept) :] if kept else [])


def test_many_levels_leave_out_the_coarsest_but_the_first():
    levels = _core.aqvc.AqvcParameters(c_e=1e6, level_step=1.1).level_list(0)
    assert len(levels) == 32 and levels[0] == 1e6 and levels[-1] == 4
    np.testing.assert_allclose(levels[1], 4 * 1.1**30)


@pytest.mark.parametrize(("c_e", "count"), [(1, 1), (2, 1), (4, 2), (12, 4), (16, 4), (17, 5)])
def test_the_papers_levels_number_log2_c_e(c_e, count):
    """Alg. 2: C_MSR = max(1, ⌈log2 C_E⌉); the finest cell spans 1 to 2 samples."""
    p = _core.aqvc.AqvcParameters(c_e=c_e, c_finest="log2", level_step=2)
    levels = p.level_list(0)
    assert len(levels) == count and (c_e <= 1 or 1 < levels[-1] <= 2)
