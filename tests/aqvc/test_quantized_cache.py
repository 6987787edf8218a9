"""The quantized cache as a whole: limits, invariance, edge cases."""

import hashlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aqvc import tiles
from reference import aqvc as reference
from reference.every_isa import ISAS, printed_by
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


def block(kind, count=12, *, eyes=None, exact=False, scene=None, **options):
    """Visible bits, counters and wanted bits of a block."""
    scene = scene or {}
    eyes = eyes or tiles.eye_points(**scene)
    far = tiles.lights(kind, count, **scene)
    wanted = tiles.facing(eyes, far)
    visible, counters = tiles.tile_run(eyes, **scene, **options).block(far, wanted, exact=exact)
    return visible, counters, wanted


@pytest.mark.parametrize("form", FORMS, ids=str)
@pytest.mark.parametrize("kind", EXACT_KINDS)
@pytest.mark.parametrize("c_e", [1e-3, 1e-9])
def test_tiny_clusters_give_the_exact_bits_with_one_ray_per_query(form, kind, c_e):
    """C_E → 0, folded keys included."""
    visible, counters, wanted = block(kind, c_e=c_e, **form)
    np.testing.assert_array_equal(visible, block(kind, exact=True)[0])
    assert counters["rays"] == counters["queries"] == wanted.sum()
    assert (counters["clamped_high"] > 0) == (c_e < 1e-6)


@pytest.mark.parametrize("form", FORMS, ids=str)
@pytest.mark.parametrize("c_e", [1e-3, 1e-9])
def test_tiny_clusters_are_exact_where_cells_are_scale_free(form, c_e):
    """And no clamp: R has no upper end there."""
    visible, counters, wanted = block("point", c_e=c_e, scale_free=True, **form)
    np.testing.assert_array_equal(visible, block("point", exact=True)[0])
    assert counters["rays"] == wanted.sum() and counters["clamped_high"] == 0


@pytest.mark.parametrize("form", FORMS[:2], ids=str)
def test_scale_free_cells_answer_as_well_as_those_of_the_sphere(form):
    """Rays within 15 % and errors within 40 %: other cells of the same size."""
    eyes = tiles.eye_points(64, 64)
    exact = block("point", eyes=eyes, exact=True)[0]
    found = [block("point", eyes=eyes, c_e=8, scale_free=f, **form) for f in (False, True)]
    rays = [c["rays"] for _, c, _ in found]
    errors = [(v != exact).sum() for v, _, _ in found]
    assert rays[1] == pytest.approx(rays[0], rel=0.15)
    assert errors[1] == pytest.approx(errors[0], rel=0.4)


@pytest.mark.parametrize("form", FORMS[:2], ids=str)
def test_c_e_of_one_is_not_exact(form):
    """A cell of one expected sample holds two at times."""
    _, counters, wanted = block("point", c_e=1, **form)
    assert counters["rays"] < wanted.sum()


@pytest.mark.parametrize("form", FORMS, ids=str)
@pytest.mark.parametrize("kind", [*EXACT_KINDS, "area", "environment"])
def test_answers_stay_within_what_was_asked_and_counts_add_up(form, kind):
    """A facing rejection is never cached; queries, rays and look-ups add up."""
    visible, c, wanted = block(kind, c_e=10, **form)
    assert not (visible & ~wanted).any()
    group = c["groups"][tiles.GROUPS[kind]]
    assert group["queries"] == wanted.sum()
    assert group["occluded"] == wanted.sum() - visible.sum()
    assert group["rays"] == c["rays"] == sum(c["rays_per_level"]) + c["leftover_rays"]
    assert c["hits"] <= c["lookups"] and c["bypassed"] == 0


@pytest.mark.parametrize("kind", ["vpl", "environment", "area"])
def test_lights_that_share_a_cell_share_a_column(kind):
    """Surface and solid-angle keys: fewer columns than lights, rows equal pairs within reason."""
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
    """Nothing outlives begin_tile."""
    eyes, far = tiles.eye_points(), tiles.lights("point")
    wanted = tiles.facing(eyes, far)
    run = tiles.tile_run(eyes, c_e=10, **form)
    visible, counters = run.block(far, wanted)
    run.begin_tile()
    again, counters2 = run.block(far, wanted)
    np.testing.assert_array_equal(visible, again)
    assert counters == counters2


