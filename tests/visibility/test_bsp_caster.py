"""The BSP tracer gives Embree's hits, on any tree, at any scale, for any number of threads."""

import numpy as np
import pytest

import viscache as vc
from reference.built import built
from render.test_interrupt import LIMIT, quickest_stop
from viscache_lab.bench.ray_sets import SETS, make_ray_set
from visibility.soup import rays, soup


def excused(scene, o, d, ours, embree):
    """Which of some differing answers lie within rounding of an edge, or at almost equal t.

    A triangle one of them hit and the other did not is looked at in double precision.
    """
    corners = np.concatenate([m["vertices"][m["triangles"]] for m in scene.meshes()]).astype(float)
    reach = np.linalg.norm(np.diff(scene.bounds, axis=0))
    good = np.ones(len(o), bool)
    for found, other in ((ours, embree), (embree, ours)):
        hit = (found.triangle >= 0) & ~(other.t < found.t)  # the nearer of the two is in doubt
        a, b, c = (corners[found.triangle[hit], i] for i in range(3))
        p, w = o[hit].astype(float), d[hit].astype(float)
        n = np.cross(b - a, c - a)
        at = p + (np.einsum("nk,nk->n", n, a - p) / np.einsum("nk,nk->n", n, w))[:, None] * w
        edge = np.full(len(at), np.inf)
        for i, j in ((a, b), (b, c), (c, a)):
            e = j - i
            s = np.clip(np.einsum("nk,nk->n", at - i, e) / np.einsum("nk,nk->n", e, e), 0, 1)
            edge = np.minimum(edge, np.linalg.norm(at - i - s[:, None] * e, axis=1))
        length = np.linalg.norm(w, axis=1)
        near = np.abs(found.t[hit] - other.t[hit]) * length < 1e-5 * reach
        good[hit] &= (edge < 1e-6 * reach) | near
    return good


SCENES = [
    "random_triangles?triangles=20000",
    "bumpy_spheres?triangles=15000",
    "room?triangles=20000",
    "hairball?triangles=20000",
]


@pytest.mark.parametrize("spec", SCENES)
@pytest.mark.parametrize("kernel", ["watertight", "wald"])
def test_no_hit_differs_from_embrees_without_an_excuse(spec, kernel):
    scene = built(spec)
    caster = scene.caster(vc.Bsp(kernel=kernel))
    for name in SETS:
        r = make_ray_set(scene, name, 10_000)
        o, d = r.origins, r.directions
        ours, theirs = scene.intersect(o, d, rays=vc.Bsp(kernel=kernel)), scene.intersect(o, d)
        assert (theirs.triangle >= 0).any()
        differ = ours.triangle != theirs.triangle
        assert differ.mean() < 2e-3
        bad = ~excused(
            scene, o[differ], d[differ], *(type(x)(*(v[differ] for v in x)) for x in (ours, theirs))
        )
        assert bad.sum() == 0
        same = ~differ & (theirs.triangle >= 0)
        np.testing.assert_allclose(ours.t[same], theirs.t[same], rtol=1e-3, atol=1e-4)
        blocked = caster.occluded(o, d, r.t_max)
        assert (blocked != scene.occluded(o, d, r.t_max)).mean() < 1e-3
        if np.isinf(r.t_max):
            np.testing.assert_array_equal(blocked, ours.triangle >= 0)


def test_the_excuse_is_no_pardon_for_wrong_hits():
    """The control of the test above: hits of shifted rays are not excused."""
    scene = built(SCENES[0])
    r = make_ray_set(scene, "hemi", 2000)
    shifted = (r.origins + np.float32(0.01)).astype(np.float32)
    ours, theirs = (scene.intersect(o, r.directions) for o in (shifted, r.origins))
    differ = ours.triangle != theirs.triangle
    parts = (type(x)(*(v[differ] for v in x)) for x in (ours, theirs))
    assert differ.any()
    assert not excused(scene, r.origins[differ], r.directions[differ], *parts).all()


