"""Whole frames with extreme inputs."""

from __future__ import annotations

import math

import numpy as np
import pytest

import viscache as vc
from render import quantized as q

pytestmark = pytest.mark.extreme

DIRECT = vc.Direct()
FORMS = [q.FORMS["waves"], q.FORMS["pairs-table"]]
QUAD = np.uint32([[0, 1, 2], [0, 2, 3]])


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


def with_parts(*parts, lights=(((2.2, 3.0, 1.2), (12, 12, 12)),), camera=None):
    """Grey two-sided meshes (vertices, triangles) and point lights."""
    description = vc.SceneDescription()
    grey = description.add_material(base_color=(0.5, 0.5, 0.5))
    for vertices, triangles in parts:
        description.add_mesh(vertices, triangles, material=grey)
    for position, intensity in lights:
        description.add_point_light(position, intensity)
    origin, target, fov = camera or ((-1.2, 2.6, 4.2), (0, 0.35, 0), 38)
    description.add_camera(origin, target, fov_deg=fov)
    return vc.Scene.from_description(description)


def floor(width=4.0, height=0.0):
    w = width
    return np.array([[-w, height, w], [w, height, w], [w, height, -w], [-w, height, -w]]), QUAD


def table():
    """A square above the floor."""
    return np.array([[-0.5, 0.6, 0.5], [0.5, 0.6, 0.5], [0.5, 0.6, -0.5], [-0.5, 0.6, -0.5]]), QUAD


# Place and size of the scene


@pytest.mark.parametrize("form", FORMS, ids=["waves", "pairs"])
@pytest.mark.parametrize("offset", [1e3, 1e5, 1e6])
def test_scenes_far_from_the_origin_have_the_references_artefacts_only(form, offset):
    """Positions are rounded to 0.06 at 1e6: the exact image changes, the cache follows it."""
    scene = q.moved(q.scene("cube_on_plane"), shift=(offset, offset, -offset))
    assert exact_in_the_limit(scene, **form)
    frame, exact = check(scene, **form)
    near, _ = check(q.scene("cube_on_plane"), **form)
    ratio = frame.counters["ray_reduction"] / near.counters["ray_reduction"]
    assert ratio == pytest.approx(1, rel=0.001 if offset < 1e4 else 0.3)
    assert q.rel_l1(frame.image, exact.image) < 0.03


@pytest.mark.parametrize("form", FORMS, ids=["waves", "pairs"])
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_micrometres_and_megametres_give_the_same_picture(form, scale):
    scene = q.moved(q.scene("cube_on_plane"), scale=scale)
    assert exact_in_the_limit(scene, **form)
    frame, exact = check(scene, **form)
    near, exact_near = check(q.scene("cube_on_plane"), **form)
    assert frame.counters["rays"] == pytest.approx(near.counters["rays"], rel=0.01)
    error, error_near = q.rel_l1(frame.image, exact.image), q.rel_l1(near.image, exact_near.image)
    assert error == pytest.approx(error_near, rel=0.05) and error > 0.001


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


@pytest.mark.parametrize("form", q.FORMS)
@pytest.mark.parametrize("c_e", [1e-9, 1e-30])
def test_c_e_near_zero_is_exact_and_counted(form, c_e):
    """R > R_max is folded, never clamped silently."""
    frame = q.render(q.lit_box(), c_e=c_e, **q.FORMS[form])
    assert frame.sha256 == q.exact(q.lit_box()).sha256
    assert frame.counters["rays"] == frame.counters["queries"]
    assert frame.counters["clamped_high"] > 0


@pytest.mark.parametrize("form", q.FORMS)
@pytest.mark.parametrize("c_e", [1e9, 1e30])
def test_huge_c_e_leaves_a_ray_per_normal_bin_slab_and_light(form, c_e):
    """R = 1: few rays, and finite values within the lights' range; refinement still ends."""
    frame, exact = check(q.lit_box(), q.SHARED, c_e=c_e, refinement="off", **q.FORMS[form])
    assert frame.counters["ray_reduction"] > 40 and frame.counters["clamped_low"] > 0
    assert 0.01 < q.rel_l1(frame.image, exact.image) < 0.3
    refined, _ = check(q.lit_box(), q.SHARED, c_e=c_e, **q.FORMS[form])
    # From 1e30 even 32 levels do not reach a cell smaller than the scene
    assert refined.counters["rays"] > frame.counters["rays"] or c_e == 1e30
    assert refined.counters["rays"] >= frame.counters["rays"]


