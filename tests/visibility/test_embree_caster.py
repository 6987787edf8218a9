"""scene.intersect, occluded, visible: right answers by every caster, errors for what cannot be."""

import subprocess
import sys
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from render.mitsuba_scene import quad
from visibility.moeller_trumbore import cross_all
from visibility.soup import rays, soup

Array = npt.NDArray[Any]


WATERTIGHT = vc.Embree(watertight=True)
TREES = [
    vc.Bsp(max_depth=d, leaf_size=2, kernel=k) for k in ("watertight", "wald") for d in (1, 7, 24)
]


@pytest.mark.parametrize("caster", [vc.Embree(), vc.Embree(robust=False), *TREES], ids=str)
def test_hits_are_those_of_all_triangles_tried(caster):
    vertices, triangles = soup(300, 0.3)
    scene = vc.Scene.from_arrays(vertices, triangles)
    tree = isinstance(caster, vc.Bsp)
    o, d = rays(6000, along=tree)
    truth = cross_all(vertices, triangles, o, d)
    t, triangle, uv, instance = scene.intersect(o, d, rays=caster)
    clear = truth.margin > (1e-4 if tree else 1e-5)
    assert clear.mean() > 0.9 and 0.2 < (truth.triangle[clear] >= 0).mean() < 0.99
    np.testing.assert_array_equal(triangle[clear], truth.triangle[clear])
    hit = clear & (truth.triangle >= 0)
    np.testing.assert_allclose(t[hit], truth.t[hit], rtol=1e-4, atol=1e-5 if tree else 1e-6)
    np.testing.assert_allclose(uv[hit], truth.uv[hit], atol=2e-3 if tree else 1e-4)
    missed = clear & (truth.triangle < 0)
    assert np.isinf(t[missed]).all() and np.isnan(uv[missed]).all() and (instance == -1).all()
    if tree:
        np.testing.assert_array_equal(scene.occluded(o, d, rays=caster), triangle >= 0)


@pytest.mark.parametrize(
    ("caster", "length"),
    [(vc.Embree(), 1e-6), (vc.Embree(), 1e6)]
    + [(WATERTIGHT, 10.0**power) for power in (-30, -12, -7, 7, 14)],
    ids=str,
)
def test_the_length_of_a_direction_only_scales_t(caster, length):
    scene = vc.Scene.from_arrays(*soup())
    o, d = rays(5000)
    unit = scene.intersect(o, d, rays=caster)
    scaled = scene.intersect(o, (d * np.float32(length)).astype(np.float32), rays=caster)
    same = scaled.triangle == unit.triangle
    assert same.mean() > 0.999
    hit = same & (unit.triangle >= 0)
    rtol = 1e-5 if caster.watertight else 1e-3
    np.testing.assert_allclose(
        scaled.t[hit].astype(float) * length, unit.t[hit], rtol=rtol, atol=1e-7
    )


def test_occluded_and_visible_agree_with_the_nearest_hit():
    vertices, triangles = soup(seed=3)
    scene = vc.Scene.from_arrays(vertices, triangles)
    o, d = rays(5000, seed=4)
    truth = cross_all(vertices, triangles, o, d)
    clear = truth.margin > 1e-5
    np.testing.assert_array_equal(scene.occluded(o, d)[clear], (truth.triangle >= 0)[clear])
    t_max = np.random.default_rng(5).uniform(0, 3, len(o)).astype(np.float32)
    clear &= np.abs(truth.t - t_max) > 1e-4
    np.testing.assert_array_equal(scene.occluded(o, d, t_max)[clear], (truth.t < t_max)[clear])
    np.testing.assert_array_equal(
        scene.occluded(o, d, 1.0), scene.occluded(o, d, np.full(len(o), 1.0))
    )
    end = (o + d).astype(np.float32)
    clear = (truth.margin > 1e-4) & (np.abs(truth.t - 1) > 1e-4)
    np.testing.assert_array_equal(scene.visible(o, end)[clear], (truth.t > 1)[clear])
    np.testing.assert_array_equal(scene.visible(o, end)[clear], scene.visible(end, o)[clear])


