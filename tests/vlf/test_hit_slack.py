"""A hit nearer to the end of a tile than its rounding error is compared with the next tile's."""

import numpy as np
import pytest

import viscache as vc

ORIGIN, DIRECTION = np.float32([-0.9, 0.05, 0.02]), np.float32([1, 0.13, 0.07])
#: kHitSlack of `vlf/field_walk.h`, in the unit ball, along a ray of length 1.
SLACK = 1e-5


def field(wall):
    """A field of one direction over two small triangles far apart, and a wall across the ray."""
    corner = np.float32([[0, 0, 0], [0.01, 0, 0], [0, 0.01, 0]])
    parts = [corner - np.float32([1, 1, 1]), np.float32([1, 1, 1]) - corner]
    if wall is not None:
        x, y, z = ORIGIN + np.float32(wall) * DIRECTION
        parts.append(np.float32([[x, y - 0.3, z - 0.3], [x, y + 0.5, z - 0.3], [x, y, z + 0.5]]))
    vertices = np.concatenate(parts)
    scene = vc.Scene.from_arrays(vertices, np.arange(len(vertices)).reshape(-1, 3))
    return vc.VisibilityField(scene, settings=vc.Vlf(n_directions=1, n_tiles=16, bsp_depth=0))


def tiles(found, t_max=np.inf):
    """How many tiles the nearest hit of the ray visits, and the triangle."""
    traced = found._core.trace_by(
        ORIGIN[None], DIRECTION[None], np.zeros(1, np.uint32), t_max=np.float32(t_max)
    )
    return traced[3]["tiles"], traced[1][0]


def border(free):
    """Where the ray leaves a tile in the middle of its way."""
    low, high = 0.5, 1.3
    before = tiles(free, low)[0]
    assert tiles(free, high)[0] > before
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if tiles(free, middle)[0] == before else (low, middle)
    return low


def test_a_hit_just_before_the_end_of_a_tile_looks_into_the_next_one():
    end = border(field(None))
    before = tiles(field(None), end - 1e-3)[0]
    seen = {}
    for offset in (0.2, 0.5, 0.8, 3, 10, 100):  # in slacks; the ball's radius is √3
        count, triangle = tiles(field(end - offset * SLACK * np.sqrt(3)))
        assert triangle == 2
        seen[offset] = count - before
    assert [seen[o] for o in (0.2, 0.5)] == [1, 1], "the next tile may hold a nearer hit"
    assert [seen[o] for o in (3, 10, 100)] == [0, 0, 0], "farther ones are not looked into"


def test_a_hit_behind_the_end_of_a_tile_is_found():
    end = border(field(None))
    for offset in (-0.5, 0.0, 0.5):
        wall = end + offset * SLACK
        assert tiles(field(wall))[1] == 2
        assert field(wall).intersect(ORIGIN[None], DIRECTION[None]).t[0] == pytest.approx(wall)
