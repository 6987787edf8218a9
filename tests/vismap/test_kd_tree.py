"""The records' tree finds what brute force finds, whatever its shape."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core import testing
from vismap.clouds import N, clouds, nearest


def check(tree, points, queries, radius):
    for m in (1, 4, 16, 64):
        found = tree.search(queries, radius, m)
        assert found == [nearest(points, q, radius, m) for q in queries]


@pytest.mark.parametrize("kind", clouds())
def test_searches_find_what_brute_force_finds(kind):
    points = clouds()[kind].astype(np.float32)
    queries = np.concatenate([points[:: N // 20], points[:5] + np.float32(0.01)])
    radii = (0.03, 0.3, 3.0)
    grown = testing.KdTree()
    for first in range(0, N, 500):
        grown.insert(points[first : first + 500], first)
        if first in (0, 500, 3000):  # while it grows
            so_far = points[: first + 500]
            check(grown, so_far, queries[:5], 0.2)
    balanced = testing.KdTree()
    balanced.build(points)
    assert len(grown) == len(balanced) == N
    for radius in radii:
        check(grown, points, queries, radius)
        check(balanced, points, queries, radius)


def test_the_tree_is_rebuilt_now_and_then_and_stays_shallow():
    tree = testing.KdTree()
    line = np.zeros((4000, 3), np.float32)
    line[:, 0] = np.arange(4000)  # the worst order for a tree that only grows
    for i in range(4000):
        tree.insert(line[i : i + 1], i)
        assert tree.depth <= 2 * len(tree).bit_length() + 9
    assert 10 <= tree.rebuilds <= 200
    balanced = testing.KdTree()
    balanced.build(line)
    assert balanced.depth <= 11


def test_the_tree_is_rebuilt_at_one_and_a_half_times_the_points_of_the_last_time():
    tree = testing.KdTree()
    points = np.random.default_rng(3).random((2000, 3)).astype(np.float32)
    built, rebuilds = 0, 0
    for n, point in enumerate(points, 1):
        tree.insert(point[None], n - 1)
        # Before 33 points the shape does not matter; a tree of random points stays shallow
        if n == 1 or (n > 32 and n >= 1.5 * built):
            built, rebuilds = n, rebuilds + 1
        assert tree.rebuilds == rebuilds, n
    assert rebuilds == 12


def test_leaves_that_cannot_be_split_are_counted():
    tree = testing.KdTree()
    same = np.full((9, 3), 0.25, np.float32)
    tree.insert(same[:4], 0)
    assert tree.oversized_leaves == 0
    tree.insert(same[4:], 4)
    assert tree.oversized_leaves == 1
    assert tree.search(same[:1], 1.0, 16) == [list(range(9))]
    tree.insert(np.array([[0.5, 0.25, 0.25]], np.float32), 9)
    assert tree.oversized_leaves == 1
    assert tree.search(same[:1], 1.0, 16) == [list(range(10))]


def test_an_empty_tree_finds_nothing_and_points_at_the_radius_are_outside():
    tree = testing.KdTree()
    origin = np.zeros((1, 3), np.float32)
    assert tree.search(origin, 1.0, 4) == [[]]
    tree.insert(np.array([[1, 0, 0], [0.5, 0, 0]], np.float32), 0)
    assert tree.search(origin, 1.0, 4) == [[1]]


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 200), st.integers(1, 5), st.floats(0.01, 2))
def test_coarse_coordinates_with_many_ties(seed, n, levels, radius):
    random = np.random.default_rng(seed)
    points = (random.integers(0, levels, (n, 3)) / levels).astype(np.float32)
    tree = testing.KdTree()
    tree.insert(points, 0)
    check(tree, points, points[:10], radius)