def test_extreme_c_e_of_local_samples_is_finite():
    """Area, environment and ambient samples; light cells do not shrink with C_E."""
    scene = q.lit_box().with_environment(0.5)
    tiny, _ = check(scene, q.LOCAL, c_e=1e-9)
    assert tiny.sha256 == check(scene, q.LOCAL, c_e=1e-3)[0].sha256
    huge, _ = check(scene, q.LOCAL, c_e=1e9)
    for group in ("area", "environment"):
        small, large = (f.counters["groups"][group] for f in (tiny, huge))
        assert 0.5 * small["queries"] < small["rays"] < small["queries"]
        assert large["rays"] < 0.05 * large["queries"]
    for c_e in (1e-9, 1e9):
        check(scene, vc.AmbientOcclusion(n_samples=8, max_distance=None), c_e=c_e)


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


@pytest.mark.parametrize("storage", [{"digest_bits": 1}, {"table_bytes": 4}], ids=str)
def test_tiny_digests_and_tables_stay_within_what_the_lights_give(storage):
    """A table of one slot keeps the last key; digests of one bit cause errors, and are counted."""
    options = {**q.FORMS["pairs-table"], **storage, "c_e": 1e-3}
    frame, exact = check(q.lit_box(), q.SHARED, **options)
    counts = frame.counters
    if "table_bytes" in storage:
        assert frame.sha256 == exact.sha256
        edge = frame.parameters["tile_edge_px"]
        tiles = math.prod(math.ceil(pixels / edge) for pixels in q.SIZE)
        assert (
            counts["evictions"] == counts["table_writes"] - tiles
        )  # each begins with an empty slot
        assert counts["table_slots"] == tiles
        assert counts["expected_false_hits"] < 1e-3
        return
    assert 0 < counts["queries"] - counts["rays"] < 3 * counts["expected_false_hits"]
    both, _ = check(q.lit_box(), q.SHARED, **{**options, "table_bytes": 4})
    assert both.counters["rays"] < 0.1 * counts["rays"]
    assert q.rel_l1(both.image, exact.image) > q.rel_l1(frame.image, exact.image)


# Geometry


@pytest.mark.parametrize("noise", [1e-7, 1e-5])
def test_noise_on_the_normals_of_axis_aligned_walls_costs_nothing_with_rounding(noise):
    """The printed floor has its bin edges on the axes: rays more than double."""
    shaken = q.moved(q.lit_box(), noise=noise)
    rays = {
        mode: [
            check(scene, size=(160, 100), normal_mode=mode, refinement="off")[0].counters["rays"]
            for scene in (q.lit_box(), shaken)
        ]
        for mode in ("round", "floor")
    }
    assert rays["round"][1] == pytest.approx(rays["round"][0], rel=0.02)
    assert rays["floor"][1] > 1.8 * rays["floor"][0]


def test_a_plane_through_the_centre_of_the_scene_is_not_split_by_noise():
    """Without the irrational offset its points lie on a cell face."""
    rng = np.random.default_rng(2)
    steps = np.linspace(-1, 1, 41)
    x, z = (a.ravel() for a in np.meshgrid(2 * steps, 2 * steps))
    near = np.arange(40)[:, None] * 41 + np.arange(40)
    a, b, c, d = (near.ravel() + k for k in (0, 41, 42, 1))
    cells = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.uint32)
    # Two small things make the centre of the bounds lie in the plane
    specks = [
        (np.array([[0, h, 0], [1e-3, h, 0], [0, h, 1e-3]]), np.uint32([[0, 1, 2]]))
        for h in (-2.0, 2.0)
    ]
    rays = {}
    for offset in (True, False):
        for noise in (0.0, 1e-7):
            plane = np.stack([x, noise * rng.uniform(-1, 1, x.size), z], axis=1)
            scene = with_parts((plane, cells), *specks, camera=((0, 2, 3), (0, 0, 0), 45))
            options = {"grid_offset": offset, "c_e": 6, "c_z": 8, "refinement": "off"}
            rays[offset, noise] = check(scene, **options)[0].counters["rays"]
    assert rays[True, 1e-7] == pytest.approx(rays[True, 0], rel=0.02)
    assert rays[False, 1e-7] > 1.3 * rays[False, 0]


