"""Rays of the visibility field: the hits Embree finds, by whatever direction, tiles and leaves."""

import dataclasses
from functools import cache

import numpy as np
import pytest

import viscache as vc
from reference.built import built
from vlf.field_rays import flat, inexcusable, rays_of_every_kind, soup, unit

KINDS = ("chords", "interior", "grazing", "aligned", "axis-parallel")
SMALL = vc.Vlf(n_directions=33, n_tiles=32)
VARIANTS = {
    "default": {},
    "no depth": {"bsp_depth": 0},
    "dense depth 3": {"bsp_depth": 3, "leaf_target": 0},
    "medians": {"bsp_depth": 4, "split": "object", "leaf_target": 1},
    "stack": {"bsp_depth": 4, "leaf_target": 1, "walk": "stack"},
    "medians by stack": {"bsp_depth": 4, "leaf_target": 1, "split": "object", "walk": "stack"},
    "depth of the scene": {"bsp_depth": 4, "tile_ranges": False},
    "one tile": {"n_tiles": 1},
    "one direction": {"n_directions": 1},
    "three directions": {"n_directions": 3, "n_tiles": 100},
    "lazy": {"lazy": True},
    "room": {"head_room": 1.7},
    "boxes": {"fit": "psf_box"},
    "boxes, one direction, medians": {
        "fit": "psf_box",
        "n_directions": 1,
        "bsp_depth": 4,
        "split": "object",
        "leaf_target": 1,
    },
}


def field(scene, settings=SMALL, **changed):
    s = dataclasses.replace(settings, **changed)
    return vc.VisibilityField(
        scene, s.n_directions, s.n_tiles, s.bsp_depth, max_bytes=s.max_bytes, settings=s
    )


@pytest.fixture(scope="module", params=["soup", "room"])
def scene(request):
    if request.param == "soup":
        return vc.Scene.from_arrays(*soup(3000))
    return built("room?triangles=5000")


def compare(scene, f, rays, apart_by=1e-4):
    """Number of excused differences; fails on any other."""
    # Wald's records hold places from the scene's origin, the others from the ray's
    rounding = 1e-6 if f.settings.kernel == "watertight" else 4e-6
    ours = f.intersect(rays[:, 0], rays[:, 1])
    theirs = scene.intersect(rays[:, 0], rays[:, 1])
    differ = ours.triangle != theirs.triangle
    wrong = inexcusable(
        flat(scene),
        rays[differ],
        ours.triangle[differ],
        theirs.triangle[differ],
        ours.t[differ],
        theirs.t[differ],
        rounding,
    )
    assert not wrong.any(), rays[differ][wrong][:3]
    same = ~differ & (ours.triangle >= 0)
    assert same.any()
    size = np.linalg.norm(rays[same, 1], axis=1)
    radius = np.linalg.norm(np.ptp(scene.bounds, axis=0)) / 2
    apart = np.abs(ours.t[same] - theirs.t[same]) * size
    assert np.quantile(apart, 0.999) < apart_by * radius
    any_hit = f.occluded(rays[:, 0], rays[:, 1])
    np.testing.assert_array_equal(any_hit, ours.triangle >= 0)
    return int(differ.sum())


@cache
def fine_field(scene, kernel):
    return field(scene, kernel=kernel, n_directions=129, n_tiles=64)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("kernel", ["watertight", "wald"])
def test_hits_are_those_of_embree(scene, kernel, kind):
    f = fine_field(scene, kernel)
    rays = rays_of_every_kind(flat(scene), 20_000, 129)[kind]
    # Where rays run along surfaces, many pass an edge within rounding, and t is uncertain
    grazing = kind == "grazing"
    differ = compare(scene, f, rays, 1e-2 if grazing else 1e-4)
    assert differ <= (1e-2 if grazing else 1e-3) * len(rays)


@pytest.mark.release
def test_of_millions_of_rays_none_differs_without_excuse(scene):
    f, n, excused = field(scene, n_directions=513, n_tiles=128), 130_000, 0
    for seed in range(4):
        for kind, rays in rays_of_every_kind(flat(scene), n, 513, seed).items():
            found = compare(scene, f, rays, 1e-2 if kind == "grazing" else 1e-4)
            excused += found if kind in ("chords", "interior") else 0
    assert excused <= 2e-5 * 4 * n * len(KINDS)


@cache
def plain_hits(scene):
    """Rays of every kind, and their hits by the field of the smallest settings."""
    rays = np.concatenate(list(rays_of_every_kind(flat(scene), 2000, 33).values()))
    return rays, field(scene).intersect(rays[:, 0], rays[:, 1])


