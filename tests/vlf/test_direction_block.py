"""Any directions that points share, through the batch: single rays' bits, opposites together."""

import numpy as np
import pytest

import viscache as vc
from core import testing
from correlation.scenes import above, clutter, masked, unpacked
from reference.built import built
from reference.isas import AVAILABLE
from reference.vlf_aligned import corners, excused, origins
from viscache import _core
from viscache.correlation.rows import trace_rows
from vlf.aligned_scenes import surface

SKY = vc.correlation.DirectionSet(map_size=24)


def by_batch(scene, points, normals, directions, **more):
    """(bits, rays) by the batch."""
    bits, rays, is_batch, *_ = _core.correlation.aligned_rows(
        scene._core,
        scene.aligned_batch(),
        scene.caster(),
        points,
        normals,
        directions,
        choose=False,
        **more,
    )
    assert is_batch
    return bits, rays


def by_embree(scene, points, normals, directions, **m):
    return _core.correlation.visibility_rows(
        scene._core, scene.caster(), points, normals, directions, **m
    )


@pytest.mark.parametrize("kind", ["centres", "jittered", "lloyd"])
@pytest.mark.parametrize("map_size", [1, 7, 24, 96])
def test_every_direction_has_one_axis_and_opposites_share_theirs(kind, map_size):
    sky = vc.correlation.DirectionSet(map_size=map_size, kind=kind).directions
    axes = testing.shared_axes(sky)
    paired = axes[:, 1] >= 0
    used = np.concatenate([axes[:, 0], axes[paired, 1]])
    np.testing.assert_array_equal(np.sort(used), np.arange(len(sky)))
    assert np.abs(sky[axes[paired, 0]] + sky[axes[paired, 1]]).max(initial=0) <= 3e-7
    # Centres of cells of an even map are symmetric, if not to the last digit
    even = kind == "centres" and map_size % 2 == 0
    assert paired.all() == even and len(axes) == (len(sky) // 2 if even else len(sky))


def test_the_nearest_is_not_taken_for_the_opposite():
    d = np.float32([[1, 0, 0], [1, 0, 0], [-1, 1e-5, 0], [0, 0, -1], [-1, 1e-7, 0], [-1, 0, 0]])
    np.testing.assert_array_equal(testing.shared_axes(d), [[0, 4], [1, 5], [2, -1], [3, -1]])


SCENES = ["bumpy_spheres?triangles=3000", "random_triangles?triangles=3000", "room?triangles=8000"]


@pytest.mark.parametrize("spec", SCENES)
@pytest.mark.parametrize(("kind", "t_max"), [("centres", np.inf), ("jittered", 0.7)])
def test_no_row_differs_from_embrees_without_an_excuse(spec, kind, t_max):
    """Test 4, with the judge in double of the batch's own tests."""
    scene = built(spec)
    sky = vc.correlation.DirectionSet(map_size=32, kind=kind).directions
    points, normals = surface(scene, 1500)
    ours, rays = by_batch(scene, points, normals, sky, t_max=t_max)
    theirs, same_rays = by_embree(scene, points, normals, sky, t_max=t_max)
    assert rays == same_rays == above(normals, sky).sum()
    a, b = unpacked(ours, len(sky)), unpacked(theirs, len(sky))
    assert 0.02 < a.sum() / rays < 0.99
    assert not a[~above(normals, sky)].any()
    assert not unpacked(ours, 64 * ours.shape[1])[:, len(sky) :].any()
    triangles, o = corners(scene), origins(scene, points, normals)
    size = float(np.linalg.norm(np.ptp(triangles.reshape(-1, 3), axis=0))) / 2
    differing = np.argwhere(a != b)
    assert len(differing) <= 1e-5 * rays + 3
    for i, k in differing:
        assert excused(triangles, o[i], sky[k], 1e-6 * size, t_max)


@pytest.mark.parametrize("kind", ["centres", "jittered"])
def test_alpha_masks_and_few_points_are_embrees(kind):
    scene = masked(0.25)
    at = vc.correlation.surface_points(scene, 300, points="area")
    sky = vc.correlation.DirectionSet(map_size=17, kind=kind).directions
    for n in (0, 1, 16, 300):
        ours, _ = by_batch(scene, at.positions[:n], at.normals[:n], sky)
        theirs, _ = by_embree(scene, at.positions[:n], at.normals[:n], sky)
        np.testing.assert_array_equal(ours, theirs)


def test_threads_instruction_sets_and_the_order_of_points_change_no_byte():
    scene = vc.scenes.bumpy_spheres(triangles=2000)
    points, normals = surface(scene, 2500)
    for kind in ("centres", "lloyd"):
        sky = vc.correlation.DirectionSet(map_size=20, kind=kind).directions
        base, rays = by_batch(scene, points, normals, sky, threads=1)
        for isa in AVAILABLE:
            for threads in (1, 2, 5):
                bits, again = by_batch(scene, points, normals, sky, threads=threads, isa=isa)
                assert bits.tobytes() == base.tobytes() and again == rays
        turned = np.random.default_rng(0).permutation(len(points))
        bits, _ = by_batch(scene, points[turned], normals[turned], sky)
        np.testing.assert_array_equal(bits, base[turned])


def test_a_point_that_asks_both_of_two_opposites_gets_both():
    """Where opposites cancel but for the last digit, both may lie above a plane."""
    scene = clutter(n=400)
    sky = vc.correlation.DirectionSet(map_size=96).directions
    axes = testing.shared_axes(sky)
    rest = sky[axes[:, 0]] + sky[axes[:, 1]]
    pairs = axes[(rest != 0).any(1)][::60]
    r = np.random.default_rng(0)
    n = np.cross(sky[pairs[:, 0]], r.normal(size=(300, len(pairs), 3))).reshape(-1, 3)
    n = (n / np.linalg.norm(n, axis=1, keepdims=True)).astype(np.float32)
    few = np.ascontiguousarray(sky[pairs.ravel()])
    both = (above(n, few).reshape(len(n), -1, 2)).all(2)
    normals = n[both.any(1)][:300]
    assert len(normals) > 100
    points = r.uniform(-1, 1, (len(normals), 3)).astype(np.float32)
    ours, rays = by_batch(scene, points, normals, few)
    theirs, _ = by_embree(scene, points, normals, few)
    assert rays == above(normals, few).sum()
    np.testing.assert_array_equal(ours, theirs)
    asked = above(normals, few).reshape(len(normals), -1, 2).all(2)
    seen = unpacked(ours, len(few)).reshape(len(normals), -1, 2)[asked]
    assert {(bool(a), bool(b)) for a, b in seen} >= {(True, False), (False, True)}


def test_rows_say_who_traced_them_and_why():
    scene = vc.scenes.bumpy_spheres(triangles=3000)
    points, normals = surface(scene, 1200)
    found = {
        engine: trace_rows(scene, points, normals, SKY, engine=engine)
        for engine in ("embree", "batch", "field", "auto")
    }
    for engine in ("embree", "batch", "field"):
        assert found[engine].engine == engine and found[engine].reason == "asked for"
        differing = unpacked(found[engine].bits ^ found["embree"].bits, 576).sum()
        assert differing <= 1e-5 * found[engine].n_rays
        assert found[engine].n_rays == found["embree"].n_rays
    auto = found["auto"]
    assert auto.reason.startswith("predicted ns per ray: batch ")
    np.testing.assert_array_equal(auto.bits, found[auto.engine].bits)
    again = [trace_rows(scene, points, normals, SKY, engine="auto", threads=t) for t in (1, 3)]
    assert {a.reason for a in again} == {auto.reason}


def test_many_points_before_few_triangles_go_through_the_batch_and_few_do_not():
    scene = vc.scenes.cornell_box()
    points, normals = surface(scene, 8000)
    if _core.active_isa() == "avx512":
        assert trace_rows(scene, points, normals, SKY, engine="auto").engine == "batch"
    large = vc.scenes.bumpy_spheres(triangles=100_000)
    few = trace_rows(large, *surface(large, 50), SKY, engine="auto")
    assert few.engine == "embree" and few.reason.startswith("too few points")
    far = np.float32([[1e15, 0, 0]]), np.float32([[0, 0, 1]])
    assert trace_rows(scene, *far, SKY, engine="auto").engine == "embree"
    with pytest.raises(ValueError, match="points must lie within 1e9 times the scene's size"):
        trace_rows(scene, *far, SKY, engine="batch")
    with pytest.raises(ValueError, match='engine must be "embree", "batch", "field" or "auto"'):
        trace_rows(scene, points, normals, SKY, engine="gpu")  # type: ignore[arg-type]
