"""Every point against every target, and queries that broadcast."""

import numpy as np
import pytest

import viscache as vc
from reference.built import built
from viscache.oracles.points import unpack

SCENE = built("room?triangles=4000")


def points(n, seed):
    low, high = SCENE.bounds
    return np.random.default_rng(seed).uniform(low, high, (n, 3)).astype(np.float32)


@pytest.mark.parametrize("shape", [(1, 1), (1, 200), (300, 1), (129, 64), (257, 65), (40, 700)])
@pytest.mark.parametrize("rays", ["embree", "bsp", vc.Vlf(n_directions=33, n_tiles=16)], ids=str)
def test_the_matrix_is_visible_for_every_pair_bit_for_bit(shape, rays):
    x, y = points(shape[0], 1), points(shape[1], 2)
    y[-1] = x[0]  # a pair without length
    bits = SCENE.visible_matrix(x, y, rays=rays)
    assert bits.shape == (shape[0], -(-shape[1] // 64)) and bits.dtype == np.uint64
    one_by_one = SCENE.visible(
        np.repeat(x, len(y), axis=0), np.tile(y, (len(x), 1)), rays=rays
    ).reshape(shape)
    np.testing.assert_array_equal(unpack(bits, shape[1]), one_by_one)
    used = np.zeros(64 * bits.shape[1], bool)
    used[: shape[1]] = True
    assert not unpack(bits, len(used))[:, ~used].any(), "unused bits are 0"
    assert shape[0] < 40 or shape[1] < 64 or 0 < one_by_one.mean() < 1


@pytest.mark.extreme
def test_a_matrix_without_rows_or_columns_is_empty():
    none = np.zeros((0, 3))
    assert SCENE.visible_matrix(none, points(5, 1)).shape == (0, 1)
    assert SCENE.visible_matrix(points(5, 1), none).shape == (5, 0)
    empty = vc.Scene.from_arrays(np.zeros((0, 3)), np.zeros((0, 3), int))
    bits = empty.visible_matrix(points(3, 1), points(70, 2))
    assert unpack(bits, 70).all() and bits[0, 1] == (1 << 6) - 1


@pytest.mark.parametrize(
    ("x", "says"),
    [
        (np.zeros((2, 2)), r"points must have shape \(N, 3\), got \(2, 2\)"),
        (np.zeros(3), r"points must have shape \(N, 3\), got \(3,\)"),
        (np.full((2, 3), np.nan), "points must be finite"),
        (np.full((2, 3), "a"), "points must be numbers"),
    ],
)
def test_bad_points_of_a_matrix_are_refused(x, says):
    with pytest.raises(ValueError, match=says):
        SCENE.visible_matrix(x, points(2, 1))


def test_a_field_answers_the_matrix_too():
    field = vc.VisibilityField(SCENE, 33, 16)
    x, y = points(30, 5), points(70, 6)
    np.testing.assert_array_equal(
        unpack(field.visible_matrix(x, y), 70), field.visible(x[:, None], y)
    )


def test_queries_broadcast_as_numpy_does():
    x, y = points(12, 7).reshape(3, 4, 3), points(4, 8)
    wide = np.broadcast_to(y, (3, 4, 3))
    rows = SCENE.visible(x.reshape(-1, 3), wide.reshape(-1, 3)).reshape(3, 4)
    np.testing.assert_array_equal(SCENE.visible(x, y), rows)
    np.testing.assert_array_equal(SCENE.visible(y, x), rows)
    one = SCENE.visible(x[0, 0], y[0])
    assert one.shape == () and bool(one) == rows[0, 0]
    reach = np.array([0.2, 0.5, 1.0, 2.0])
    towards = y - x
    near = SCENE.occluded(x, towards, reach)
    assert near.shape == (3, 4)
    for i, t_max in enumerate(reach):
        np.testing.assert_array_equal(near[:, i], SCENE.occluded(x[:, i], towards[:, i], t_max))
    many = SCENE.occluded(x[0, 0], towards[0, 0], np.linspace(0, 1, 6).reshape(2, 3))
    assert many.shape == (2, 3)
    hits = SCENE.intersect(x, towards)
    assert hits.t.shape == hits.triangle.shape == (3, 4) and hits.barycentrics.shape == (3, 4, 2)
    flat = SCENE.intersect(x.reshape(-1, 3), towards.reshape(-1, 3))
    np.testing.assert_array_equal(hits.t.reshape(-1), flat.t)
    field = vc.VisibilityField(SCENE, 33, 16)
    assert field.visible(x, y).shape == field.occluded(x, towards).shape == (3, 4)
    moving = vc.vlf.DynamicField(SCENE, vc.Vlf(n_directions=9, n_tiles=8))
    assert moving.intersect(x, towards).barycentrics.shape == (3, 4, 2)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (
            lambda: SCENE.visible(np.zeros((4, 3)), np.zeros((5, 3))),
            r"x and y must have shapes that broadcast, got \(4, 3\) and \(5, 3\)",
        ),
        (
            lambda: SCENE.occluded(np.zeros((2, 3)), np.zeros((2, 1, 3)), np.zeros(3)),
            r"origins and directions and t_max must have shapes that broadcast, got \(2, 3\) and "
            r"\(2, 1, 3\) and \(3,\)",
        ),
        (lambda: SCENE.occluded(np.zeros((2, 3)), np.ones(3), [1.0, -1.0]), "t_max must be >= 0"),
    ],
)
def test_shapes_that_do_not_go_together_are_named(call, says):
    with pytest.raises(ValueError, match=says):
        call()