@pytest.mark.parametrize("variant", VARIANTS)
def test_answers_do_not_depend_on_how_the_lists_are_kept(scene, variant):
    rays, base = plain_hits(scene)
    f = field(scene, **VARIANTS[variant])
    found = f.intersect(rays[:, 0], rays[:, 1])
    for ours, theirs in zip(found, base, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    np.testing.assert_array_equal(f.occluded(rays[:, 0], rays[:, 1]), base.triangle >= 0)


def terrain(n=40, height=1e-3):
    """A nearly flat square of 2·n² triangles, long in x."""
    x, y = np.meshgrid(np.linspace(0, 8, n + 1), np.linspace(0, 1, n + 1))
    z = height * np.random.default_rng(2).random(x.shape)
    vertices = np.stack([x, y, z], -1).reshape(-1, 3).astype(np.float32)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1)
    quads = np.stack([a, a + 1, a + n + 2, a, a + n + 2, a + n + 1], 1)
    return vc.Scene.from_arrays(vertices, quads.reshape(-1, 3).astype(np.uint32))


def test_boxes_of_a_flat_scene_leave_fewer_triangles_to_test():
    scene = terrain()
    tests = {}
    for fit in ("sphere", "psf_box"):
        f = field(scene, fit=fit, bsp_depth=0)
        for kind, rays in rays_of_every_kind(flat(scene), 2000, 33).items():
            compare(scene, f, rays, 1e-2 if kind == "grazing" else 1e-4)
        rays = rays_of_every_kind(flat(scene), 2000, 33)["chords"]
        axes = np.argmax(np.abs(unit(rays[:, 1].astype(float)) @ vc.vlf.directions(33).T), axis=1)
        tests[fit] = f._core.trace_by(rays[:, 0], rays[:, 1], axes)[3]["tests"]
    assert tests["psf_box"] < 0.5 * tests["sphere"]


def test_a_ray_finds_the_same_hit_through_any_subfield(scene):
    rays = np.concatenate(list(rays_of_every_kind(flat(scene), 1000, 33).values()))
    f = field(scene)
    order = np.argsort(-np.abs(unit(rays[:, 1].astype(float)) @ vc.vlf.directions(33).T), axis=1)
    t, triangle, any_hit, steps, _ = f._core.trace_by(rays[:, 0], rays[:, 1], order[:, 0])
    assert 0.1 < any_hit.mean() < 1
    for k in (1, 9, 32):
        other = f._core.trace_by(rays[:, 0], rays[:, 1], order[:, k])
        np.testing.assert_array_equal(other[0], t)
        np.testing.assert_array_equal(other[1], triangle)
        np.testing.assert_array_equal(other[2], any_hit)
        assert other[3]["tiles"] > steps["tiles"]  # only the way is longer


def test_rays_at_edges_and_corners_of_a_closed_mesh_do_not_get_out():
    from render.mitsuba_scene import ball

    part = ball((0.1, 0.2, 0.3), 1.0, 16)
    scene = vc.Scene.from_arrays(part.vertices, part.triangles)
    a, b = part.vertices[part.triangles[:, 0]], part.vertices[part.triangles[:, 1]]
    w = np.linspace(0, 1, 33)[:, None, None]
    targets = (a * (1 - w) + b * w).reshape(-1, 3).astype(np.float32)
    for at in ([0.15, 0.1, 0.35], [0.8, 0.3, 0.2], [0.1, 0.2, 0.3]):
        origin = np.broadcast_to(np.float32(at), targets.shape)
        for settings in ({}, {"n_directions": 3, "n_tiles": 200, "bsp_depth": 6, "leaf_target": 1}):
            f = field(scene, **settings)
            assert f.occluded(origin, targets - origin).all()
            assert (f.intersect(origin, targets - origin).triangle >= 0).all()


def test_segments_hit_what_lies_strictly_inside_them():
    scene = vc.Scene.from_arrays(*soup(500, seed=2))
    f = field(scene)
    rays = rays_of_every_kind(flat(scene), 3000, 33)["chords"]
    t = f.intersect(rays[:, 0], rays[:, 1]).t
    rays, t = rays[np.isfinite(t)], t[np.isfinite(t)]
    assert len(t) > 400
    up, down = np.nextafter(t, np.float32(np.inf)), np.nextafter(t, np.float32(0))
    assert f.occluded(rays[:, 0], rays[:, 1], up).all()
    assert not f.occluded(rays[:, 0], rays[:, 1], t).any()
    assert not f.occluded(rays[:, 0], rays[:, 1], down).any()
    axes = vc.vlf.nearest_direction(rays[:, 1], 33)
    first = f._core.trace_by(rays[:, 0], rays[:, 1], axes, t_min=down, t_max=up)
    assert first[2].all() and np.isfinite(first[0]).all()
    after = f._core.trace_by(rays[:, 0], rays[:, 1], axes, t_min=t)
    assert (after[0] > t).all()
    empty = f._core.trace_by(rays[:, 0], rays[:, 1], axes, t_min=up, t_max=down)
    assert not empty[2].any()