def test_the_tree_and_its_answers_do_not_depend_on_threads():
    scene = vc.scenes.random_triangles(triangles=5000)
    o, d = rays(20_000, along=True)
    answers = []
    for threads in (1, 2, 5):
        caster = vc.Bsp().build(scene, threads)
        hits = caster.intersect(o, d, threads)
        answers.append(
            (caster.stats, caster.count_steps(o[:500], d[:500]), *(part.tobytes() for part in hits))
        )
    assert answers[0] == answers[1] == answers[2]


def test_deeper_trees_test_fewer_triangles():
    scene = vc.scenes.random_triangles(triangles=5000)
    o, d = rays(2000, along=True)
    tests, bytes_used = [], []
    for depth in (2, 6, 10, 14):
        caster = scene.caster(vc.Bsp(max_depth=depth, leaf_size=2))
        assert caster.stats["depth"] == depth  # the limit is reached, and held
        tests.append(caster.count_steps(o, d)["tests"])
        bytes_used.append(caster.stats["bytes"])
    assert tests == sorted(tests, reverse=True) and tests[0] > 20 * tests[-1]
    assert bytes_used == sorted(bytes_used)


@pytest.mark.parametrize("kernel", ["watertight", "wald"])
def test_a_walk_ends_at_the_hit(kernel):
    """Behind it lie hundreds of walls, which a walk to the end would try."""
    walls, edge = 1000, np.float32([[-9, -9, 0], [9, -9, 0], [0, 9, 0]])
    vertices = (edge + np.arange(walls)[:, None, None] * [0, 0, 1]).reshape(-1, 3)
    scene = vc.Scene.from_arrays(vertices, np.arange(3 * walls).reshape(-1, 3))
    caster = scene.caster(vc.Bsp(max_depth=14, leaf_size=1, kernel=kernel))
    r = np.random.default_rng(0)
    start = r.integers(0, walls, 300)
    o = np.stack([*r.uniform(-1, 1, (2, 300)), start + 0.5], 1).astype(np.float32)
    d = np.stack([*r.uniform(-0.01, 0.01, (2, 300)), np.ones(300)], 1).astype(np.float32)
    for sign in (1, -1):
        d[:, 2] = sign
        hit = caster.intersect(o, d)[1]
        inside = (start + sign >= 0) & (start + (sign > 0) < walls)
        np.testing.assert_array_equal(hit[inside], (start + (sign > 0))[inside])
        steps = caster.count_steps(o, d)
        assert steps["tests"] <= 8 * len(o) and steps["nodes"] <= 40 * len(o)
    aside = o + np.float32([30, 0, 0])
    assert caster.count_steps(aside, d)["tests"] == 0
    far = np.stack([*r.uniform(-1, 1, (2, 9)), np.full(9, -5.0)], 1)
    up = np.broadcast_to(np.float32([0, 0, 1]), far.shape)
    assert caster.count_steps(far, up)["tests"] <= 8 * len(far)


def test_leaves_hold_no_more_triangles_than_asked_for():
    scene = vc.scenes.bumpy_spheres(triangles=3000)
    coarse, fine = (scene.caster(vc.Bsp(leaf_size=n)).stats for n in (64, 4))
    assert coarse["leaves"] < fine["leaves"] and coarse["depth"] <= fine["depth"]
    whole = scene.caster(vc.Bsp(leaf_size=1024, max_depth=40)).stats
    assert whole["references"] <= 1024 * whole["leaves"]


@pytest.mark.extreme
def test_scenes_without_volume_or_triangles_can_be_asked():
    o, d = rays(200)
    empty = vc.Scene.from_description(vc.SceneDescription())
    assert not empty.occluded(o, d, rays=vc.Bsp()).any()
    assert empty.caster(vc.Bsp()).stats["nodes"] == 0
    vertices, triangles = soup(200, 0.2)
    flat = vc.Scene.from_arrays(vertices * [1, 1, 0], triangles)
    ours, theirs = flat.intersect(o, d, rays=vc.Bsp()), flat.intersect(o, d)
    np.testing.assert_array_equal(ours.triangle >= 0, theirs.triangle >= 0)
    degenerate = vc.Scene.from_arrays([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2], [0, 0, 1]])
    assert not degenerate.occluded(o, d, rays=vc.Bsp()).any()
    assert degenerate.caster(vc.Bsp()).stats["degenerate"] == 2


