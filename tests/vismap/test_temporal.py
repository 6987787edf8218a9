"""Records over frames: counted errors, removal, disuse."""

import numpy as np
import pytest

import viscache as vc
from core import testing
from correlation.scenes import above, unpacked
from render.mitsuba_scene import Model, box, quad
from viscache import _core
from vismap.scenes import SIZE, made, pixels, same, view


def tallied(cache, rays, misses):
    n = len(cache)
    full = [np.broadcast_to(np.asarray(v, np.uint32), (n,)).copy() for v in (rays, misses)]
    cache._core.tally(*full, np.zeros(n, np.uint8), cache.frame)


def exact(cache, points, directions):
    """What exact rays see from points (N) along directions (N, K), 0 below the surface."""
    x, n = points.positions, points.normals
    size = np.maximum(np.abs(x).max(1), np.float32(cache.scene._core.offset_extent))
    origins = x + n * (np.float32(8 * 2.0**-23) * size)[:, None]
    count = directions.shape[1]
    hit = cache.scene.occluded(origins.repeat(count, 0), directions.reshape(-1, 3))
    up = (directions * n[:, None]).sum(-1) > 0
    return np.asarray(~hit.reshape(-1, count) & up)


def test_every_ray_counts_once_for_every_blended_record():
    cache, _ = made()
    points = pixels(cache)
    points = points.take(np.flatnonzero(points.d_max > 0)[:60])
    found = cache.lookup(points.positions, points.normals, points.d_max)
    random = np.random.default_rng(1)
    directions = random.normal(size=(60, 50, 3)).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    visible = exact(cache, points, directions)
    rays, misses = cache.compare(found, directions, visible)

    maps = unpacked(cache.records().bits, 1024)
    expected = np.zeros((2, len(cache)), int)
    for i in range(60):
        cells = cache.cells(directions[i])
        for record in found.ids[i][found.beta[i] > 0]:
            expected[0, record] += 50
            expected[1, record] += (maps[record, cells] != visible[i]).sum()
    r = cache.records()
    np.testing.assert_array_equal(r.rays, expected[0])
    np.testing.assert_array_equal(r.misses, expected[1])
    assert (rays, misses) == tuple(expected.sum(axis=1))
    assert 0.005 < misses / rays < 0.2
    # Inverted answers are wrong where the true ones were right
    assert cache.compare(found, directions, ~visible) == (rays, rays - misses)


def test_records_are_never_wrong_about_their_own_rays():
    cache, _ = made()
    r = cache.records()
    own = _core.vismap.CachePoints(
        r.positions, r.normals, np.full(len(r.rays), 1e-6, np.float32), np.zeros(len(r.rays))
    )
    found = cache.lookup(r.positions, r.normals, 1e-6)
    assert (found.ids[:, 0] == np.arange(len(cache))).all() and (found.ids[:, 1] < 0).all()
    directions = np.tile(cache.directions, (len(cache), 1, 1))
    facing = np.stack([above(n[None], cache.directions)[0] for n in r.normals])
    visible = exact(cache, own, directions) & facing
    assert cache.compare(found, directions, visible)[1] == 0


@pytest.mark.parametrize("eps_max", [0.05, 0.25])
def test_records_go_above_the_share_and_only_after_enough_rays(eps_max):
    cache, _ = made(eps_max=eps_max, n_startup=8, delta_max=1.0, w_min=0.0)
    n = len(cache)
    rays = np.full(n, 100, np.uint32)
    misses = np.full(n, round(100 * eps_max), np.uint32)  # just at the share: stays
    misses[2] += 1
    rays[3], misses[3] = 63, 63  # too few rays
    rays[4], misses[4] = 64, 64
    tallied(cache, rays, misses)
    kept = np.delete(np.arange(n), [2, 4])
    before = cache.records()
    removed = cache.end_frame()
    assert (removed["wrong"], removed["unused"]) == (2, 0)
    assert (removed["rays"], removed["misses"]) == (rays.sum(), misses.sum())
    after = cache.records()
    np.testing.assert_array_equal(after.positions, before.positions[kept])
    np.testing.assert_array_equal(after.bits, before.bits[kept])
    np.testing.assert_array_equal(after.rays, rays[kept])
    # The tree knows the new numbers
    found = cache.lookup(after.positions, after.normals, 1e-6)
    np.testing.assert_array_equal(found.ids[:, 0], np.arange(n - 2))


def test_the_interval_spares_records_the_share_alone_would_remove():
    assert testing.wilson_lower(10, 100) == pytest.approx(0.05523, abs=1e-5)
    assert testing.wilson_lower(0, 100) == 0 == testing.wilson_lower(0, 0)
    for removal, gone in (("rate", 2), ("wilson", 1), ("none", 0)):
        cache, _ = made(removal=removal, n_startup=8, delta_max=1.0, w_min=0.0)
        misses = np.zeros(len(cache), np.uint32)
        misses[:2] = 8, 20
        tallied(cache, 100, misses)
        assert cache.end_frame()["wrong"] == gone