def test_a_segment_that_ends_on_a_surface_sees_it():
    scene = vc.Scene.from_arrays(*soup(500, seed=3))
    f = field(scene)
    corners = flat(scene)
    weights = np.random.default_rng(1).dirichlet((1, 1, 1), len(corners))
    on = np.einsum("nk,nkc->nc", weights, corners).astype(np.float32)
    x = np.random.default_rng(2).uniform(-1, 1, on.shape).astype(np.float32)
    seen, ours = scene.visible(x, on), f.visible(x, on)
    assert 0.2 < seen.mean() < 0.95
    assert (seen != ours).mean() < 1e-2


@pytest.mark.parametrize("n", [1, 2, 15, 16, 17, 33])
def test_packets_and_threads_change_no_answer(n):
    scene = vc.Scene.from_arrays(*soup(500))
    rays = rays_of_every_kind(flat(scene), 20_000, 33)["chords"]
    for f in (field(scene), field(scene, lazy=True)):
        whole = f.intersect(rays[:, 0], rays[:, 1], threads=1)
        for threads in (2, 5):
            again = f.intersect(rays[:, 0], rays[:, 1], threads=threads)
            np.testing.assert_array_equal(again.t, whole.t)
        some = f.occluded(rays[:n, 0], rays[:n, 1])
        np.testing.assert_array_equal(some, whole.triangle[:n] >= 0)


def test_instances_are_placed_triangles_of_the_field():
    scene = vc.scenes.courtyard(triangles=30_000)
    r = np.random.default_rng(0)
    lo, hi = scene.bounds.astype(float)
    o = r.uniform(lo, hi, (20_000, 3)).astype(np.float32)
    d = r.normal(size=o.shape).astype(np.float32)
    f = field(scene)
    assert f.stats["triangles"] + f.stats["degenerate"] >= scene.triangles
    ours, theirs = f.intersect(o, d), scene.intersect(o, d)
    same = (ours.triangle == theirs.triangle) & (ours.instance == theirs.instance)
    assert same.mean() > 0.999 and (theirs.instance[same] >= 0).any()
    hit = same & (theirs.triangle >= 0)
    np.testing.assert_allclose(ours.t[hit], theirs.t[hit], rtol=2e-3)


@pytest.mark.extreme
def test_rays_from_far_away_hit_what_near_ones_hit():
    scene = vc.Scene.from_arrays(*soup(1000))
    f = field(scene)
    r = np.random.default_rng(4)
    direction = r.integers(-8, 9, (3000, 3)).astype(np.float32)
    direction[(direction == 0).all(1)] = [1, 2, 3]
    near = r.uniform(-0.5, 0.5, (3000, 3)).astype(np.float32)
    near = np.round(near * 64) / 64  # so that moving back is exact
    for far in (64.0, 1024.0, 16384.0):
        start = (near - np.float32(far) * direction).astype(np.float32)
        assert ((start + np.float32(far) * direction) == near).all()
        back = f.intersect((near - 4 * direction).astype(np.float32), direction)
        found = f.intersect(start, direction)
        hit = (found.triangle == back.triangle) & (back.triangle >= 0)
        assert (found.triangle == back.triangle).mean() > 0.998 and hit.any()
        shift = np.float32(far - 4)
        np.testing.assert_allclose(found.t[hit] - shift, back.t[hit], atol=2e-7 * far + 1e-5)


@pytest.mark.extreme
@pytest.mark.parametrize("n", [1, 3])
def test_rays_across_all_axes_come_to_an_end(n):
    """Where a ray hardly goes deeper, all leaves between its depths are visited, and no others."""
    vertices, triangles = soup(300)
    scene = vc.Scene.from_arrays(vertices, triangles)
    f = field(scene, n_directions=n, n_tiles=64, bsp_depth=6, leaf_target=1)
    r = np.random.default_rng(0)
    o = r.uniform(-1, 1, (20_000, 3)).astype(np.float32)
    d = r.normal(size=o.shape).astype(np.float32)
    d[:, 2] *= 10.0 ** -r.integers(0, 40, len(d)) * r.integers(-1, 2, len(d))
    d[:5000] = np.roll(d[:5000], 1, axis=1)
    rays = np.stack([o, d], 1)
    compare(scene, f, rays)