def digest_of_all_forms():
    """One hash over the answers and counters of every form."""
    h = hashlib.sha256()
    for form in FORMS:
        visible, counters, _ = block("point", 600, eyes=tiles.eye_points(16, 16), c_e=9, **form)
        h.update(visible.tobytes() + str(counters).encode())
    return h.hexdigest()


@pytest.mark.parametrize("isa", ISAS)
def test_every_instruction_set_gives_the_same_bytes(isa):
    """Kernels of all widths."""
    got = printed_by(isa, "aqvc.test_quantized_cache", "digest_of_all_forms()")
    assert got == digest_of_all_forms()


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


@pytest.mark.stat
def test_without_refinement_the_error_grows_with_c_e():
    """Share of wrong bits, mean over shifted grids."""
    exact = block("point", exact=True)[0]
    errors = []
    for c_e in (0.5, 1, 2, 4, 8, 16):
        runs = [block("point", c_e=c_e, refinement="off", grid_seed=s)[0] for s in range(6)]
        errors.append(np.mean([(visible != exact).mean() for visible in runs]))
    assert errors == sorted(errors) and errors[0] < errors[-1] / 5


@pytest.mark.stat
def test_refinement_lowers_the_error_of_hard_shadows():
    """Sec. 3.6: same C_E, refined down to one sample, fewer wrong bits for more rays."""
    exact = block("point", exact=True)[0]
    plain, c, _ = block("point", c_e=16, refinement="off")
    refined, c2, _ = block("point", c_e=16, level_step=2, c_finest=1)
    assert (refined != exact).sum() < (plain != exact).sum() and c2["rays"] > c["rays"]


@pytest.mark.stat
def test_shifted_grids_keep_the_energy_without_refinement():
    """Mean over 24 grids of the visible share, |bias| < 3σ, one query at a time."""
    eyes = tiles.eye_points(64, 64)
    exact = block("point", exact=True, eyes=eyes)[0].sum()
    options = {"c_e": 6, "refinement": "off", "form": "pairs"}
    runs = [block("point", eyes=eyes, grid_seed=s, **options)[0] for s in range(24)]
    shares = [visible.sum() / exact for visible in runs]
    sigma = np.std(shares, ddof=1) / np.sqrt(len(shares))
    assert abs(np.mean(shares) - 1) < 3 * sigma + 0.002


@pytest.mark.extreme
@pytest.mark.parametrize("form", ["waves", "pairs"])
@pytest.mark.parametrize("scale", [1e-3, 1e3, 2.0**-20, 2.0**20])
def test_scale_does_not_matter(form, scale):
    """Ray counts within 1 %, wrong bits within 5 %, from micrometres to thousands of km."""
    exact, _, _ = block("point", exact=True)
    want, c, _ = block("point", c_e=8, form=form)
    scene = {"scale": scale}
    got, c2, _ = block("point", c_e=8, form=form, scene=scene)
    assert c2["rays"] == pytest.approx(c["rays"], rel=0.01)
    exact2 = block("point", exact=True, scene=scene)[0]
    assert (got != exact2).sum() == pytest.approx((want != exact).sum(), rel=0.05)


@pytest.mark.extreme
def test_distance_from_the_origin_does_not_matter():
    """The centre is subtracted in double; 4096 units off, float positions permitting."""
    _, c, _ = block("point", c_e=8)
    _, c2, _ = block("point", c_e=8, scene={"shift": (4096.0, -4096.0, 8192.0)})
    assert c2["rays"] == pytest.approx(c["rays"], rel=0.02)


@pytest.mark.extreme
@pytest.mark.parametrize("rungs", [38, 76, 114])
def test_a_far_ground_plane_does_not_change_the_cells(rungs):
    """B_R (here ×1e3, ×1e6, ×1e9) only shifts the ladder; beyond R_max keys fold."""
    eyes = tiles.eye_points(64, 64)
    _, c, _ = block("point", eyes=eyes, c_e=4)
    _, c2, _ = block("point", eyes=eyes, c_e=4, radius=tiles.RADIUS * 1.2**rungs)
    assert c2["rays"] == pytest.approx(c["rays"], rel=0.1)
    assert (c2["clamped_high"] > 0) == (rungs == 114)


