"""Tiles of triangles: none that is touched is missed, none that is clear of them is listed."""

import numpy as np
import pytest

from viscache import _core

SLACK = 1e-5
SIZES = (1, 2, 3, 7, 16, 128, 512)


def triangles_of_every_kind(seed=0):
    """Corners (K, 3, 3) inside the unit ball."""
    r = np.random.default_rng(seed)

    def inside(p):
        most = np.linalg.norm(p, axis=-1).max(axis=-1)
        return p / np.maximum(1, most * 1.0001)[..., None, None]

    centre = r.uniform(-0.5, 0.5, (40, 1, 3))
    along, across = r.normal(size=(2, 40, 1, 3))
    edge_on = r.normal(0, 0.3, (40, 3, 3))
    edge_on[:, 2, :2] = edge_on[:, 0, :2] + r.uniform(0, 1, (40, 1)) * (
        edge_on[:, 1, :2] - edge_on[:, 0, :2]
    )
    on_borders = r.integers(-4, 5, (40, 3, 3)) / 8
    return {
        "random": inside(r.normal(0, 0.4, (40, 3, 3))),
        "small": inside(centre + r.normal(0, 0.02, (40, 3, 3))),
        "slivers": inside(centre + along * [[0], [0.5], [1]] + 1e-6 * across * [[0], [1], [0]]),
        "below a tile": inside(centre + r.normal(0, 1e-5, (40, 3, 3))),
        "edge-on": inside(edge_on),
        "the whole plane": inside(np.array([[[-9, -9, 0.1], [9, -9, -0.1], [0, 9, 0.3]]]) / 13),
        "corners on borders": inside(on_borders),
        "parallel to an axis": inside(on_borders * [1, 0, 1] + [0, 0.3, 0]),
    }


KINDS = tuple(triangles_of_every_kind())


def covered(corners, n):
    return _core.vlf.cover_tiles(np.asarray(corners, np.float32), n)


def tile_of(p, n):
    return np.clip(np.floor((p + 1) * n / 2), 0, n - 1).astype(int)


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("kind", KINDS)
def test_the_tile_of_every_point_lists_its_triangle_at_its_depth(kind, n):
    """10⁴ points of each triangle, in double."""
    corners = triangles_of_every_kind()[kind].astype(np.float32)
    tiles, depths = covered(corners, n)
    r = np.random.default_rng(n)
    weights = r.dirichlet((1, 1, 1), 10_000 // 3)
    edges = r.dirichlet((1, 1), 10_000 - len(weights) - 3)
    bare = np.zeros((len(edges), 3))
    bare[:, :2] = edges
    weights = np.concatenate([weights, np.eye(3), *(np.roll(bare[k::3], k, 1) for k in range(3))])
    for i, t in enumerate(corners.astype(float)):
        mine = tiles[:, 0] == i
        low, high = np.full((2, n, n), np.nan)
        low[tiles[mine, 1], tiles[mine, 2]], high[tiles[mine, 1], tiles[mine, 2]] = depths[mine].T
        p = weights @ t
        x, y = tile_of(p[:, 0], n), tile_of(p[:, 1], n)
        assert not np.isnan(low[x, y]).any()
        assert (low[x, y] <= p[:, 2]).all() and (p[:, 2] <= high[x, y]).all()


def separated(t, box):
    """Separating axes of a triangle and a box (2 corners) in the plane, in double."""
    corners = np.array([[x, y] for x in box[:, 0] for y in box[:, 1]])
    edges = np.roll(t, -1, 0) - t
    axes = np.concatenate([np.eye(2), edges @ [[0, -1], [1, 0]]])
    for axis in axes:
        a, b = t @ axis, corners @ axis
        if a.max() < b.min() or b.max() < a.min():
            return True
    return False


@pytest.mark.parametrize("n", (2, 7, 16, 64))
@pytest.mark.parametrize("kind", KINDS)
def test_no_tile_is_listed_that_a_separating_axis_clears(kind, n):
    corners = triangles_of_every_kind()[kind].astype(np.float32)[:12]
    tiles, _ = covered(corners, n)
    assert len(np.unique(tiles, axis=0)) == len(tiles)
    for i, x, y in tiles:
        box = np.array([[x, y], [x + 1, y + 1]]) * 2 / n - 1 + 2 * SLACK * np.array([[-1], [1]])
        assert not separated(corners[i, :, :2].astype(float), box), (kind, i, x, y)


@pytest.mark.parametrize("n", (1, 16, 128))
def test_depths_are_those_of_the_part_inside_the_tile(n):
    """The range is the triangle's own in its tile, grown by no more than a steep slope explains."""
    corners = triangles_of_every_kind(3)["random"].astype(np.float32)
    tiles, depths = covered(corners, n)
    for i in range(10):
        t = corners[i].astype(float)
        slope = np.abs(np.linalg.solve((t[1:] - t[0])[:, :2], (t[1:] - t[0])[:, 2]))
        mine = tiles[:, 0] == i
        # Over a tile, a plane's depth spans its slope times the tile's size
        span = np.minimum(np.ptp(t[:, 2]), (slope * (2 / n + 2 * SLACK)).sum()) + 3 * SLACK
        assert (np.ptp(depths[mine], axis=1) <= span * (1 + 1e-4)).all()
        assert depths[mine, 0].min() == pytest.approx(t[:, 2].min() - SLACK, abs=1e-6)
        assert depths[mine, 1].max() == pytest.approx(t[:, 2].max() + SLACK, abs=1e-6)


def test_a_diagonal_edge_touches_tiles_that_a_dda_skips():
    """Fig. 1: the edge of a triangle without width."""
    edge = np.array([[-0.9, -0.83, 0], [0.9, 0.71, 0], [0.9, 0.71, 0]], np.float32)
    tiles, _ = covered(edge[None], 16)
    found = {(int(x), int(y)) for _, x, y in tiles}
    place = np.linspace(edge[0, :2], edge[1, :2], 100_001)
    assert found >= set(map(tuple, tile_of(place, 16)))
    steps = np.linspace(edge[0, :2], edge[1, :2], 1 + int(np.ptp(tile_of(edge[:, 0], 16))))
    dda = set(map(tuple, tile_of(steps, 16)))
    assert dda < found


def test_arrays_of_another_shape_and_wrong_tilings_are_refused():
    with pytest.raises(ValueError, match=r"shape \(N, 3, 3\), got \(2, 3\)"):
        covered(np.zeros((2, 3)), 4)
    for n in (0, -1, 4097):
        with pytest.raises(ValueError, match=r"n_tiles must be in \[1, 4096\], got"):
            covered(np.zeros((1, 3, 3)), n)
