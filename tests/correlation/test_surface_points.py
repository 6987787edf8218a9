"""Points on surfaces: right places, requested number, equal for any blocks and threads."""

import numpy as np
import pytest
from scipy import stats

import viscache as vc
from correlation.scenes import clutter, convex, masked, squares
from sampling.chi_square import p_value
from viscache.correlation.rows import spatial_groups

points = vc.correlation.surface_points


@pytest.mark.parametrize("where", ["camera", "area"])
@pytest.mark.parametrize("n", [16, 17, 1000, 5003])
def test_exactly_as_many_points_come_back_as_asked_for(where, n):
    found = points(clutter(), n, points=where, seed=3)
    assert found.positions.shape == found.normals.shape == found.theta_normals.shape == (n, 3)
    assert found.positions.dtype == found.normals.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(found.normals.astype(float), axis=1), 1, atol=1e-6)
    assert len(set(found.stratum.tolist())) == n
    assert found.stratum.max() < found.width * found.height
    assert (found.n_misses > 0) == (where == "camera")


def test_threads_change_nothing_and_the_seed_everything():
    scene = clutter()
    one, many, other = (points(scene, 9000, seed=s, threads=t) for s, t in ((1, 1), (1, 3), (2, 3)))
    for name in one.__slots__:
        np.testing.assert_array_equal(getattr(one, name), getattr(many, name), err_msg=name)
    assert np.isin(one.positions[:, 0], other.positions[:, 0]).mean() < 0.01