@pytest.mark.extreme
@pytest.mark.parametrize("form", FORMS, ids=str)
@pytest.mark.parametrize("c_e", [1e4, 1e30])
def test_huge_clusters_are_one_cell_per_normal_bin_and_slab(form, c_e):
    """R = 1; few rays, all finite, counted."""
    visible, c, wanted = block("point", c_e=c_e, refinement="off", **form)
    assert 0 < c["rays"] < 0.1 * wanted.sum() and c["clamped_low"] > 0
    assert not (visible & ~wanted).any()


@pytest.mark.extreme
@pytest.mark.parametrize("form", FORMS, ids=str)
@pytest.mark.parametrize("density", [0.0, np.nan, np.inf, -1.0, 1e30, 1e-30])
def test_densities_out_of_range_are_answered_and_counted(form, density):
    """P = 0, NaN, ∞; no query is lost."""
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
    """Degenerate triangles."""
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
    """Such queries are blocked and counted as bypassed; the others do not notice."""
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
    """No eye points, no lights, nothing wanted."""
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
    """Groups without a setting of their own follow the rule."""
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


@pytest.mark.parametrize(
    ("c_e", "levels"),
    [(65, [65, 64, 16, 4]), (64, [64, 16, 4]), (36, [36, 16, 4]), (24, [24, 16, 4]),
     (16, [16, 4]), (12, [12, 4]), (8, [8, 4]), (7.9, [7.9, 4]), (4, [4]), (0.02, [0.02])],
)  # fmt: skip
def test_levels_end_at_four_eye_samples(c_e, levels):
    """The default list of C_E."""
    assert _core.aqvc.AqvcParameters(c_e=c_e).level_list(0) == levels


@given(
    c_e=st.floats(0.01, 1e4),
    step=st.sampled_from([1.6, 2.0, 3.0, 4.0, 10.0]),
    finest=st.floats(0.05, 100),
    lift=st.sampled_from([1.0, 2.0]),
)
def test_a_larger_c_e_only_puts_levels_in_front(c_e, step, finest, lift):
    """The list equals its transcription and holds all levels of every smaller C_E but its first."""
    options = {"level_step": step, "c_finest": finest, "refinement": "on"}
    levels = _core.aqvc.AqvcParameters(c_e=c_e, **options).level_list(0, lift=lift)
    want = reference.level_list(lift * c_e, step, finest)
    np.testing.assert_allclose(levels, want, rtol=1e-12)
    assert levels[-1] == min(lift * c_e, finest)
    kept = _core.aqvc.AqvcParameters(c_e=0.7 * c_e, **options).level_list(0, lift=lift)[1:]
    assert kept == (levels[-len(kept) :] if kept else [])


def test_many_levels_leave_out_the_coarsest_but_the_first():
    """A list holds 32 levels: C_E itself, and the finest ones."""
    levels = _core.aqvc.AqvcParameters(c_e=1e6, level_step=1.1).level_list(0)
    assert len(levels) == 32 and levels[0] == 1e6 and levels[-1] == 4
    np.testing.assert_allclose(levels[1], 4 * 1.1**30)


@pytest.mark.parametrize(("c_e", "count"), [(1, 1), (2, 1), (4, 2), (12, 4), (16, 4), (17, 5)])
def test_the_papers_levels_number_log2_c_e(c_e, count):
    """Alg. 2: C_MSR = max(1, ⌈log2 C_E⌉); the finest cell spans 1 to 2 samples."""
    p = _core.aqvc.AqvcParameters(c_e=c_e, c_finest="log2", level_step=2)
    levels = p.level_list(0)
    assert len(levels) == count and (c_e <= 1 or 1 < levels[-1] <= 2)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("c_n", 0, "c_n must be >= 1, got 0"),
        ("c_e", 0.0, "c_e must be > 0 and finite, got 0"),
        ("c_e", float("nan"), "c_e must be > 0 and finite, got nan"),
        ("c_r", 1.0, "c_r must be in"),
        ("c_l", 0.0, "c_l must be in"),
        ("c_l", 2000.0, "c_l must be in"),
        ("c_l", float("nan"), "c_l must be in"),
        ("digest_bits", 32, "digest_bits must be in"),
        ("hash", "md5", "hash must be one of scheme2, scheme1, scheme1_mixed, got md5"),
        ("table_bytes", 0, "table_bytes must be >= 4, got 0"),
        ("quality", 1, "no parameter quality"),
    ],
)
def test_bad_parameters_say_what_must_hold(name, value, message):
    """ValueError with what must hold and what was given."""
    with pytest.raises(ValueError, match=message):
        _core.aqvc.AqvcParameters(**{name: value})