@pytest.mark.parametrize("form", q.FORMS)
def test_degenerate_triangles_change_nothing(form):
    """Zero area: points, needles, repeated indices; also as the only thing in a mesh."""
    vertices, triangles = floor()
    needles = np.uint32([[0, 0, 0], [1, 1, 2], [0, 1, 0], [2, 2, 2]])
    line = np.array([[0, 0.3, 0], [0.1, 0.3, 0], [0.2, 0.3, 0]]), np.uint32([[0, 1, 2]])
    plain = with_parts((vertices, triangles), table())
    dirty = with_parts((vertices, np.concatenate([needles, triangles])), table(), line)
    options = q.FORMS[form]
    assert check(dirty, **options)[0].sha256 == check(plain, **options)[0].sha256
    assert exact_in_the_limit(dirty, **options)


@pytest.mark.parametrize("form", q.FORMS)
def test_grazing_views_keep_finite_cells(form):
    """The eye 1 mm above the floor, looking along it: cosθ is clamped in the density."""
    view = ((0, 1e-3, 4.0), (0, 1e-3, 0), 30)
    scene = with_parts(floor(100.0), table(), camera=view)
    frame, _ = check(scene, **q.FORMS[form])
    assert frame.counters["queries"] > 1000 and frame.counters["ray_reduction"] > 2
    assert frame.counters["clamped_nan"] == frame.counters["bypassed"] == 0
    assert exact_in_the_limit(scene, **q.FORMS[form])


@pytest.mark.parametrize("height", [0.0, 1e-7, -1e-7, 1e-3])
def test_a_light_in_or_just_off_the_surface_is_answered(height):
    """On the plane itself the cosine is 0, so only points above the floor have queries."""
    wall = np.array([[-1, 0, -1], [1, 0, -1], [1, 1, -1], [-1, 1, -1]]), QUAD
    scene = with_parts(floor(), table(), wall, lights=(((0.0, height, 1.0), (1, 1, 1)),))
    for form in FORMS:
        frame, _ = check(scene, **form)
        assert exact_in_the_limit(scene, **form)
        assert frame.counters["queries"] > 100


def test_lights_at_the_eye_inside_things_and_in_one_place():
    """At the camera, inside the cube, twice in the same place, and mirrored by sign flips."""
    places = [(-1.2, 2.6, 4.2), (0, 0.5, 0), (1, 2, 3), (1, 2, 3), (-1, 2, -3), (0.0, 3.0, -0.0)]
    description = q.description_of(q.scene("cube_on_plane"))
    for place in places:
        description.add_point_light(place, (2, 2, 2))
    scene = vc.Scene.from_description(description)
    for form in q.FORMS.values():
        assert exact_in_the_limit(scene, **form)
        frame, exact = check(scene, **form)
        assert q.rel_l1(frame.image, exact.image) < 0.1


def cut_out_scene(cutoff):
    """A chequered alpha map on the table."""
    description = vc.SceneDescription()
    grey = description.add_material(base_color=(0.5, 0.5, 0.5))
    rgba = np.ones((8, 8, 4), np.float32)
    rgba[..., 3] = np.indices((8, 8)).sum(axis=0) % 2
    image = description.add_image(rgba)
    leaf = description.add_material(
        base_color=(0.5, 0.5, 0.5), alpha_texture=image, alpha_cutoff=cutoff
    )
    description.add_mesh(*floor(), material=grey)
    corners, triangles = table()
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    description.add_mesh(corners, triangles, material=leaf, uvs=uvs)
    description.add_point_light((0.5, 3.0, 0.5), (12, 12, 12))
    description.add_camera((-1.2, 2.6, 4.2), (0, 0.35, 0), fov_deg=38)
    return vc.Scene.from_description(description)


@pytest.mark.parametrize("form", q.FORMS)
def test_visibility_through_alpha_cut_outs_is_the_filtered_one(form):
    scene, solid = cut_out_scene(0.5), cut_out_scene(0.0)
    assert exact_in_the_limit(scene, **q.FORMS[form])
    blocked = q.exact(scene, DIRECT).counters["occluded"]
    assert 0 < blocked < 0.8 * q.exact(solid, DIRECT).counters["occluded"]
    frame, exact = check(scene, c_e=2, **q.FORMS[form])
    assert q.rel_l1(frame.image, exact.image) < 0.1


@pytest.mark.parametrize("size", [(1, 1), (1, 200), (300, 1), (257, 3)])
def test_frames_of_a_pixel_and_of_a_line_render(size):
    """Tiles of one eye point, tiles that end after one column."""
    for form in q.FORMS.values():
        frame, exact = check(q.lit_box(), q.SHARED, size=size, **form)
        assert frame.image.shape == (size[1], size[0], 3)
        fine, _ = check(q.lit_box(), q.SHARED, size=size, c_e=1e-3, **form)
        assert fine.sha256 == exact.sha256