@pytest.mark.extreme
def test_triangles_no_plane_tells_apart_end_in_one_leaf():
    """A thousand copies of two triangles over the whole scene: halving gains nothing."""
    square = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    scene = vc.Scene.from_arrays(square, [[0, 1, 2], [0, 2, 3]] * 1000)
    stats = scene.caster(vc.Bsp(max_depth=40)).stats
    assert stats["references"] < 400 * 2000
    hit = scene.intersect([[0.7, 0.2, 1]], [[0, 0, -1]], rays=vc.Bsp())
    assert hit.triangle == [0]  # the lowest of those at one t


@pytest.mark.extreme
def test_a_tree_that_would_take_hours_is_refused_in_seconds():
    """Many triangles side by side are in every cell of their slab; these double and double."""
    corners = np.random.default_rng(0).normal(size=(100, 3, 3)) * [0.3, 0.3, 0.01]
    corners += np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]])
    scene = vc.Scene.from_arrays(corners.reshape(-1, 3), np.arange(300).reshape(-1, 3))
    message = r"at max_depth 40 and leaf_size 8 .* lower max_depth"
    with pytest.raises(MemoryError, match=message):
        scene.caster(vc.Bsp(max_depth=40), threads=3)
    assert scene.caster(vc.Bsp()).stats["max_depth"] == 12
    with pytest.raises(MemoryError, match=r"max_bytes must hold the tree, got 10000 .* lower"):
        vc.scenes.random_triangles(triangles=5000).caster(vc.Bsp(max_bytes=10_000))


@pytest.mark.slow
def test_ctrl_c_ends_the_counting_of_steps_soon():
    call = (
        "(lambda o: scene.caster(vc.Bsp()).count_steps(o, o + np.float32(0.1)))"
        "(np.resize(np.random.default_rng(0).uniform(-2, 2, (100_000, 3)), (12_000_000, 3))"
        ".astype(np.float32))"
    )
    assert quickest_stop(f"import numpy as np; {call}", 1.2) < LIMIT


def test_rays_that_no_caster_could_trace_are_refused():
    caster, good = vc.scenes.cube_on_plane().caster(vc.Bsp()), np.ones((2, 3), np.float32)
    for bad in (np.nan, np.inf, 2e16):
        wrong = np.where([[False] * 3, [False, False, True]], np.float32(bad), good)
        with pytest.raises(ValueError, match="origins must be finite"):
            caster.occluded(wrong, good, np.inf)
        with pytest.raises(ValueError, match="directions must be finite"):
            caster.intersect(good, wrong)
    with pytest.raises(ValueError, match="equal numbers of rows"):
        caster.visible(good, good[:1])


@pytest.mark.parametrize("kernel", ["watertight", "wald"])
def test_rays_from_far_away_meet_what_lies_in_planes_of_the_tree(kernel):
    """A wall whose corners lie where planes of the tree meet, 100,000 widths away.

    There, the ways of a ray to two planes are wrong by more than a cell. A walk without slack takes
    planes in the wrong order and ends beside the wall: about 30 of these rays with the watertight
    kernel. Wald's test is so coarse there that a neighbouring triangle takes the hit.
    """
    n = 16
    x = np.linspace(0, 1, n + 1)
    wall = np.stack(np.meshgrid(x, x, [0.5], indexing="ij"), -1).reshape(-1, 3)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1)
    triangles = np.concatenate([corner[:, None] + k for k in ([0, 1, n + 2], [0, n + 2, n + 1])])
    d = np.random.default_rng(0).normal(size=(4000, 3))
    d[:, 2] = np.sign(d[:, 2]) * np.maximum(np.abs(d[:, 2]), 0.2)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    o = (0.5 - 1e5 * d).astype(np.float32)
    d = (0.5 - o).astype(np.float32)
    scene = vc.Scene.from_arrays(wall, triangles)
    caster = scene.caster(vc.Bsp(max_depth=16, leaf_size=1, kernel=kernel))
    assert caster.occluded(o, d, np.inf).all()
    assert (caster.intersect(o, d)[1] >= 0).all()