@pytest.mark.parametrize("horizontal", [False, True])
def test_each_point_lies_behind_its_pixel_and_faces_the_camera(horizontal):
    d = vc.SceneDescription()
    mesh = clutter().meshes()[0]
    d.add_mesh(mesh["vertices"], mesh["triangles"], material=d.add_material())
    d.add_camera((0.3, 0.2, 6), (0, 0, 0), fov_deg=40, width=90, height=60, horizontal=horizontal)
    scene = vc.Scene.from_description(d)
    found = points(scene, 4000, seed=5)
    assert found.width / found.height == pytest.approx(1.5, rel=0.04)
    view = scene.cameras[0]
    ray = (found.positions - np.array(view.origin)).astype(float)
    assert (np.einsum("nc,nc->n", ray, found.normals) < 0).all()
    # Where the point is in the image, in pixels
    x, y, z = ray @ np.array(view.right), -ray @ np.array(view.up), ray @ np.array(view.forward)
    half = np.tan(np.radians(20))
    half_x, half_y = (half, half / 1.5) if horizontal else (1.5 * half, half)
    column, row = np.stack([x / z / half_x, y / z / half_y]) / 2 + 0.5
    place = np.stack([column * found.width, row * found.height])
    pixel = np.stack([found.stratum % found.width, found.stratum // found.width])
    assert (place - pixel).min() > -1e-3 and (place - pixel).max() < 1 + 1e-3
    # ... and is the first thing there
    hit = scene.intersect(np.broadcast_to(np.array(view.origin), ray.shape), ray)
    np.testing.assert_allclose(hit.t, 1, atol=1e-4)


@pytest.mark.stat
def test_points_are_uniform_inside_their_pixels():
    scene = vc.Scene.from_arrays(squares()[0] * 100 - [50, 50, 0], squares()[1])
    view = vc.look_at((0, 0, 10), (0, 0, 0), fov_deg=60)
    found = points(scene, 40_000, camera=view, seed=8)
    half = 10 * np.tan(np.radians(30))
    y = (0.5 - found.positions[:, 1].astype(float) / half / 2) * found.height % 1
    assert stats.kstest(y, "uniform").pvalue >= 1e-3
    assert stats.kstest(np.abs(y - 0.5) + 0.5, "uniform").pvalue < 1e-6  # negative control


def test_a_small_thing_in_a_large_image_gets_its_points():
    view = vc.look_at((0, 0, 30), (0, 0, 0), fov_deg=60)
    found = points(convex(), 3000, camera=view)
    assert found.n_misses > 30 * 3000
    np.testing.assert_allclose(np.linalg.norm(found.positions, axis=1), 1, atol=0.04)


def test_a_camera_that_sees_nothing_is_refused():
    away = vc.look_at((0, 0, 5), (0, 0, 10))
    with pytest.raises(ValueError, match=r"camera must see surfaces .* 1/1024 of its image, got 0"):
        points(convex(), 100, camera=away)
    far = vc.look_at((0, 0, 300), (0, 0, 0), fov_deg=60)
    with pytest.raises(ValueError, match=r"camera must see surfaces .*, got \d+ points from"):
        points(convex(), 100, camera=far)


def test_a_scene_without_a_camera_is_seen_whole():
    found = points(convex(), 500)
    corner = np.array(convex().overview_camera().origin)
    assert (np.einsum("nc,nc->n", corner - found.positions, found.normals) > 0).all()


def test_every_triangle_gets_its_share_by_area():
    """Strata along the surfaces: counts are off by less than 2, however the sizes differ."""
    vertices, triangles = squares()
    d = vc.SceneDescription()
    m = d.add_material()
    card = d.add_mesh(vertices, triangles, material=m, in_world=False)
    d.add_mesh(vertices * [3, 1, 1] + [0, 0, 5], triangles, material=m)
    rng = np.random.default_rng(0)
    areas = [1.5, 1.5]
    for k in range(20):
        scale = rng.uniform(0.1, 2, 2)
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        at = np.concatenate([turn * [*scale, 1], [[0], [0], [10 + 5 * k]]], 1)
        d.add_instance([card], at)
        areas += 2 * [scale[0] * scale[1] / 2]
    found = points(vc.Scene.from_description(d), 20_000, points="area")
    ends = np.cumsum(areas) / sum(areas) * 20_000
    counts = np.diff(np.searchsorted(np.sort(found.stratum), ends, side="right"), prepend=0)
    assert abs(counts - 20_000 * np.array(areas) / sum(areas)).max() < 1
    heights = found.positions[:, 2]
    low = (heights > 4.9) & (heights < 5.1)
    assert low.sum() == pytest.approx(20_000 * 3 / sum(areas), abs=2)
    for k in range(20):
        near = abs(heights - (10 + 5 * k)) < 2.9  # no card is longer
        assert near.sum() == pytest.approx(20_000 * 2 * areas[2 + 2 * k] / sum(areas), abs=2)


@pytest.mark.stat
def test_points_are_uniform_on_a_triangle():
    found = points(vc.Scene.from_arrays(*squares()), 40_000, points="area", seed=4)
    place = np.floor(found.positions[:, :2] * 8).astype(int) @ [8, 1]
    expected = np.full(64, 40_000 / 64)
    assert p_value(np.bincount(place, minlength=64).astype(float), expected) >= 1e-3
    place[::20] = 9  # negative control
    assert p_value(np.bincount(place, minlength=64).astype(float), expected) < 1e-6


def test_normals_follow_the_winding_and_turn_with_instances():
    up = points(vc.Scene.from_arrays(*squares()), 100, points="area")
    np.testing.assert_array_equal(up.normals, np.tile([0, 0, 1.0], (100, 1)))
    vertices, triangles = squares()
    down = points(vc.Scene.from_arrays(vertices, triangles[:, ::-1]), 100, points="area")
    np.testing.assert_array_equal(down.normals, np.tile([0, 0, -1.0], (100, 1)))


def test_shading_normals_are_for_the_angle_alone():
    vertices, triangles = squares()
    tilted = np.tile([0.6, 0, 0.8], (4, 1))
    scene = vc.Scene.from_arrays(vertices, triangles, normals=tilted)
    below = vc.look_at((0.5, 0.5, -3), (0.5, 0.5, 0), up=(0, 1, 0))
    for where, camera, side in (("area", None, 1), ("camera", below, -1)):
        found = points(scene, 50, points=where, camera=camera, normals="shading")
        np.testing.assert_allclose(found.theta_normals, side * tilted[[0] * 50], atol=1e-6)
        np.testing.assert_array_equal(found.normals, np.tile([0, 0, side], (50, 1)))
        plain = points(scene, 50, points=where, camera=camera)
        np.testing.assert_array_equal(plain.theta_normals, plain.normals)


@pytest.mark.parametrize("where", ["camera", "area"])
def test_holes_of_alpha_masks_hold_no_points(where):
    found = points(masked(0.25), 4000, points=where)
    upper = found.positions[found.positions[:, 2] > -0.5]
    assert len(upper) > 100 and upper[:, 0].max() < 0.2505
    assert found.n_misses > 500
    if where == "area":  # a quarter of the upper square against the whole lower one
        assert len(upper) / 4000 == pytest.approx(0.2, abs=0.01)


def test_a_scene_that_is_all_holes_is_refused():
    d = vc.SceneDescription()
    hole = d.add_image(np.zeros((1, 1, 4), np.float32))
    vertices, triangles = squares()
    d.add_mesh(
        vertices, triangles, material=d.add_material(alpha_texture=hole), uvs=vertices[:, :2]
    )
    with pytest.raises(ValueError, match="at least 1/1024 of the scene's area must be solid"):
        points(vc.Scene.from_description(d), 100, points="area")


@pytest.mark.parametrize("where", ["camera", "area"])
def test_the_spheres_of_sphere_lights_hold_no_points(where):
    d = vc.SceneDescription()
    d.add_sphere_light((0.5, 0.5, 1), 0.3, (1, 1, 1))
    d.add_mesh(*squares(), material=d.add_material())
    d.add_camera((0.5, 0.5, 3), (0.5, 0.5, 0), up=(0, 1, 0), fov_deg=30)
    found = points(vc.Scene.from_description(d), 2000, points=where)
    assert abs(found.positions[:, 2]).max() == 0


def test_a_scene_without_area_is_refused():
    with pytest.raises(ValueError, match="scene must have surfaces of finite, positive area"):
        points(vc.Scene.from_arrays(np.zeros((3, 3)), [[0, 1, 2]]), 100, points="area")


def halved(p):
    """spatial_groups, transcribed."""
    group = np.zeros(len(p), np.int32)

    def halve(members, first, count):
        group[members] = first
        if count > 1:
            axis = np.ptp(p[members], axis=0).argmax()
            order = members[np.lexsort((members, p[members, axis]))]
            halve(order[: len(order) // 2], first, count // 2)
            halve(order[len(order) // 2 :], first + count // 2, count // 2)

    halve(np.arange(len(p)), 0, 16)
    return group


@pytest.mark.parametrize("n", [16, 100, 4001])
def test_groups_are_medians_of_the_longest_axis(n):
    rng = np.random.default_rng(n)
    p = (rng.normal(size=(n, 3)) * [3, 1, 2]).astype(np.float32)
    np.testing.assert_array_equal(spatial_groups(p), halved(p))
    coarse = np.round(p)  # many equal coordinates
    np.testing.assert_array_equal(spatial_groups(coarse), halved(coarse))


def test_points_come_by_group_in_equal_blocks():
    found = points(clutter(), 1003)
    assert (np.diff(found.group) >= 0).all()
    counts = np.bincount(found.group)
    assert len(counts) == 16 and counts.min() >= 62 and counts.max() <= 63


def test_points_of_a_group_come_in_random_order():
    """No rank correlation of the place in the order with any coordinate, nor with the pixel."""
    found = points(clutter(), 16 * 800, seed=2)
    for what in (*found.positions.T, found.stratum):
        r = [stats.spearmanr(np.arange(800), v).statistic for v in what.reshape(16, 800)]
        assert abs(np.sqrt(799 / 16) * np.sum(r)) < 4
    by_pixel = np.sort(found.stratum.reshape(16, 800), axis=1)  # negative control
    r = [stats.spearmanr(np.arange(800), v).statistic for v in by_pixel]
    assert abs(np.sqrt(799 / 16) * np.sum(r)) > 50


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n_points": 15}, r"n_points must be a whole number in \[16, 2\^26\], got 15"),
        ({"n_points": 100.5}, "n_points must be a whole number .*, got 100.5"),
        ({"points": "volume"}, 'points must be "camera" or "area", got \'volume\''),
        ({"normals": "smooth"}, 'normals must be "geometric" or "shading", got \'smooth\''),
        ({"seed": -1}, r"seed must be in \[0, 2\^64\), got -1"),
        ({"threads": 0}, r"threads must be a whole number in \[1, 1024\], got 0"),
        ({"camera": "left"}, r"camera must be one of \[\], got 'left'"),
        ({"camera": 0, "points": "area"}, 'camera must be left out with points="area", got 0'),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    n = arguments.pop("n_points", 100)
    with pytest.raises(ValueError, match=message):
        points(convex(), n, **arguments)
    with pytest.raises(ValueError, match="scene must be a Scene, a file or a built-in name, got 5"):
        points(5, 100)
