"""Lists of the subfields: complete, ordered, without repeats, the same on any threads."""

import itertools

import numpy as np
import pytest

import viscache as vc
from viscache import _core
from vlf.field_rays import soup

PARAMETERS = [
    {"bsp_depth": 0},
    {"bsp_depth": 3, "leaf_target": 0},
    {"bsp_depth": 5, "leaf_target": 1},
    {"bsp_depth": 5, "leaf_target": 1, "split": "object"},
    {"bsp_depth": 4, "tile_ranges": False},
]


def built(scene, n=24, **settings):
    depth = settings.pop("bsp_depth", "auto")
    chosen = vc.Vlf(n_directions=33, n_tiles=n, bsp_depth=depth, **settings)
    return vc.VisibilityField(scene, settings=chosen)


def tile_lists(lists):
    """Triangles of each tile."""
    ends = lists["first_id"][lists["first_leaf"]]
    return [set(lists["ids"][a:b].tolist()) for a, b in itertools.pairwise(ends)]


@pytest.mark.parametrize("settings", PARAMETERS)
def test_offsets_grow_and_lists_ascend_without_repeats(settings):
    f = built(vc.Scene.from_arrays(*soup(800)), **settings)
    stats = f.stats
    leaves = references = 0
    for direction in range(33):
        lists = f._core.subfield(direction)
        first_leaf, first_id, ids = lists["first_leaf"], lists["first_id"], lists["ids"]
        assert len(first_leaf) == 24 * 24 + 1 and first_leaf[0] == first_id[0] == 0
        assert (np.diff(first_leaf.astype(int)) >= 0).all()
        assert (np.diff(first_id.astype(int)) >= 0).all()
        assert first_leaf[-1] == len(first_id) - 1 and first_id[-1] == len(ids)
        counts = np.unique(np.diff(first_leaf))
        assert set(counts) <= {0, *(1 << np.arange(settings["bsp_depth"] + 1))}
        assert ids.max() < 800
        inner = np.ones(len(ids), bool)
        inner[first_id[:-1][first_id[:-1] < len(ids)]] = False  # the first of each list
        assert (np.diff(ids.astype(int))[inner[1:]] > 0).all()
        leaves, references = leaves + len(first_id) - 1, references + len(ids)
        own = (lists["ranges"] != [-1, 1]).any(axis=1)[np.diff(first_leaf) > 0]
        assert own.all() if settings.get("tile_ranges", True) else not own.any()
    assert (stats["leaves"], stats["references"]) == (leaves, references)


@pytest.mark.parametrize("settings", PARAMETERS)
def test_the_leaves_of_a_tile_hold_the_triangles_that_touch_it(settings):
    vertices, triangles = soup(400)
    f = built(vc.Scene.from_arrays(vertices, triangles), **settings)
    lo, hi = vertices.min(0).astype(float), vertices.max(0).astype(float)
    center = (lo + hi) / 2
    corners = vertices[triangles].astype(float) - center
    corners /= np.linalg.norm(corners, axis=-1).max() * 1.0001
    for direction, frame in enumerate(vc.vlf.direction_frames(33)[::4].astype(float)):
        canonical = (corners @ frame.T).astype(np.float32)
        tiles, _ = _core.vlf.cover_tiles(canonical, 24)
        expected = [set() for _ in range(24 * 24)]
        for i, x, y in tiles.tolist():
            expected[y * 24 + x].add(i)
        found = tile_lists(f._core.subfield(4 * direction))
        # Corners of another rounding may reach another tile by the slack
        different = sum(len(a ^ b) for a, b in zip(found, expected, strict=True))
        assert different <= 2e-3 * sum(map(len, expected))


def test_a_picture_of_an_axis_counts_its_entries_where_the_triangles_lie():
    f = built(vc.Scene.from_arrays(*soup(800)), bsp_depth=3)
    assert sum(int(f.tile_entries(k).sum()) for k in range(33)) == f.stats["references"]
    frame = vc.vlf.direction_frames(33)[5].astype(float)
    places = np.array([[0.6, -0.3, 0.1], [-0.6, 0.3, -0.1]]) @ frame  # from u, v, w
    corners = (places[:, None] + 1e-3 * np.eye(3)).reshape(6, 3)
    two = vc.Scene.from_arrays(corners, np.arange(6).reshape(2, 3))
    shown = vc.VisibilityField(two, 33, 16).tile_entries(5)
    radius = np.linalg.norm(corners - (corners.min(0) + corners.max(0)) / 2, axis=1).max()
    for u, v, _ in places @ frame.T / radius:
        row, column = int((v + 1) / 2 * 16), int((u + 1) / 2 * 16)
        assert shown[row, column] >= 1 and shown[column, row] == 0
    assert shown.shape == (16, 16) and (shown > 0).sum() <= 8


def test_every_depth_of_a_triangle_has_it_in_its_leaf():
    f = built(vc.Scene.from_arrays(*soup(800)), bsp_depth=4, leaf_target=1)
    lists = f._core.subfield(7)
    for tile in np.flatnonzero(np.diff(lists["first_leaf"]) > 1)[:100]:
        first, last = lists["first_leaf"][tile : tile + 2].astype(int)
        z0, z1 = lists["ranges"][tile]
        assert z0 < z1
        leaves = [
            set(lists["ids"][lists["first_id"][k] : lists["first_id"][k + 1]].tolist())
            for k in range(first, last)
        ]
        for i in set.union(*leaves):
            where = [k for k, ids in enumerate(leaves) if i in ids]
            assert where == list(range(where[0], where[-1] + 1))


@pytest.mark.parametrize("threads", [2, 3, 7])
def test_the_lists_are_the_same_bytes_for_any_number_of_threads(threads):
    scene = vc.Scene.from_arrays(*soup(1000))
    alone, together = (vc.VisibilityField(scene, 33, 32, 4, threads=t) for t in (1, threads))
    for direction in range(33):
        a, b = alone._core.subfield(direction), together._core.subfield(direction)
        for name in a:
            np.testing.assert_array_equal(a[name], b[name])


def test_a_direction_beyond_the_last_is_refused():
    f = built(vc.Scene.from_arrays(*soup(10)))
    with pytest.raises(ValueError, match="direction must be < 33, got 33"):
        f._core.subfield(33)
