"""The partition of a tile: no depth without its leaf, both walks alike, near to far."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core import testing
from viscache import _core

depth = st.floats(-1.25, 1.25, width=32, allow_subnormal=False)
counts = st.integers(0, 6).map(lambda d: 1 << d)


def walk(z0, z1, leaves, borders, low, high, upwards, how="linear"):
    return _core.vlf.walk_leaves(z0, z1, leaves, borders, low, high, upwards, how)


@settings(max_examples=300, deadline=None)
@given(z=st.tuples(depth, depth), range_=st.tuples(depth, depth), leaves=counts, up=st.booleans())
def test_leaves_of_equal_slabs_are_those_that_the_depths_meet(z, range_, leaves, up):
    low, high = min(z), max(z)
    z0, z1 = min(range_), max(range_)
    if z1 - z0 < 1e-3:
        z1 = float(np.float32(z0 + 1e-3))
    found = walk(z0, z1, leaves, [], low, high, up)
    assert found == sorted(found, reverse=not up) and len(found) >= 1
    edges = np.linspace(z0, z1, leaves + 1)
    edges[0], edges[-1] = -np.inf, np.inf
    wide = 4e-6 + (z1 - z0) * 1e-6
    must = {k for k in range(leaves) if low <= edges[k + 1] and high >= edges[k]}
    may = {k for k in range(leaves) if low - wide <= edges[k + 1] and high + wide >= edges[k]}
    assert must <= set(found) <= may


@settings(max_examples=300, deadline=None)
@given(
    z=st.tuples(depth, depth),
    leaves=counts,
    up=st.booleans(),
    seed=st.integers(0, 1000),
    by_medians=st.booleans(),
)
def test_the_stack_visits_the_leaves_of_the_linear_walk(z, leaves, up, seed, by_medians):
    borders = np.sort(np.random.default_rng(seed).uniform(-1, 1, leaves)).tolist()
    given_borders = borders if by_medians else []
    low, high = min(z), max(z)
    linear = walk(-1, 1, leaves, given_borders, low, high, up)
    stack = walk(-1, 1, leaves, given_borders, low, high, up, "stack")
    # They compare with a border in two ways, and may differ where it is met within rounding
    edges = np.array(borders if by_medians else np.linspace(-1, 1, leaves + 1)[:-1])
    near = np.abs(edges[:, None] - [low - 1e-6, high + 1e-6]).min() < 5e-7
    assert near or stack == linear
    assert stack == sorted(stack, reverse=not up)


@settings(max_examples=100, deadline=None)
@given(z=st.lists(depth, min_size=2, max_size=20), leaves=counts, seed=st.integers(0, 1000))
def test_a_deeper_depth_never_has_an_earlier_leaf(z, leaves, seed):
    borders = np.sort(np.random.default_rng(seed).uniform(-1, 1, leaves)).tolist()
    for b in ([], borders):
        first = [walk(-1, 1, leaves, b, v, v, True)[0] for v in sorted(z)]
        assert first == sorted(first)


def test_walks_end_where_the_ray_hardly_goes_deeper():
    """Depths in the wrong order by rounding once made a walk that compares for equality run on."""
    for how in ("linear", "stack"):
        for up in (True, False):
            assert walk(-1, 1, 8, [], 0.25, 0.25, up, how) in ([4, 5], [5, 4], [5], [4])
            assert walk(0.1, 0.1000001, 8, [], 0.3, 0.3, up, how) == [7]
            assert walk(0.1, 0.1000001, 8, [], -0.3, -0.3, up, how) == [0]


@pytest.mark.parametrize("target", [1, 4, 10])
def test_the_depth_of_a_tile_leaves_at_most_the_target(target):
    for count in range(200):
        d = testing.tile_depth(count, 12, target)
        assert count <= target << d
        assert d == 0 or count > target << (d - 1)
        assert d == max(0, int(np.ceil(np.log2(max(count, 1) / target))))
        assert testing.tile_depth(count, 2, target) == min(d, 2)


def test_without_a_target_all_tiles_have_the_full_depth():
    assert [testing.tile_depth(c, 5, 0) for c in (0, 1, 100)] == [0, 5, 5]
