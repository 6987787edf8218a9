"""A neighbour list finds what the tree finds, and seldom asks it on a walk."""

import numpy as np
import pytest

from core import testing
from vismap.clouds import clouds, nearest

N = 3000


def expected(points, walk, radius, m):
    ids = np.arange(len(points))
    kept = [np.flatnonzero(ids % 3 != q % 3) for q in range(len(walk))]
    return [
        [int(k[i]) for i in nearest(points[k], at, radius, m)]
        for k, at in zip(kept, walk, strict=True)
    ]


def walk_through(points, step):
    """Steps along a line, a jump, and steps again."""
    low, high = points.min(0), points.max(0)
    along = np.linspace(0.2, 0.2 + 40 * step, 40)[:, None] * (high - low) + low
    return np.concatenate([along, high[None] + 1, along[::-1] + 0.3 * (high - low)]).astype(
        np.float32
    )


@pytest.mark.parametrize("kind", clouds())
@pytest.mark.parametrize("step", [1e-4, 1e-3, 1e-2])
def test_a_walk_finds_what_brute_force_finds(kind, step):
    points = clouds()[kind].astype(np.float32)[:: 10_000 // N][:N]
    tree = testing.KdTree()
    tree.build(points)
    walk = walk_through(points, step)
    for radius in (0.02, 0.2, 5.0):
        for m in (1, 16, 64):
            found, _ = tree.walk(walk, radius, m)
            assert found == expected(points, walk, radius, m)


def test_small_steps_seldom_need_the_tree():
    points = clouds()["random"].astype(np.float32)
    tree = testing.KdTree()
    tree.build(points)
    walk = walk_through(points, 1e-4)
    _, answered = tree.walk(walk, 1.0, 16)
    assert answered > 0.8 * len(walk)


def test_a_list_notices_new_points():
    points = clouds()["random"].astype(np.float32)[:500]
    tree = testing.KdTree()
    tree.build(points)
    walk = walk_through(points, 1e-4)[:40]
    tree.walk(walk, 1.0, 16)
    added = walk[:5] + np.float32(1e-3)
    tree.insert(added, 500)
    found, answered = tree.walk(walk, 1.0, 16)
    assert answered > 0
    assert found == expected(np.concatenate([points, added]), walk, 1.0, 16)


def test_points_at_rest_and_outside_are_served():
    points = clouds()["clusters"].astype(np.float32)[::10]
    tree = testing.KdTree()
    tree.build(points)
    walk = np.concatenate([np.repeat(points[:1], 5, 0), np.full((5, 3), 1e6, np.float32)])
    found, _ = tree.walk(walk, 0.5, 16)
    assert found == expected(points, walk, 0.5, 16)