def test_flat_and_single_triangles_are_hit_and_those_without_area_counted():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.5, 0.5]]
    f = field(vc.Scene.from_arrays(vertices, [[0, 0, 0], [0, 1, 1], [0, 1, 2], [3, 3, 3]]))
    assert (f.stats["triangles"], f.stats["degenerate"]) == (1, 3)
    found = f.intersect([[0.2, 0.2, 1.0]], [[0.0, 0.0, -2.0]])
    assert found.triangle[0] == 2 and found.t[0] == pytest.approx(0.5, rel=1e-6)
    assert not f.occluded([[0.2, 0.2, 1.0]], [[0.0, 0.0, 0.0]])[0]
    # Its plane holds the ray: seen edge-on it is not there
    assert not f.occluded([[-1.0, 0.2, 0.0]], [[1.0, 0.0, 0.0]])[0]


def test_of_coincident_triangles_the_first_is_hit():
    vertices, triangles = soup(50)
    scene = vc.Scene.from_arrays(vertices, np.concatenate([triangles] * 3))
    f = field(scene, bsp_depth=4, leaf_target=1)
    rays = rays_of_every_kind(flat(scene), 2000, 33)["chords"]
    found = f.intersect(rays[:, 0], rays[:, 1]).triangle
    assert found.max() < 50 and (found >= 0).any()


def test_rays_that_cannot_be_used_are_refused_by_row():
    f = field(vc.Scene.from_arrays(*soup(10)))
    good, bad = [[0.0, 0.0, 0.0]] * 2, [[0.0, 0.0, 1.0], [np.nan, 0.0, 1.0]]
    for call, given, says in (
        (f.intersect, (good, bad), "directions must be finite and at most 1e16 in size, row 1"),
        (f.occluded, (bad, good), "origins must be finite"),
        (f.occluded, (good, good, -1.0), "t_max must be >= 0"),
    ):
        with pytest.raises(ValueError, match=says):
            call(*given)


def test_snapped_rays_are_those_along_their_nearest_axes():
    scene = vc.Scene.from_arrays(*soup(1000))
    rays = rays_of_every_kind(flat(scene), 4000, 129)["interior"]
    exact, snapped = (field(scene, n_directions=129, snap=s) for s in (False, True))
    axis = vc.vlf.directions(129)[vc.vlf.nearest_direction(rays[:, 1], 129)]
    sign = np.sign((axis * rays[:, 1]).sum(1, keepdims=True))
    along = (axis * sign * np.linalg.norm(rays[:, 1], axis=1, keepdims=True)).astype(np.float32)
    ours = snapped.intersect(rays[:, 0], rays[:, 1])
    theirs = exact.intersect(rays[:, 0], along)
    assert (ours.triangle == theirs.triangle).mean() > 0.999
    assert 0.05 < (ours.triangle != exact.intersect(rays[:, 0], rays[:, 1]).triangle).mean() < 0.9


def test_it_says_what_it_is():
    scene = vc.Scene.from_arrays(*soup(100))
    f = vc.VisibilityField(scene, 33, 16, 2, max_bytes=10 << 20)
    assert (f.n_directions, f.n_tiles, f.bsp_depth) == (33, 16, 2)
    assert repr(f).startswith("<viscache.VisibilityField l=33 n=16 depth=2: 100 triangles")
    s = f.stats
    assert (s["subfields"], s["tiles"]) == (33, 33 * 256)
    assert s["empty_tiles"] < s["tiles"] and s["references"] >= s["leaves"] > 0


def test_progress_is_told_and_can_stop_the_build():
    scene = vc.Scene.from_arrays(*soup(30_000))
    seen = []

    def stop(done, total):
        seen.append((done, total))
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        vc.VisibilityField(scene, progress=stop, threads=1)
    assert len(seen) == 1
    seen.clear()
    vc.VisibilityField(scene, 33, 16, progress=lambda *a: seen.append(a))
    assert seen[-1] == (33, 33)


@pytest.mark.parametrize("visibility", [vc.Exact(), vc.Aqvc(c_e=4)])
@pytest.mark.parametrize(
    "integrator", [vc.Whitted(n_vpls=16), vc.AmbientOcclusion(n_samples=8, max_distance=2.0)]
)
def test_frames_through_the_field_are_those_through_embree(visibility, integrator):
    scene = built("room?triangles=3000")
    rays = vc.Vlf(n_directions=129, n_tiles=64)
    if isinstance(visibility, vc.Aqvc) and isinstance(integrator, vc.AmbientOcclusion):
        visibility = vc.Aqvc(c_e=2)
    frames = [
        vc.render(scene, integrator, rays=r, visibility=visibility, size=(64, 40), threads=t)
        for r, t in ((None, None), (rays, 1), (rays, 2))
    ]
    assert frames[1].sha256 == frames[2].sha256
    assert frames[1].parameters["rays"]["name"] == "Vlf"
    # Hits agree within rounding, but a ray at an edge may go either way
    a, b = frames[0].image, frames[1].image
    assert (np.abs(a - b) > 1e-3 * a.mean()).any(axis=2).mean() < 0.02
    assert a.mean() > 0 and abs(a.mean() / b.mean() - 1) < 1e-3
