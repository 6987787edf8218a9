"""A ray's way over the tiles: every tile it crosses, in order, with its interval."""

import numpy as np
import pytest

from viscache import _core


def walk(o, d, n, t_min=0.0, t_max=np.inf):
    return _core.vlf.walk_tiles(list(map(float, o)), list(map(float, d)), n, t_min, t_max)


def random_rays(count, seed=0):
    r = np.random.default_rng(seed)
    o, d = r.uniform(-1.5, 1.5, (count, 3)), r.normal(size=(count, 3))
    d[: count // 4, :2] *= 0.05
    d[: count // 20, 0] = 0
    return o.astype(np.float32), d.astype(np.float32)


@pytest.mark.parametrize("n", (1, 2, 5, 16, 128, 4096))
def test_every_point_of_a_ray_lies_in_the_tile_of_its_interval(n):
    for o, d in zip(*random_rays(200, seed=n), strict=True):
        tiles, times = walk(o, d, n)
        o, d = o.astype(float), d.astype(float)
        with np.errstate(divide="ignore"):
            a, b = (-1 - o) / d, (1 - o) / d
        still = (d == 0) & (np.abs(o) <= 1)
        a[still], b[still] = -np.inf, np.inf
        t0, t1 = max(0.0, np.minimum(a, b).max()), np.maximum(a, b).min()
        if not t0 < t1:
            assert len(tiles) <= 1
            continue
        assert times[0, 0] == pytest.approx(t0, abs=1e-12)
        assert times[-1, 1] == pytest.approx(t1, abs=1e-9)
        np.testing.assert_array_equal(times[1:, 0], times[:-1, 1])
        assert (np.diff(times, axis=1) >= 0).all()
        assert (np.abs(np.diff(tiles, axis=0)).sum(1) == 1).all()  # no corner is skipped
        for share in (0.0, 0.25, 0.5, 1.0):
            t = times[:, 0] + share * (times[:, 1] - times[:, 0])
            place = (o[:2] + t[:, None] * d[:2] + 1) * n / 2
            outside = np.maximum(tiles - place, place - tiles - 1).max(1)
            assert (outside * 2 / n < 4e-6).all()


def test_a_ray_along_the_beam_stays_in_its_tile():
    for d in ([0, 0, 1], [0, 0, -2], [1e-8, -1e-8, 1]):
        tiles, times = walk([0.3, -0.2, 5 * -np.sign(d[2])], d, 16)
        assert tiles.tolist() == [[10, 6]]
        assert np.ptp(times) == pytest.approx(2 / abs(d[2]))


def test_the_interval_of_a_segment_bounds_its_tiles():
    tiles, times = walk([-0.95, 0.05, 0], [1, 0, 0], 10, 0.1, 0.5)
    assert tiles[:, 0].tolist() == [0, 1, 2] and (tiles[:, 1] == 5).all()
    assert times[0, 0] == 0.1 and times[-1, 1] == 0.5


@pytest.mark.parametrize("interval", [(0.5, 0.4), (3.0, np.inf), (0.0, -1.0)])
def test_empty_intervals_cross_no_tile(interval):
    assert len(walk([0, 0, 0], [1, 0, 0], 8, *interval)[0]) == 0


def test_rays_beside_the_cube_cross_no_tile():
    assert len(walk([0, 0, 2], [1, 0, 0], 8)[0]) == 0
    assert len(walk([0, 3, 0], [1, 0.1, 0], 8)[0]) == 0


@pytest.mark.extreme
def test_rays_from_far_away_and_of_any_length_cross_the_same_tiles():
    base, _ = walk([-0.5, 0.123, 0.1], [1, 0.25, 0.3], 64)
    for scale in (1e-30, 1e30):
        np.testing.assert_array_equal(
            walk([-0.5, 0.123, 0.1], np.multiply([1, 0.25, 0.3], scale), 64)[0], base
        )
    far, _ = walk([-1024.5, -256 + 0.125, 0], [1, 0.25, 0], 64)
    near, _ = walk([-0.5, 0.125, 0], [1, 0.25, 0], 64, -10)
    np.testing.assert_array_equal(far, near)