@pytest.mark.parametrize(
    ("caster", "counted"),
    [
        (vc.Embree(), True),
        (vc.Embree(robust=False), False),
        (vc.Bsp(), False),
        (vc.Bsp(kernel="wald"), False),
        (vc.Vlf(n_directions=33, n_tiles=8), False),
    ],
    ids=str,
)
def test_rays_end_where_they_are_told_and_robust_ones_alone_meet_their_origin(caster, counted):
    scene = vc.Scene.from_arrays([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    on, above, down = (0.25, 0.25, 0.0), (0.25, 0.25, 1.0), (0.0, 0.0, -1.0)
    t = scene.intersect([on, above], [down, down], rays=caster).t
    assert (t[0] == 0) if counted else np.isinf(t[0])
    assert bool(scene.occluded([on], [down], rays=caster)[0]) == counted
    assert t[1] == pytest.approx(1, rel=1e-6)
    for t_max, expected in ((0, False), (0.999, False), (1.001, True), (np.inf, True)):
        assert scene.occluded([above], [down], t_max, rays=caster)[0] == expected
    assert not scene.occluded([above], [(0, 0, 0)], rays=caster).any()
    for z, free in ((0.1, True), (-1.0, False)):
        assert scene.visible([above], [(0.25, 0.25, z)], rays=caster)[0] == free


def test_answers_do_not_depend_on_threads_or_packets():
    scene = vc.Scene.from_arrays(*soup())
    o, d = rays(40_000)
    whole = scene.occluded(o, d, threads=1)
    for threads in (2, 3, 8):
        np.testing.assert_array_equal(scene.occluded(o, d, threads=threads), whole)
    for i in range(7):
        np.testing.assert_array_equal(scene.occluded(o[i::7], d[i::7]), whole[i::7])
    for n in (1, 2, 15, 16, 17, 33):
        np.testing.assert_array_equal(scene.occluded(o[:n], d[:n]), whole[:n])
        np.testing.assert_array_equal(scene.intersect(o[:n], d[:n]).triangle >= 0, whole[:n])


def placed(scale, turn):
    q = np.linalg.qr(np.random.default_rng(9).normal(size=(3, 3)))[0]
    q *= np.sign(np.linalg.det(q)) * (-1 if turn else 1)  # -1: mirrored
    return np.concatenate([scale * q, [[3.0], [-1.0], [0.5]]], axis=1)


@pytest.mark.parametrize("mirrored", [False, True])
def test_instances_are_hit_where_the_transformed_mesh_would_be(mirrored):
    vertices, triangles = soup(60)
    transforms = [placed(0.5, mirrored), placed(2.0, mirrored)]
    d = vc.SceneDescription()
    mesh = d.add_mesh(vertices, triangles, in_world=False)
    world = d.add_mesh(vertices[:30], triangles[:10])
    for m in transforms:
        d.add_instance([mesh], m)
    scene = vc.Scene.from_description(d)
    assert scene.triangles == 130 and world == 1
    copies = [vertices[:30].astype(float)] + [vertices @ m[:, :3].T + m[:, 3] for m in transforms]
    first = np.cumsum([0] + [len(c) for c in copies])
    faces = np.concatenate([triangles[:10] + first[0], triangles + first[1], triangles + first[2]])
    o, w = rays(3000)
    o = (o * 3 + [2, -1, 0]).astype(np.float32)
    truth = cross_all(np.concatenate(copies), faces, o, w)
    clear, hit, face = truth.margin > 1e-4, truth.triangle >= 0, truth.triangle
    owner = np.where(hit, np.searchsorted([10, 70], face, side="right") - 1, -1)
    expected = np.where(hit, np.where(face < 10, 60 + face, (face - 10) % 60), -1)
    assert hit[clear].mean() > 0.05
    for caster in (vc.Embree(), vc.Bsp()):
        found = scene.intersect(o, w, rays=caster)
        np.testing.assert_array_equal(found.triangle[clear], expected[clear])
        np.testing.assert_array_equal(found.instance[clear], owner[clear])
        np.testing.assert_allclose(found.t[clear & hit], truth.t[clear & hit], rtol=1e-3)
        np.testing.assert_array_equal(scene.occluded(o, w, rays=caster)[clear], hit[clear])


@pytest.mark.parametrize("instanced", [False, True])
@pytest.mark.parametrize("channels", [1, 4])
@pytest.mark.parametrize("rays", [vc.Embree(), WATERTIGHT, vc.Bsp()], ids=str)
def test_alpha_cuts_holes_for_every_kind_of_ray(rays, channels, instanced):
    """The left half of a card is cut away; the image's top row is v = 1."""
    alpha = np.zeros((2, 2, channels), np.float32)
    alpha[:, 1, -1] = 1
    alpha[0, 0, -1] = 0.4
    d = vc.SceneDescription()
    material = d.add_material(alpha_texture=d.add_image(alpha), alpha_cutoff=0.5)
    card = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    uvs = [[0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [0.25, 0.75]]
    mesh = d.add_mesh(*card, uvs=uvs, material=material, in_world=not instanced)
    if instanced:
        d.add_instance([mesh], np.eye(4))
    scene = vc.Scene.from_description(d)
    at = np.array([[x, y, 1.0] for x in (0.05, 0.3, 0.7, 0.95) for y in (0.1, 0.9)], np.float32)
    down = np.broadcast_to(np.float32([0, 0, -1]), at.shape)
    # Bilinear between columns 0 (cut) and 1 (kept); near the top column 0 holds 0.4
    expected = np.array([False, False, False, True, True, True, True, True])
    np.testing.assert_array_equal(scene.occluded(at, down, rays=rays), expected)
    np.testing.assert_array_equal(~scene.visible(at, at * [1, 1, -1], rays=rays), expected)
    np.testing.assert_array_equal(np.isfinite(scene.intersect(at, down, rays=rays).t), expected)


SCENE = vc.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
ONE = [[0.2, 0.2, 1.0]]
DOWN = [[0.0, 0.0, -1.0]]
BAD_VALUES = [np.nan, np.inf, -np.inf, 2e16, 2e18, 1e30, 1e300]


@pytest.mark.parametrize("value", BAD_VALUES)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_coordinates_that_rays_cannot_use_are_refused_by_name(value, axis):
    bad, good = np.array([[0.2, 0.2, 1.0], [0.1, 0.1, 1.0]]), np.repeat(ONE, 2, axis=0)
    bad[1, axis] = value
    names = ("origins", "directions")
    calls = ((SCENE.visible, "x", "y"), (SCENE.occluded, *names), (SCENE.intersect, *names))
    for call, first, second in calls:
        for given, name in (((bad, good), first), ((good, bad), second)):
            says = rf"^{name} must be finite and at most 1e16 in size, row 1 "
            with pytest.raises(ValueError, match=says):
                call(*given)


@pytest.mark.parametrize(
    "wrong", [[], [0.0, 0.0], [[0.0, 0.0]], np.zeros((2, 3, 1)), np.zeros((1, 4)), 1.0]
)
def test_wrong_shapes_are_refused_with_the_shape_given(wrong):
    for call, given in (
        (SCENE.visible, (wrong, ONE)),
        (SCENE.occluded, (ONE, wrong)),
        (SCENE.intersect, (wrong, ONE)),
    ):
        with pytest.raises(ValueError, match=r"must have shape \(\.\.\., 3\), got \("):
            call(*given)


@pytest.mark.parametrize(
    "wrong", [[["a", "b", "c"]], [[None, 1, 2]], [[1j, 0, 0]], [[True, False, True]]]
)
def test_what_is_not_a_number_is_refused(wrong):
    with pytest.raises(ValueError, match="x must be numbers, got dtype"):
        SCENE.visible(wrong, ONE)


@pytest.mark.parametrize(
    ("t_max", "says"),
    [(t, "must be >= 0, got") for t in (np.nan, -1.0, -np.inf, [-1e-30])]
    + [(t, "must") for t in ([1.0, 2.0], [[1.0] * 4], "far", None)],
    ids=str,
)
def test_a_t_max_that_is_none_is_refused(t_max, says):
    with pytest.raises(ValueError, match=f"t_max {says}"):
        SCENE.occluded(ONE * 3, DOWN * 3, t_max)


def test_no_rays_are_no_answers():
    none = np.zeros((0, 3))
    assert SCENE.visible(none, none).shape == SCENE.occluded(none, none).shape == (0,)
    assert SCENE.occluded(none, none, np.zeros(0)).dtype == bool
    found = SCENE.intersect(none, none)
    assert [f.shape for f in found] == [(0,), (0,), (0, 2), (0,)]
    assert [f.dtype for f in found] == [np.float32, np.int64, np.float32, np.int64]


def test_t_max_may_be_an_array_an_integer_or_infinite():
    for t_max in (2, 2.0, [2.0], np.inf, np.float64(2), np.array(2.0), np.array([2], np.int64)):
        assert SCENE.occluded(ONE, DOWN, t_max)[0]
    assert not SCENE.occluded(ONE, DOWN, 0.5)[0]


def test_degenerate_triangles_do_no_harm():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.5, 0.5]]
    scene = vc.Scene.from_arrays(vertices, [[0, 0, 0], [0, 1, 1], [3, 3, 3], [0, 1, 2]])
    assert scene.intersect(ONE, DOWN).triangle[0] == 3
    assert np.isfinite(vc.render(scene, vc.Direct(), size=(8, 8), env=1.0).image).all()


def test_coherent_packets_of_16_that_enter_instances_come_to_an_end():
    # Embree built by g++ looped for ever here on AVX-512, where incoherent packets went before
    code = """
import viscache as vc
from viscache_lab.bench.ray_sets import make_ray_set
scene = vc.scenes.courtyard(triangles=30_000)
rays = make_ray_set(scene, "camera", 3001)
for coherent in (False, True):
    scene.caster().bare_occluded(
        rays.origins, rays.directions, rays.t_max, 16, coherent=coherent, threads=1
    )
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


@pytest.mark.extreme
@pytest.mark.parametrize("stretch", [(1e-20,) * 3, (1e-12,) * 3, (1e-3, 1, 1e3), (1e11,) * 3])
def test_rays_from_the_end_of_the_range_enter_any_instance(stretch):
    """In an instance's own space a ray may lie beyond what Embree's live asserts allow."""
    description = vc.SceneDescription()
    description.add_material()
    card = np.array([[-1, -1, 0], [1, -1, 0], [0, 2, 0], [0, -1, -1], [0, -1, 1], [0, 2, 0]], "f4")
    description.add_mesh(card, [[0, 1, 2], [3, 4, 5]], in_world=False)
    description.add_instance([0], np.diag([*stretch, 1.0]))
    scene = vc.Scene.from_description(description)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    for distance in (1e16, 1e10, 1.0):
        origins, directions = distance * axes, -axes
        scene.occluded(origins, directions)
        scene.occluded(origins, distance * directions)
        scene.visible(origins, -origins)
        t = scene.intersect(origins, directions).t
        assert not np.isnan(t).any()
        # Through the card's middle, where coordinates are of its own size
        if distance == 1.0 and stretch[0] == 1e-3:
            assert np.isfinite(t[[2, 5]]).all()


TRIANGLE = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]])
CASTERS = [vc.Embree(), WATERTIGHT, vc.Bsp()]


@pytest.mark.extreme
@pytest.mark.parametrize("rays", CASTERS, ids=["embree", "watertight", "bsp"])
@pytest.mark.parametrize("size", [1e9, 1e12])
def test_hits_have_a_finite_distance_in_every_scene_that_is_accepted(size, rays):
    scene = vc.Scene.from_arrays(TRIANGLE * size, [[0, 1, 2]])
    for away in (size, 1e14, 1e16):
        hit = scene.intersect([[0, 0, away]], [[0, 0, -1]], rays=rays)
        assert hit.triangle[0] == 0
        assert hit.t[0] == pytest.approx(away, rel=1e-5)


@pytest.mark.extreme
@pytest.mark.parametrize("rays", CASTERS[:2], ids=["embree", "watertight"])
def test_a_distance_beyond_the_largest_number_is_the_largest_number(rays):
    scene = vc.Scene.from_arrays(TRIANGLE, [[0, 1, 2]])
    hit = scene.intersect([[0, 0, 1e4]], [[0, 0, -1e-36]], rays=rays)
    assert hit.triangle[0] in (0, -1) and (hit.triangle[0] < 0) == np.isinf(hit.t[0])


@pytest.mark.parametrize("size", [1.01e12, 1e13, 1e16])
def test_larger_geometry_is_refused(size):
    with pytest.raises(vc.SceneError, match="must be finite and at most 1e12"):
        vc.Scene.from_arrays(TRIANGLE * size, [[0, 1, 2]])
    placed = vc.SceneDescription()
    placed.add_mesh(TRIANGLE, [[0, 1, 2]], in_world=False)
    placed.add_instance([0], np.diag([size, size, size, 1.0]))
    with pytest.raises(vc.SceneError, match="must stay below 1e12"):
        vc.Scene.from_description(placed)


SCALES = [1e-6, 1e-3, 1.0, 1e3, 1e6]
AWAY = [0.0, 3.0, 1e2, 1e5]
N = 20_000


@pytest.mark.extreme
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("away", AWAY)
def test_points_on_surfaces_see_each_other_through_free_space_only(scale, away):
    """`visible` without normals: opposite walls see each other; a screen between them hides."""
    low = quad((-0.5, 0, -0.5), (0, 0, 1), (1, 0, 0))
    high = quad((-0.5, 1, -0.5), (0, 0, 1), (1, 0, 0))
    screen = quad((-2, 0.5, -2), (0, 0, 4), (4, 0, 0))
    shift = np.array([away, away, -away])

    def scene_of(*parts):
        vertices = [((p.vertices.astype(float) + shift) * scale).astype(np.float32) for p in parts]
        faces = np.concatenate([p.triangles + 4 * i for i, p in enumerate(parts)])
        return vc.Scene.from_arrays(np.concatenate(vertices), faces), vertices

    free, (lower, upper) = scene_of(low, high)
    weights = np.random.default_rng(1).dirichlet((1, 1, 1), (2, N)).astype(np.float32)
    x, y = (w @ wall[:3] for w, wall in zip(weights, (lower, upper), strict=True))
    assert free.visible(x, y).all() and free.visible(y, x).all()
    hidden, _ = scene_of(low, high, screen)
    assert not hidden.visible(x, y).any() and not hidden.visible(y, x).any()


@pytest.mark.extreme
def test_visible_keeps_points_apart_that_touch_a_wall_from_both_sides():
    wall = vc.Scene.from_arrays([[-1, -1, 0], [1, -1, 0], [0, 2, 0]], [[0, 1, 2]])
    for gap in (1e-3, 1e-4):
        assert not wall.visible([[0, 0, gap]], [[0, 0, -gap]])[0]
        assert wall.visible([[0, 0, gap]], [[0, 0, 2 * gap]])[0]
