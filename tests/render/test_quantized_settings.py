"""Settings of the quantized cache and extreme inputs in whole frames; samples of eye points."""

import numpy as np
import pytest

import viscache as vc
from render import quantized as q
from viscache_lab.extremes.scenes import floor, table, with_parts


@pytest.mark.parametrize("preset", ["default", "paper", "as_printed"])
def test_presets_answer_all_groups_of_light(preset):
    """Their values are held by the bytes of tests/golden."""
    scene = q.lit_box().with_environment(0.5)
    integrator = vc.Whitted(n_vpls=12, n_area=4, n_environment=2, n_brdf=2)
    frame = q.render(scene, integrator, preset=preset, c_e=8)
    assert q.rel_l1(frame.image, q.exact(scene, integrator).image) < 0.15
    assert frame.counters["ray_reduction"] > 2
    assert len(frame.counters["rays_per_level"]) == (2 if preset == "default" else 3)
    used = frame.parameters["visibility"]
    assert used | {"preset": preset, "c_e": 8} == used


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


DIRECT, AMBIENT = vc.Direct(), vc.AmbientOcclusion(n_samples=16, max_distance=None)


def made(group):
    """A scene lit by one group, and what asks for it."""
    if group == "ambient":
        return q.scene("slats"), AMBIENT
    if group == "environment":
        sky = vc.Direct(n_area=0, n_environment=16, n_brdf=16)
        return q.scene("cube_on_plane").with_environment(1.0), sky
    return q.scene("cornell_box"), vc.Direct(n_area=24)


@pytest.mark.parametrize("group", ["area", "environment", "ambient"])
@pytest.mark.parametrize("refinement", ["off", "on"])
def test_rows_and_the_table_are_about_as_wrong_with_as_many_rays(group, refinement):
    """rel_l1 within 25 %, rays within 5 % (refined: 10 %), at equal parameters."""
    scene, integrator = made(group)
    options = {"c_e": 8, "refinement": refinement, "size": (160, 100)}
    exact = q.exact(scene, integrator, (160, 100)).layers[group]
    rows = q.render(scene, integrator, **options)
    table = q.render(scene, integrator, form="pairs", storage="exact", **options)
    errors = [q.rel_l1(f.layers[group], exact) for f in (rows, table)]
    assert errors[0] == pytest.approx(errors[1], rel=0.25) and errors[0] > 1e-3
    rays = [f.counters["groups"][group]["rays"] for f in (rows, table)]
    assert rays[0] == pytest.approx(rays[1], rel=0.05 if refinement == "off" else 0.1)
    queries = rows.counters["groups"][group]["queries"]
    assert queries == table.counters["groups"][group]["queries"] > 2 * rays[0]
    coarse = q.render(scene, integrator, **options | {"c_e": 24, "refinement": "off"})
    assert q.rel_l1(coarse.layers[group], exact) > 1.1 * errors[0]


@pytest.mark.parametrize("group", ["area", "environment", "ambient"])
def test_finer_light_cells_lower_an_error_that_no_c_e_lowers(group):
    """c_l: to the exact frame's, through rows and the table alike."""
    scene, integrator = made(group)
    exact = q.exact(scene, integrator).layers[group]

    def error(**options):
        frame = q.render(scene, integrator, **options)
        return q.rel_l1(frame.layers[group], exact), frame.counters["groups"][group]["rays"]

    floor, few = error(c_e=0.05)
    found = [error(c_e=0.05, c_l=c_l) for c_l in (4, 0.3, 0.01)]
    errors, rays = zip(*found, strict=True)
    assert errors[0] > 1.3 * floor > 2 * errors[1] and errors[2] < 0.05 * floor
    assert rays[0] < few < rays[1] < rays[2]
    table, asked = error(c_e=0.05, c_l=0.3, form="pairs", storage="exact")
    assert table == pytest.approx(errors[1], rel=0.25)
    assert asked == pytest.approx(rays[1], rel=0.05)


def extreme(scene, **options):
    """A frame that is finite and counts every query, and the exact one."""
    exact, frame = q.exact(scene, DIRECT), q.render(scene, DIRECT, **options)
    assert np.isfinite(frame.image).all() and (frame.image >= 0).all()
    counts = frame.counters
    assert counts["queries"] == exact.counters["queries"] >= counts["rays"]
    assert counts["non_finite"] == exact.counters["non_finite"]
    return frame, exact


@pytest.mark.extreme
def test_a_huge_ground_plane_does_not_coarsen_the_cells():
    """B_R grows 10⁴-fold; R and the coordinates grow with it, the cells stay."""
    reduction = []
    for width in (1e2, 1e4, 1e6):
        description = q.description_of(q.scene("cube_on_plane"))
        description.add_mesh(*floor(width, -0.001), material=0)
        scene = vc.Scene.from_description(description)
        assert extreme(scene, c_e=1e-3)[0].sha256 == q.exact(scene, DIRECT).sha256
        frames = [extreme(scene, c_e=8, grid_seed=s)[0] for s in range(4)]
        reduction.append(np.mean([frame.counters["ray_reduction"] for frame in frames]))
    # One rung of the ladder changes a cell's area by C_R² = 1.44
    assert max(reduction) < 1.44 * min(reduction)


@pytest.mark.extreme
@pytest.mark.parametrize("mode", ["round", "floor"])
def test_odd_c_n_works_but_costs_rays_on_axis_aligned_walls(mode):
    """One bin edge lies on the axes: oblique grids cut the walls; the frame warns."""
    reduction, warned = {}, {}
    for c_n in (1, 2, 3, 8, 64):
        frame, exact = extreme(q.lit_box(), c_e=6, c_n=c_n, normal_mode=mode, refinement="off")
        assert q.rel_l1(frame.image, exact.image) < 0.1
        reduction[c_n] = frame.counters["ray_reduction"]
        warned[c_n] = any("odd c_n" in text for text in frame.warnings)
    assert reduction[1] < 0.5 * reduction[2] and reduction[3] < 0.5 * reduction[8]
    assert reduction[2] == pytest.approx(reduction[8], rel=0.3)
    assert warned == {1: True, 2: False, 3: True, 8: False, 64: False}


@pytest.mark.extreme
@pytest.mark.parametrize("form", q.FORMS)
def test_grazing_views_keep_finite_cells(form):
    """The eye 1 mm above the floor, looking along it: cosθ is clamped in the density."""
    view = ((0, 1e-3, 4.0), (0, 1e-3, 0), 30)
    scene = with_parts(floor(100.0), table(), camera=view)
    frame, exact = extreme(scene, c_e=8, **q.FORMS[form])
    assert extreme(scene, c_e=1e-3, **q.FORMS[form])[0].sha256 == exact.sha256
    assert frame.counters["queries"] > 1000 and frame.counters["ray_reduction"] > 2
    assert frame.counters["clamped_nan"] == frame.counters["bypassed"] == 0
