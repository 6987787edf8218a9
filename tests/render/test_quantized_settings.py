"""Settings of the quantized cache in whole frames: presets, counters, light groups, densities."""

from __future__ import annotations

import numpy as np
import pytest

import viscache as vc
from render import quantized as q

PAPER = {
    "c_n": 8,
    "c_z": 8.0,
    "c_l": 1.0,
    "c_r": 1.2,
    "normal_mode": "round",
    "grid_offset": True,
    "tangent_neighbours": True,
    "env_rule": "derived",
    "vpl_key": "surface",
    "refinement": "on",
    "c_finest": "log2",
    "level_step": 2.0,
    "hash": "scheme2",
    "digest_bits": 31,
    "table_bytes": 4 << 20,
    "order": "hm",
    "c_pg": 3.7,
    "form": "pairs",
    "storage": "table",
    "batch": 1,
}
PRESETS = {
    "default": PAPER
    | {"c_z": 4.0, "vpl_key": "point", "refinement": "auto"}
    | {"level_step": 4.0, "c_finest": 4.0, "form": "waves", "batch": 0},
    "paper": PAPER,
    "as_printed": PAPER
    | {"normal_mode": "floor", "grid_offset": False, "tangent_neighbours": False}
    | {"hash": "scheme1", "env_rule": "printed"},
}


@pytest.mark.parametrize("preset", PRESETS)
def test_presets_resolve_to_their_lists_and_run(preset):
    """Names, values, and a frame of all light groups."""
    settings = vc.Aqvc(preset=preset, c_e=8)
    assert settings.resolved() | PRESETS[preset] == settings.resolved()
    scene = q.lit_box().with_environment(0.5)
    integrator = vc.Whitted(n_vpls=12, n_area=4, n_environment=2, n_brdf=2)
    frame = q.render(scene, integrator, preset=preset, c_e=8)
    exact = q.exact(scene, integrator)
    assert q.rel_l1(frame.image, exact.image) < 0.15
    assert frame.counters["ray_reduction"] > 2
    assert len(frame.counters["rays_per_level"]) == (2 if preset == "default" else 3)
    used = frame.parameters["visibility"]
    assert used | PRESETS[preset] | {"preset": preset, "c_e": 8} == used


def test_a_parameter_given_explicitly_wins_over_the_preset():
    given = vc.PaperForm(grid_offset=True, batch=0)
    settings = vc.Aqvc(preset="as_printed", c_z=3, paper=given)
    assert settings.resolved()["c_z"] == 3 and settings.resolved()["grid_offset"] is True
    assert settings.resolved()["batch"] == 0 and settings.resolved()["normal_mode"] == "floor"
    same = {"form": "pairs", "batch": 1, "refinement": "on", "c_finest": "log2", "level_step": 2}
    given = q.render(q.lit_box(), c_e=8, c_z=8, vpl_key="surface", **same)
    assert given.sha256 == q.render(q.lit_box(), preset="paper", c_e=8).sha256
    assert given.sha256 != q.render(q.lit_box(), preset="paper", c_e=8, c_z=4).sha256


COUNTERS = (
    *("queries", "occluded", "rays", "ray_reduction", "groups", "camera_rays", "light_rays"),
    *("rays_per_level", "leftover_rays", "lookups", "hits", "neighbour_probes", "nil_neighbours"),
    *("evictions", "bypassed", "clamped_low", "clamped_high", "clamped_nan", "boundary_queries"),
    *("cells", "table_writes", "table_slots", "expected_false_hits", "non_finite", "vpls"),
    "lost_throughput",
)


@pytest.mark.parametrize("refinement", ["off", "on"])
@pytest.mark.parametrize("form", q.FORMS)
def test_counters_are_present_finite_and_add_up(form, refinement):
    """Counters for every form and light group."""
    scene = q.lit_box().with_environment(0.5)
    integrator = vc.Whitted(n_vpls=12, n_area=4, n_environment=2, n_brdf=2)
    c = q.render(scene, integrator, c_e=8, refinement=refinement, **q.FORMS[form]).counters
    exact = q.exact(scene, integrator).counters
    assert set(COUNTERS) <= set(c)
    assert set(c["groups"]) == {"point", "directional", "area", "environment", "vpl"}
    flat = [c[n] for n in COUNTERS if n not in ("groups", "rays_per_level")] + c["rays_per_level"]
    assert all(np.isfinite(value) and value >= 0 for value in flat)
    for name in ("queries", "occluded", "rays"):
        assert c[name] == sum(group[name] for group in c["groups"].values())
    for name, group in c["groups"].items():
        assert group["queries"] == exact["groups"][name]["queries"]
        assert 0 < group["rays"] <= group["queries"] >= group["occluded"]
    assert c["ray_reduction"] == pytest.approx(c["queries"] / c["rays"])
    assert sum(c["rays_per_level"]) + c["leftover_rays"] + c["bypassed"] == c["rays"]
    assert c["hits"] <= c["lookups"] and c["nil_neighbours"] <= c["neighbour_probes"]
    assert c["clamped_high"] == c["clamped_nan"] == c["bypassed"] == c["non_finite"] == 0
    assert (0 < c["table_writes"] <= c["rays"]) == form.startswith("pairs")
    assert (c["table_slots"] > 0) == (form == "pairs-table")
    assert (c["leftover_rays"] > 0) <= (form == "waves")
    if refinement == "off":
        # Samples of one eye point in one light cell are one look-up, but in the table
        assert (c["lookups"] == c["queries"]) == form.startswith("pairs")
        assert c["lookups"] <= c["queries"] and len(c["rays_per_level"]) == 1
        assert c["boundary_queries"] == c["neighbour_probes"] == 0
    else:
        assert c["lookups"] > c["queries"] and c["boundary_queries"] > 0


@pytest.mark.parametrize("group", ["point", "directional", "area", "environment", "vpl"])
def test_c_e_of_a_light_group_changes_that_group_alone(group):
    """c_e_groups: rays and error are told per group by `counters` and `layers`."""
    scene = q.lit_box().with_environment(0.5)
    integrator = vc.Whitted(n_vpls=12, n_area=8, n_environment=4, n_brdf=4)
    exact = q.exact(scene, integrator).layers
    whole = q.render(scene, integrator, c_e=12)
    frame = q.render(scene, integrator, c_e=12, c_e_groups={group: 2.0})
    for name, counts in frame.counters["groups"].items():
        before = whole.counters["groups"][name]
        if name != group:
            assert counts == before
            np.testing.assert_array_equal(frame.layers[name], whole.layers[name])
            continue
        assert counts["rays"] > 1.5 * before["rays"]
        finer = q.rel_l1(frame.layers[name], exact[name])
        assert finer < q.rel_l1(whole.layers[name], exact[name])