def test_the_worst_go_first():
    cache, _ = made(removal="worst", k_worst=3, n_startup=8, delta_max=1.0, w_min=0.0)
    n = len(cache)
    rays, misses = np.full(n, 1000, np.uint32), np.zeros(n, np.uint32)
    misses[[1, 4, 5, 6]] = 5, 9, 700, 9
    rays[5] = 10**6  # many misses, a small share
    tallied(cache, rays, misses)
    before = cache.records().positions
    assert cache.end_frame()["wrong"] == 3
    kept = np.delete(np.arange(n), [1, 4, 6])
    np.testing.assert_array_equal(cache.records().positions, before[kept])
    # No record without a miss is among the worst
    cache.reset_errors()
    tallied(cache, 1000, 0)
    assert cache.end_frame()["wrong"] == 0


def test_records_unused_for_ten_frames_go():
    cache, _ = made(n_startup=100)
    away = vc.look_at((-1.25, 1.5, -1.75), (-0.8, 0.0, -0.8), fov_deg=10)
    first = cache.records().last_used
    assert not first.any()
    sizes = []
    for _ in range(11):
        cache.end_frame()
        sizes.append(len(cache))
        cache.update(away, size=(8, 8))
    used = cache.records().last_used
    assert len(set(sizes[:10])) <= 2 and sizes[10] < sizes[9]
    assert (used >= 1).all()
    never, _ = made(n_startup=100, unused_frames=0)
    for _ in range(30):
        assert never.end_frame()["unused"] == 0


def test_full_counters_keep_their_share():
    cache, _ = made(n_startup=8, removal="none", unused_frames=0)
    for _ in range(3):
        tallied(cache, (1 << 32) - 1, 1 << 30)
    r = cache.records()
    np.testing.assert_allclose(r.misses / r.rays, 0.25, rtol=1e-6)


def test_reset_forgets_errors_alone():
    cache, _ = made(n_startup=8)
    before = cache.records()
    tallied(cache, 100, 50)
    cache.reset_errors()
    after = cache.records()
    assert not after.rays.any() and not after.misses.any()
    np.testing.assert_array_equal(after.last_used, before.last_used)
    assert cache.end_frame()["wrong"] == 0


def test_a_moved_object_is_found_out_by_its_errors():
    ground = quad((-1, 0, -1), (0, 0, 2), (2, 0, 0))
    old, new = (
        Model((ground, box((x, 0, -0.2), (x + 0.3, 0.5, 0.2)))).to_viscache() for x in (-0.5, 0.3)
    )
    cache, _ = made(old, n_startup=200, delta_max=0.02)

    def rate():
        points = pixels(cache)
        points = points.take(np.flatnonzero(points.d_max > 0))
        found = cache.lookup(points.positions, points.normals, points.d_max)
        random = np.random.default_rng(cache.frame)
        directions = random.normal(size=(len(points), 32, 3)).astype(np.float32)
        directions /= np.linalg.norm(directions, axis=2, keepdims=True)
        rays, misses = cache.compare(found, directions, exact(cache, points, directions))
        return misses / rays

    still = rate()
    cache.end_frame()
    cache.reset_errors()
    cache.update(view(), size=SIZE, scene=new)
    disturbed = rate()
    removed = 0
    for _ in range(3):
        removed += cache.end_frame()["wrong"]
        cache.update(view(), size=SIZE, scene=new)
        last = rate()
    assert disturbed > 1.5 * still and removed > 0
    assert last < still + 0.5 * (disturbed - still)


def test_tallies_that_do_not_fit_are_refused():
    cache, _ = made(n_startup=8)
    n = len(cache)
    one, none = np.ones(n, np.uint32), np.zeros(n, np.uint8)
    with pytest.raises(ValueError, match=f"rays must have one entry per record, {n}"):
        cache._core.tally(one[1:], one, none, 0)
    with pytest.raises(ValueError, match="misses must be at most rays, row 0 has 2 of 1"):
        cache._core.tally(one, 2 * one, none, 0)
    found = cache.lookup([[0, 0, 0]], [[0, 1, 0]], 1.0)
    with pytest.raises(ValueError, match="directions must have shape"):
        cache.compare(found, [[0, 1, 0]], [[True]])
    with pytest.raises(ValueError, match=r"visible must have shape \(1, 1\)"):
        cache.compare(found, [[[0, 1, 0]]], [True])


def test_frames_are_the_same_for_any_number_of_threads():
    runs = []
    for threads in (1, 3):
        cache = vc.VisibilityMapCache(
            made()[0].scene, vc.MapSettings(n_startup=60, d_max=0.25, unused_frames=2)
        )
        for shift in (0.0, 0.2, 0.4, 0.6):
            eye = vc.look_at((1.25 - shift, 1.5, 1.75), (0.0, 0.25, 0.0), fov_deg=20)
            cache.update(eye, size=SIZE, threads=threads)
            cache.end_frame()
        runs.append(cache)
    assert same(*runs)
