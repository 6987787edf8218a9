"""Rays from arrays: checked, packed and ordered with the same bits on every instruction set."""

import numpy as np
import pytest

import viscache as vc
from core import testing
from reference.built import built
from reference.isas import AVAILABLE
from viscache.scene.queries import together
from visibility.soup import rays, soup

packed_rays, ray_order = testing.packed_rays, testing.ray_order
BAD = (np.nan, np.inf, -np.inf, 1.0001e16, -2e18)


def fine():
    return vc.Scene.from_arrays(*soup(3000, 0.05, 5))


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("n", [1, 15, 16, 17, 240, 256])
def test_lanes_hold_the_rays_in_their_order(isa, n):
    o, d = rays(n)
    t = np.random.default_rng(2).uniform(0.5, 2, n).astype(np.float32)
    d[n // 2], t[n // 3] = 0, 0
    for order in (None, np.random.default_rng(3).permutation(n).astype(np.uint32)):
        lanes, asked = packed_rays(o, d, t, order=order, isa=isa)
        at = np.arange(n) if order is None else order
        flat = lanes.transpose(0, 2, 1).reshape(-1, 8)
        want = (t[at] > 0) & (d[at] != 0).any(1)
        np.testing.assert_array_equal(flat[:n, :3], o[at])
        np.testing.assert_array_equal(flat[:n, 4:7], d[at])
        np.testing.assert_array_equal(flat[:n, 7], np.where(want, t[at], np.inf))
        assert not flat[:, 3].any()
        np.testing.assert_array_equal(asked.ravel()[:n], -want.astype(np.int32))
        assert not asked.ravel()[n:].any() and np.isfinite(flat[:, :7]).all()


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("gaps", [False, True])
def test_one_bad_number_anywhere_stops_its_batch(isa, gaps):
    n = 40
    wide = np.zeros((n, 8), np.float32)
    o, d = (wide[:, :3], wide[:, 4:7]) if gaps else (wide[:, :3].copy(), wide[:, 4:7].copy())
    o[:], d[:] = rays(n)
    t = np.full(n, np.inf, np.float32)
    assert packed_rays(o, d, t, isa=isa) is not None
    for row in (0, 7, 16, 31, 32, 39):
        for array in (o, d):
            for axis in range(3):
                for value in BAD:
                    kept = array[row, axis]
                    array[row, axis] = value
                    assert packed_rays(o, d, t, isa=isa) is None, (row, axis, value)
                    array[row, axis] = kept
        for value in (np.nan, -1e-30, -np.inf):
            t[row] = value
            assert packed_rays(o, d, t, isa=isa) is None, (row, value)
            t[row] = np.inf
    assert packed_rays(o, d, np.float32(np.nan), isa=isa) is None
    # At the limit, and where t_max is not a number but the length is zero
    o[3], d[5] = 1e16, 0
    assert packed_rays(o, d, t, isa=isa) is not None
    t[5] = np.nan
    assert packed_rays(o, d, t, isa=isa) is None


@pytest.mark.parametrize("isa", AVAILABLE)
def test_every_instruction_set_orders_rays_in_the_same_way(isa):
    for n in (1, 2, 33, 1000, 5000):
        o, d = rays(n)
        want, share = ray_order(o, d, isa="portable")
        got, same_share = ray_order(o, d, isa=isa)
        np.testing.assert_array_equal(got, want)
        np.testing.assert_array_equal(np.sort(got), np.arange(n))
        assert share == same_share
    wide = np.concatenate(rays(5000), axis=1)
    np.testing.assert_array_equal(ray_order(wide[:, :3], wide[:, 3:], isa=isa)[0], want)


def test_the_share_in_order_tells_images_from_rays_without_order():
    scene = built("room?triangles=2000")
    from viscache_lab.bench.ray_sets import make_ray_set

    shares = {}
    for which in ("camera", "hemi", "p2p"):
        r = make_ray_set(scene, which, 40_000)
        shares[which] = ray_order(r.origins, r.directions)[1]
    assert shares["camera"] > 0.9 and shares["hemi"] < 0.1 and shares["p2p"] < 0.1


def test_sorted_rays_are_near_their_predecessors():
    o, d = rays(40_000)
    order, _ = ray_order(o, d)
    jump = np.linalg.norm(np.diff(o[order], axis=0), axis=1).mean()
    assert jump < 0.25 * np.linalg.norm(np.diff(o, axis=0), axis=1).mean()


@pytest.mark.parametrize("instanced", [False, True])
def test_every_way_gives_the_answers_of_single_rays(instanced):
    scene = vc.scenes.courtyard(triangles=30_000) if instanced else fine()
    caster = scene.caster()
    o, d = rays(20_011)
    if instanced:
        lo, hi = scene.bounds
        o = (lo + (o + 2) / 4 * (hi - lo)).astype(np.float32)
    single = caster.bare_occluded(o, d, 1.5, 1)
    assert 0.05 < single.mean() < 0.95
    for way in ("coherent", "as_given", "sorted", None):
        np.testing.assert_array_equal(caster.occluded(o, d, 1.5, way=way), single)
    with pytest.raises(ValueError, match="way must be coherent, as_given or sorted, got fast"):
        caster.occluded(o, d, 1.5, way="fast")


@pytest.mark.parametrize("way", ["coherent", "as_given", "sorted"])
@pytest.mark.parametrize("row", [0, 1, 70_001, 99_999])
def test_the_first_bad_row_of_many_is_named(way, row):
    """Debian's Embree would end the process if one of them reached it."""
    caster = vc.Scene.from_arrays(*soup(10)).caster()
    n = 100_000
    o, d = rays(n)
    t = np.ones(n, np.float32)
    d[row, 1] = d[-1, 2] = np.nan
    with pytest.raises(ValueError, match=rf"^directions must be finite .*, row {row} is \(.*nan"):
        caster.occluded(o, d, t, way=way)
    o[row, 2] = np.inf
    with pytest.raises(ValueError, match=rf"^origins must be finite .*, row {row} is \(.*inf\)$"):
        caster.occluded(o, d, t, way=way)
    t[row] = -2
    with pytest.raises(ValueError, match=r"^t_max must be >= 0, got -2\.0"):
        caster.occluded(o, d, t, way=way)


def test_rows_with_gaps_and_one_row_for_all_are_read_in_place():
    wide = np.concatenate(rays(9000), axis=1)
    o, d = wide[:, :3], wide[:, 3:]
    (views, shape) = together(origins=o, directions=d)
    assert shape == (9000,) and all(np.shares_memory(v, wide) for v in views)
    (views, shape) = together(origins=o[0], directions=d)
    assert shape == (9000,) and views[0].strides == (0, 4)
    scene = fine()
    plain = scene.occluded(o.copy(), d.copy(), 1.0)
    assert 0.02 < plain.mean() < 0.98
    for p, w in ((o, d), (o[::-1][::-1], np.asfortranarray(d)), (o.astype(np.float64), d)):
        np.testing.assert_array_equal(scene.occluded(p, w, 1.0), plain)
    np.testing.assert_array_equal(scene.occluded(o[::-3], d[::-3], 1.0), plain[::-3])
    np.testing.assert_array_equal(scene.occluded(o.tolist(), d, 1), plain)
    assert scene.occluded(o.astype(np.float16), d, 1.0).shape == plain.shape
    one = np.repeat(o[:1], 9000, axis=0)
    np.testing.assert_array_equal(scene.occluded(o[0], d, 1.0), scene.occluded(one, d, 1.0))
    np.testing.assert_array_equal(
        scene.visible(o[0], o), scene.visible(one.copy(), np.ascontiguousarray(o))
    )
    raw = np.frombuffer(b"\0" + wide.tobytes(), np.uint8)[1:].view(np.float32).reshape(-1, 6)
    assert not raw.flags.aligned
    np.testing.assert_array_equal(scene.occluded(raw[:, :3], raw[:, 3:], 1.0), plain)
