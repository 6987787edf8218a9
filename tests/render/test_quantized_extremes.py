"""Whole frames with extreme inputs."""

import numpy as np
import pytest

import viscache as vc
from render import quantized as q
from viscache_lab.extremes.scenes import floor, table, with_parts

pytestmark = pytest.mark.extreme

DIRECT = vc.Direct()


def check(scene, integrator=DIRECT, size=q.SIZE, **options):
    """A frame with C_E = 8 and the exact one; the cached one is finite and counts every query."""
    exact = q.exact(scene, integrator, size)
    frame = q.render(scene, integrator, size=size, **{"c_e": 8, **options})
    assert np.isfinite(frame.image).all() and (frame.image >= 0).all()
    counts = frame.counters
    assert counts["queries"] == exact.counters["queries"] >= counts["rays"]
    assert counts["non_finite"] == exact.counters["non_finite"]
    return frame, exact


def exact_in_the_limit(scene, integrator=DIRECT, **options):
    """C_E = 1e-3 gives the exact image bit for bit."""
    return check(scene, integrator, c_e=1e-3, **options)[0].sha256 == (
        q.exact(scene, integrator).sha256
    )


# Place and size of the scene


def test_a_huge_ground_plane_does_not_coarsen_the_cells():
    """B_R grows 10⁴-fold; R and the coordinates grow with it, the cells stay."""
    reduction = []
    for width in (1e2, 1e4, 1e6):
        description = q.description_of(q.scene("cube_on_plane"))
        description.add_mesh(*floor(width, -0.001), material=0)
        scene = vc.Scene.from_description(description)
        assert exact_in_the_limit(scene)
        frames = [check(scene, grid_seed=s)[0] for s in range(4)]
        reduction.append(np.mean([frame.counters["ray_reduction"] for frame in frames]))
    # One rung of the ladder changes a cell's area by C_R² = 1.44
    assert max(reduction) < 1.44 * min(reduction)


# Parameters


@pytest.mark.parametrize("mode", ["round", "floor"])
def test_odd_c_n_works_but_costs_rays_on_axis_aligned_walls(mode):
    """One bin edge lies on the axes: oblique grids cut the walls; the frame warns."""
    reduction, warned = {}, {}
    for c_n in (1, 2, 3, 8, 64):
        frame, exact = check(q.lit_box(), c_e=6, c_n=c_n, normal_mode=mode, refinement="off")
        assert q.rel_l1(frame.image, exact.image) < 0.1
        reduction[c_n] = frame.counters["ray_reduction"]
        warned[c_n] = any("odd c_n" in text for text in frame.warnings)
    assert reduction[1] < 0.5 * reduction[2] and reduction[3] < 0.5 * reduction[8]
    assert reduction[2] == pytest.approx(reduction[8], rel=0.3)
    assert warned == {1: True, 2: False, 3: True, 8: False, 64: False}


# Geometry


@pytest.mark.parametrize("form", q.FORMS)
def test_grazing_views_keep_finite_cells(form):
    """The eye 1 mm above the floor, looking along it: cosθ is clamped in the density."""
    view = ((0, 1e-3, 4.0), (0, 1e-3, 0), 30)
    scene = with_parts(floor(100.0), table(), camera=view)
    frame, _ = check(scene, **q.FORMS[form])
    assert frame.counters["queries"] > 1000 and frame.counters["ray_reduction"] > 2
    assert frame.counters["clamped_nan"] == frame.counters["bypassed"] == 0
    assert exact_in_the_limit(scene, **q.FORMS[form])
