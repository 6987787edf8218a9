"""Aligned rays: the bits of single rays, watertight, the same from every variant, and Embree's."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from correlation.scenes import clutter, convex, masked
from reference.built import built
from reference.isas import AVAILABLE
from reference.vlf_aligned import corners, free_along, origins
from render.test_interrupt import LIMIT, quickest_stop
from vlf.aligned_scenes import batch, embree, frames_of, surface, unexcused, unpacked

Array = npt.NDArray[Any]


def expected(scene, points, normals, frames, **more):
    o = origins(scene, points, normals)
    return free_along(corners(scene), o, normals, frames, **more)


def grid(cells):
    """Axis-parallel squares over each other: corners and edges lie over each other along z."""
    t = np.linspace(-1, 1, cells + 1, dtype=np.float32)
    x, y = np.meshgrid(t, t)
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    quads = np.stack([a, a + 1, a + cells + 2, a, a + cells + 2, a + cells + 1], 1)
    flat = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1)
    both = np.concatenate([flat, flat + np.array([0, 0, 1])])
    faces = quads.reshape(-1, 3)
    return vc.Scene.from_arrays(both, np.concatenate([faces, faces + len(flat)]))


@pytest.mark.parametrize(
    ("n_directions", "n_points"),
    [*((k, n) for k in (1, 9, 33) for n in (0, 1, 15, 16, 17, 200)), (129, 20), (513, 20)],
)
def test_the_batch_says_what_single_rays_say(n_directions, n_points):
    """Test 9, with packets filled up and not."""
    scene = clutter(n=301)
    points, normals = surface(scene, n_points)
    frames = frames_of(n_directions)
    found = batch(scene, points, normals, frames)
    np.testing.assert_array_equal(found, expected(scene, points, normals, frames))
    if n_points == 200 and n_directions == 33:
        assert 0.1 < found.mean() < 0.9


@pytest.mark.parametrize("n", [1, 2, 15, 16, 17, 31])
def test_blocks_of_triangles_may_be_part_full(n):
    scene = clutter(seed=n, n=n)
    points, normals = surface(scene, 100)
    found = batch(scene, points, normals, frames_of(9))
    np.testing.assert_array_equal(found, expected(scene, points, normals, frames_of(9)))


def test_corners_and_edges_right_above_a_point_decide_as_single_rays_do():
    """Edge functions of 0, which double decides: points under corners, edges and diagonals."""
    scene = grid(4)
    t = np.linspace(-1.25, 1.25, 21, dtype=np.float32)
    x, y = np.meshgrid(t, t)
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel() + 0.5], 1).astype(np.float32)
    normals = np.tile(np.float32([0, 0, 1]), (len(points), 1))
    frames = np.eye(3, dtype=np.float32)[None]
    bits, work = scene.aligned_batch().rows(scene._core, points, normals, frames)
    assert work["exact"] > 100
    found = unpacked(bits, 1)
    np.testing.assert_array_equal(found, expected(scene, points, normals, frames))
    np.testing.assert_array_equal(found[:, 0], np.abs(points[:, :2]).max(1) > 1)


@pytest.mark.parametrize("t_max", [0.05, 0.3, 1.0, 1e9])
def test_t_max_ends_the_rays(t_max):
    scene = clutter()
    points, normals = surface(scene, 150)
    found = batch(scene, points, normals, frames_of(33), t_max=t_max)
    np.testing.assert_array_equal(
        found, expected(scene, points, normals, frames_of(33), t_max=t_max)
    )
    endless = batch(scene, points, normals, frames_of(33))
    assert (found >= endless).all()
    assert (found != endless).any() == (t_max < 2)


def test_a_blocker_counts_up_to_t_max():
    scene = grid(2)
    points, normals = np.float32([[0.3, 0.2, 0]]), np.float32([[0, 0, 1]])
    frames = np.eye(3, dtype=np.float32)[None]
    seen = [
        bool(batch(scene, points, normals, frames, t_max=t)[0, 0])
        for t in (0.5, 0.9999, 1.0001, 2.0)
    ]
    assert seen == [True, True, False, False]


def test_threads_and_instruction_sets_change_no_bit():
    scene = vc.scenes.bumpy_spheres(triangles=3000)
    given = (scene._core, *surface(scene, 2000), frames_of(129))
    rows = scene.aligned_batch().rows
    for t_max in (np.inf, 0.4):
        base, work = rows(*given, t_max=t_max, threads=1)
        for isa in AVAILABLE:
            for threads in (1, 3, 8):
                bits, again = rows(*given, t_max=t_max, threads=threads, isa=isa)
                np.testing.assert_array_equal(bits, base)
                assert again == work


def closed(without=None):
    """A closed mesh around the origin, or but for one triangle, and its corners (T, 3, 3).

    Coordinates lie on a grid that survives the move to the scene's centre, so that rays along z
    meet corners and middles of edges exactly.
    """
    mesh = convex().meshes()[0]
    vertices = np.round(np.asarray(mesh["vertices"]) * 1024) / 1024
    faces = np.asarray(mesh["triangles"])
    kept = faces if without is None else np.delete(faces, without, axis=0)
    return vc.Scene.from_arrays(vertices, kept), vertices[faces].astype(np.float32)


def inside(n, seed=0):
    r = np.random.default_rng(seed)
    points = r.uniform(-0.3, 0.3, (n, 3)).astype(np.float32)
    normals = r.normal(size=(n, 3))
    return points, (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)


def test_no_ray_leaves_a_closed_mesh():
    points, normals = inside(20_000)
    assert not batch(closed()[0], points, normals, frames_of(129)).any()
    assert batch(closed(without=7)[0], points, normals, frames_of(129)).any()


@pytest.mark.parametrize("which", ["corners", "edges", "middles"])
def test_no_ray_leaves_a_closed_mesh_where_triangles_meet(which):
    """Test 7: rays aimed exactly at corners and edges; through a missing triangle one does."""
    scene, triangles = closed()
    if which == "corners":
        aims = triangles.reshape(-1, 3)
    elif which == "edges":
        aims = ((triangles + np.roll(triangles, 1, axis=1)) / 2).reshape(-1, 3)
    else:
        aims = triangles.mean(1)
    points = (aims * [1, 1, 0]).astype(np.float32)
    within = np.hypot(points[:, 0], points[:, 1]) < 0.8
    frames, up = np.eye(3, dtype=np.float32)[None], np.float32([0, 0, 1])
    for side in (1, -1):
        normals = np.tile(side * up, (within.sum(), 1))
        bits, work = scene.aligned_batch().rows(scene._core, points[within], normals, frames)
        assert not bits.any()
        assert (work["exact"] > within.sum() / 4) == (which != "middles")
    if which == "middles":
        top = int(np.argmax(triangles.mean(1)[:, 2]))
        found = batch(closed(without=top)[0], points[top : top + 1], up[None], frames)
        assert found.all()


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_points_of_a_convex_body_do_not_block_themselves(scale):
    scene = convex(scale)
    at = vc.correlation.surface_points(scene, 2000, points="area")
    assert batch(scene, at.positions, at.normals, frames_of(129)).all()
    assert not batch(scene, at.positions, -at.normals, frames_of(129)).all(1).any()


@pytest.mark.extreme
@pytest.mark.parametrize("scale", [1e-12, 1e-6, 1e6, 1e11])
def test_scale_changes_next_to_nothing(scale):
    """Test 11; a power of two nearby changes nothing at all."""
    two = 2.0 ** round(np.log2(scale))
    r = np.random.default_rng(1)
    vertices = (r.uniform(-1, 1, (200, 1, 3)) + r.normal(0, 0.3, (200, 3, 3))).reshape(-1, 3)
    faces = np.arange(600).reshape(-1, 3)
    scenes = {s: vc.Scene.from_arrays(vertices * s, faces) for s in (1.0, scale, two)}
    points, normals = surface(scenes[1.0], 500)
    of = {
        s: batch(scenes[s], (points * s).astype(np.float32), normals, frames_of(33)) for s in scenes
    }
    np.testing.assert_array_equal(of[two], of[1.0])
    assert (of[scale] != of[1.0]).mean() < 1e-4


@pytest.mark.extreme
def test_far_from_the_origin_a_convex_body_still_sees_the_sky():
    """At 1e5 sizes rounded vertices make it slightly less convex."""
    scene = convex(1.0, at=(1e5, -1e5, 1e5), vertices=60)
    at = vc.correlation.surface_points(scene, 2000, points="area")
    assert batch(scene, at.positions, at.normals, frames_of(129)).mean() > 1 - 2e-3


def test_a_triangle_seen_edge_on_is_not_hit():
    wall = np.float32([[0, -1, 1], [0, 1, 1], [0, 0, 2], [-3, -3, 5], [3, -3, 5], [0, 3, 5]])
    scene = vc.Scene.from_arrays(wall, np.array([[0, 1, 2]]))
    points, normals = np.float32([[0, 0, 0]]), np.float32([[0, 0, 1]])
    frames = np.eye(3, dtype=np.float32)[None]
    assert batch(scene, points, normals, frames).all()
    roofed = vc.Scene.from_arrays(wall, np.array([[0, 1, 2], [3, 4, 5]]))
    assert not batch(roofed, points, normals, frames).any()


def test_an_axis_at_right_angles_to_the_normal_runs_up():
    scene = grid(2)
    points, normals = np.float32([[0.3, 0.2, 0.5]]), np.float32([[1, 0, 0]])
    frames = np.eye(3, dtype=np.float32)[None]
    assert not batch(scene, points, normals, frames).any()
    assert batch(scene, points + np.float32([0, 0, 1]), normals, frames).all()
    assert embree(scene, points + np.float32([0, 0, 1]), normals, frames).all()


def test_an_empty_scene_hides_nothing():
    scene = vc.Scene.from_arrays(np.zeros((0, 3)), np.zeros((0, 3), int))
    points, normals = inside(100)
    rows = vc.aligned_occlusion(scene, points * 1e9, normals, 33)
    assert unpacked(rows, 33).all()


def hall(seed=0):
    """A closed room of large walls with boards, slats and clutter in it, and points inside."""
    r = np.random.default_rng(seed)
    cube = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    walls = [cube[[q[i] for i in t]] for q in quads for t in ((0, 1, 2), (0, 2, 3))]
    boards = r.uniform(-0.9, 0.9, (20, 3, 3))
    slats = r.uniform(-0.8, 0.8, (20, 1, 3)) + np.array([[0, 0, 0], [0.9, 0, 0], [0.9, 1e-3, 0]])
    clutter = r.uniform(-0.9, 0.9, (150, 1, 3)) + r.normal(0, 0.05, (150, 3, 3))
    triangles = np.concatenate([np.array(walls[:-1]), boards, slats, clutter])
    faces = np.arange(3 * len(triangles)).reshape(-1, 3)
    points = r.uniform(-0.95, 0.95, (900, 3)).astype(np.float32)
    normals = r.normal(size=(900, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return vc.Scene.from_arrays(triangles.reshape(-1, 3), faces), points, normals.astype(np.float32)


@pytest.mark.parametrize("t_max", [np.inf, 1.0])
def test_what_large_triangles_cover_at_once_is_what_single_rays_hit(t_max):
    """Walls settle whole nodes, and points that are left are packed anew: no bit may change."""
    scene, points, normals = hall()
    frames = frames_of(129, 12)
    found = batch(scene, points, normals, frames, t_max=t_max)
    np.testing.assert_array_equal(found, expected(scene, points, normals, frames, t_max=t_max))
    assert 0 < found.mean() < (0.3 if t_max == np.inf else 0.9)
    for isa in AVAILABLE:
        np.testing.assert_array_equal(
            batch(scene, points, normals, frames, t_max=t_max, isa=isa), found
        )


def slivers(n=200):
    """Fans of triangles a thousand times longer than wide: depths along an axis would turn."""
    random = np.random.default_rng(8)
    tip = random.uniform(-1, 1, (n, 3))
    along, side = random.normal(size=(2, n, 3))
    along /= np.linalg.norm(along, axis=1)[:, None]
    side -= (side * along).sum(1)[:, None] * along
    side *= (1e-3 / np.linalg.norm(side, axis=1))[:, None]
    vertices = np.stack([tip, tip + along, tip + along + side], 1).reshape(-1, 3)
    return vc.Scene.from_arrays(vertices, np.arange(3 * n).reshape(n, 3))


SCENES = {
    "slivers": slivers,
    "spheres": lambda: vc.scenes.bumpy_spheres(triangles=15_000),
    "triangles": lambda: vc.scenes.random_triangles(triangles=10_000),
    "room": lambda: built("room?triangles=20000"),
    "courtyard": lambda: vc.scenes.courtyard(triangles=20_000),
    "church": vc.scenes.church,
    "masks": lambda: masked(0.37),
}


def build(name):
    made = SCENES[name]()
    return made if isinstance(made, vc.Scene) else vc.Scene.from_description(made)


@pytest.mark.parametrize(
    ("name", "t_max", "n_points", "axes"),
    [
        *((name, t, 6000, 64) for name in ("spheres", "triangles", "room") for t in (np.inf, 0.3)),
        *(("slivers", t, 3000, 129) for t in (np.inf, 0.3)),
        *(
            pytest.param(name, np.inf, 10_000, 513, marks=pytest.mark.release)  # 5 million rays
            for name in ("spheres", "triangles", "room", "church")
        ),
    ],
)
def test_robust_embree_agrees_but_for_rounding(name, t_max, n_points, axes):
    """Test 4: every disagreement is held against a check in double."""
    scene = build(name)
    points, normals = surface(scene, n_points, seed=5)
    frames = frames_of(513, axes)
    ours = batch(scene, points, normals, frames, t_max=t_max)
    theirs = embree(scene, points, normals, frames, t_max=t_max)
    differing, bad = unexcused(scene, points, normals, frames, ours, theirs, t_max)
    assert bad == 0
    if name != "slivers":
        assert differing <= 1e-5 * ours.size + 3
        assert 0.02 < ours.mean() < 0.98


@pytest.mark.parametrize("name", ["courtyard", "masks"])
def test_instances_and_alpha_masks_are_embrees(name):
    scene = build(name)
    at = vc.correlation.surface_points(scene, 5000, points="area")
    frames = frames_of(513, 40)
    for side in (1, -1):
        normals = side * at.normals
        ours, theirs = (f(scene, at.positions, normals, frames) for f in (batch, embree))
        assert (ours != theirs).mean() < 2e-5
        assert ours.mean() > 0.02
    assert not ours.all()


def test_embrees_orders_and_packets_give_the_same_bits():
    scene = build("room")
    points, normals = surface(scene, 777)
    frames = frames_of(33)
    base = embree(scene, points, normals, frames)
    for by_axis in (True, False):
        for width in (8, 16):
            for coherent in (True, False):
                way = {"by_axis": by_axis, "width": width, "coherent": coherent}
                found = embree(scene, points, normals, frames, **way, threads=2)
                np.testing.assert_array_equal(found, base)
    o = origins(scene, points, normals)
    side = np.where((normals @ frames[7, 2]) >= 0, 1, -1)[:, None]
    np.testing.assert_array_equal(~scene.occluded(o, side * frames[7, 2]), base[:, 7])


def test_rows_say_who_traced_them():
    scene = clutter()
    points, normals = surface(scene, 100)
    for engine in ("batch", "embree"):
        rows = vc.vlf.trace_aligned(scene, points, normals, 33, engine=engine)
        assert rows.engine == engine and rows.reason == "asked for"
        assert rows.n_rays == 3300 and rows.bits.shape == (100, 1)
        np.testing.assert_array_equal(
            rows.bits, vc.aligned_occlusion(scene, points, normals, 33, engine=engine)
        )


def test_progress_counts_axes_to_the_end():
    seen = []
    scene = vc.scenes.bumpy_spheres(triangles=20_000)
    given = (scene, *surface(scene, 20_000), 513)
    told = {"progress": lambda *at: seen.append(at)}
    vc.aligned_occlusion(*given, threads=1, engine="batch", **told)  # type: ignore[arg-type]
    assert seen[-1] == (513, 513) and seen == sorted(seen)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["batch", "embree"])
def test_ctrl_c_stops_the_tracing_soon(engine):
    call = (
        "(lambda at: vc.aligned_occlusion(scene, at.positions, at.normals, 8193, "
        f"engine='{engine}'))(vc.correlation.surface_points(scene, 1 << 18))"
    )
    assert quickest_stop(call, 1.5) < LIMIT


ONE = [[0.0, 0.0, 1.0]]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"normals": [[0, 0, 2.0]]}, "normals must be unit vectors, row 0 has length 2"),
        ({"normals": [[0, 0, np.nan]]}, "normals must be finite and at most 1e16 in size, row 0"),
        ({"normals": ONE * 2}, r"points and normals must have equal numbers of rows, got \(1"),
        ({"points": [[np.nan, 0, 0]]}, "points must be finite and at most 1e16 in size, row 0"),
        ({"points": [[1e15, 0, 0]]}, "points must lie within 1e9 times the scene's size, row 0"),
        ({"points": np.zeros((1, 2))}, r"points must have shape \(N, 3\), got \(1, 2\)"),
        ({"t_max": 0.0}, "t_max must be > 0, got 0"),
        ({"t_max": np.nan}, "t_max must be > 0, got nan"),
        ({"threads": -1}, r"threads must be a whole number in \[1, 1024\], got -1"),
        ({"scene": 5}, "scene must be a Scene, a file or a built-in name, got 5"),
        ({"engine": "gpu"}, 'engine must be "auto", "batch", "embree" or "field"'),
        ({"n_directions": 512}, "n_directions must be one of 1, 3, 9"),
    ],
)
def test_what_cannot_be_traced_is_refused(arguments, message):
    given = {
        "scene": clutter(),
        "points": ONE,
        "normals": ONE,
        "n_directions": 9,
        "engine": "batch",
    }
    with pytest.raises(ValueError, match=message):
        vc.aligned_occlusion(**(given | arguments))


def test_frames_must_be_orthonormal():
    scene = clutter()
    one = np.float32(ONE)
    for frame in (2 * np.eye(3), np.diag([1, 1, -1]), np.full((3, 3), np.nan)):
        with pytest.raises(ValueError, match="frames must be orthonormal"):
            scene.aligned_batch().rows(scene._core, one, one, frame[None])
    with pytest.raises(ValueError, match=r"frames must have shape \(l, 3, 3\), got \(3, 3\)"):
        scene.aligned_batch().rows(scene._core, one, one, np.eye(3))
