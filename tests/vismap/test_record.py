"""Maps of records: order, size, hierarchy, difference, dilation, pattern."""

import numpy as np
import pytest

from core import testing
from reference import vismap_records as reference
from reference.isas import AVAILABLE
from viscache import _core

vismap = _core.vismap

SIZES = (4, 5, 6, 7)


def maps(m):
    """Maps of all kinds, (row, column)."""
    edge = 1 << m
    y, x = np.mgrid[:edge, :edge]
    random = np.random.default_rng(m)
    blocks = random.random((edge // 8, edge // 8)) < 0.5
    return {
        "empty": np.zeros((edge, edge), bool),
        "full": np.ones((edge, edge), bool),
        "checkerboard": (x + y) % 2 == 0,
        "half space": x > y,
        "random": random.random((edge, edge)) < 0.5,
        "blocks": blocks.repeat(8, 0).repeat(8, 1),
        "one": (x == edge - 1) & (y == 3),
        "all but one": ~((x == 0) & (y == edge - 1)),
    }


def test_codes_of_all_cells_follow_the_papers_order():
    x, y = np.meshgrid(np.arange(128, dtype=np.uint32), np.arange(128, dtype=np.uint32))
    codes = vismap.morton2(x, y)
    expected = [[reference.z_order(i, j) for i in range(128)] for j in range(128)]
    np.testing.assert_array_equal(codes, expected)
    assert codes[0, :8].tolist() == [0, 1, 4, 5, 16, 17, 20, 21]
    assert codes[1, :4].tolist() == [2, 3, 6, 7]
    np.testing.assert_array_equal(testing.gather2(codes), x)
    np.testing.assert_array_equal(testing.gather2(codes >> 1), y)


def test_records_have_the_papers_size():
    assert [vismap.record_nbytes(m) for m in SIZES] == [76, 172, 572, 2172]
    for m in (3, 8, -1):
        with pytest.raises(ValueError, match=rf"m must be in \[4, 7\], got {m}"):
            vismap.record_nbytes(m)


@pytest.mark.parametrize("m", SIZES)
@pytest.mark.parametrize("kind", maps(4))
def test_every_node_says_what_its_cells_are(m, kind):
    square = maps(m)[kind]
    bits = reference.packed(square)
    for level in range(m + 1):
        expected = reference.codes(square, level)
        np.testing.assert_array_equal(testing.node_codes(bits, m, level), expected)


def test_the_hierarchy_starts_at_the_root():
    """Node z of level l has two bits at 2·((4^l − 1)/3 + z), as the estimate reads them."""
    square = maps(6)["random"]
    square[:32, :32] = True
    words = testing.hierarchy(reference.packed(square), 6)
    assert words.dtype == np.uint64 and len(words) == 3
    stored = np.unpackbits(words.view(np.uint8), bitorder="little").reshape(-1, 2)
    codes = stored[:, 0] + 2 * stored[:, 1]
    expected = np.concatenate([reference.codes(square, level) for level in range(4)])
    np.testing.assert_array_equal(codes[:85], expected)
    assert not codes[85:].any()
    assert expected[1] == 3  # the free quarter


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("m", SIZES)
def test_difference_is_the_share_of_differing_cells(m, isa):
    rows = np.stack([reference.packed(square) for square in maps(m).values()])
    flat = np.unpackbits(rows.view(np.uint8), axis=1)
    n = len(rows)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(n)))
    delta = testing.map_differences(rows[i], rows[j], m, isa=isa)
    np.testing.assert_array_equal(delta, (flat[i] != flat[j]).mean(axis=1, dtype=np.float32))
    table = delta.reshape(n, n)
    assert not np.diag(table).any()
    np.testing.assert_array_equal(table, table.T)
    assert (testing.map_differences(rows, ~rows, m, isa=isa) == 1).all()
    assert (table[:, :, None] <= table[:, None, :] + table.T[None, :, :]).all()


def test_maps_of_other_sizes_are_refused():
    good, bad = np.zeros((2, 16), np.uint64), np.zeros((2, 15), np.uint64)
    with pytest.raises(ValueError, match=r"b must have shape \(N, 16\), got \(2, 15\)"):
        testing.map_differences(good, bad, 5)
    with pytest.raises(ValueError, match="isa must be portable, avx2 or avx512"):
        testing.map_differences(good, good, 5, isa="mmx")
    with pytest.raises(ValueError, match=r"bits must have shape \(16,\), got \(4,\)"):
        vismap.dilated(np.zeros(4, np.uint64), 5, 1)
    with pytest.raises(ValueError, match=r"level must be in \[1, 2\], got 3"):
        vismap.dilated(good[0], 5, 3)


@pytest.mark.parametrize("m", SIZES)
@pytest.mark.parametrize("kind", maps(4))
def test_dilations_equal_brute_force(m, kind):
    square = maps(m)[kind]
    for level in range(1, 4 if m >= 6 else 3):
        grown = vismap.dilated(reference.packed(square), m, level)
        expected = reference.packed(reference.dilated(square, level))
        np.testing.assert_array_equal(grown, expected)


@pytest.mark.parametrize("m", [5, 6])
def test_single_cells_grow_over_edges_and_corners(m):
    """Neighbours by the sphere: cells whose centres are nearest, not by the rule of the border."""
    edge = 1 << m
    last = edge - 1
    directions = centres(edge)
    for x, y in [(9, 7), (0, 5), (last, 6), (4, 0), (11, last), (0, 0), (last, 0), (last, last)]:
        square = np.zeros((edge, edge), bool)
        square[y, x] = True
        grown = reference.unpacked(vismap.dilated(reference.packed(square), m, 1), edge)
        assert grown[y, x]
        apart = np.arccos(np.clip(directions @ directions[y, x], -1, 1))
        width = np.sqrt(4 * np.pi) / edge
        assert grown[apart < 0.9 * width].all()
        assert apart[grown].max() < 3.5 * width
        assert grown.sum() == 9  # at a corner too: the square's four corners are one point


def centres(edge):
    at = (np.arange(edge, dtype=np.float32) + 0.5) / edge
    u, v = np.meshgrid(at, at)
    places = np.stack([u, v], -1).reshape(-1, 2)
    return np.asarray(_core.sampling.equal_area_to_direction(places)).reshape(edge, edge, 3)


def cell_of(directions, edge):
    """Z-order number of the cell of unit directions (N, 3)."""
    at = _core.sampling.direction_to_equal_area(directions.astype(np.float32))
    x, y = np.minimum((at * edge).astype(np.uint32), edge - 1).T
    return np.asarray(vismap.morton2(x, y))


@pytest.mark.parametrize("m", [4, 5, 6])
def test_the_pattern_has_one_direction_in_every_cell_in_order(m):
    pattern = testing.record_pattern(m, 3)
    np.testing.assert_array_equal(cell_of(pattern, 1 << m), np.arange(4**m))
    np.testing.assert_array_equal(pattern, testing.record_pattern(m, 3))
    assert (pattern != testing.record_pattern(m, 4)).any()
    # Lloyd's iteration spreads them: neighbours nearer than a third of a cell are gone
    apart = np.sort(np.clip(pattern @ pattern.T, -1, 1), axis=1)[:, -2]
    assert np.degrees(np.arccos(apart.max())) > np.degrees(np.sqrt(4 * np.pi) / 2**m) / 3
