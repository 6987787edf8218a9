"""Rows of visibility: the right bits, the rays they cost, the same for any threads and packets."""

import numpy as np
import pytest

import viscache as vc
from correlation.scenes import above, clutter, convex, masked, squares, unpacked
from render.test_interrupt import LIMIT, quickest_stop
from viscache import _core
from viscache.correlation.rows import trace_rows

SKY = vc.correlation.DirectionSet(map_size=24)


def rows_of(scene, n=200, sky=SKY, where="camera"):
    points = vc.correlation.surface_points(scene, n, points=where, seed=1)
    return points, vc.correlation.visibility_rows(scene, points, sky)


def spawned(scene, points):
    """Where rays start (visibility/query.h): 8 units in the last place off the surface."""
    extent = np.float32(scene._core.offset_extent)
    size = np.maximum(np.abs(points.positions).max(1), extent)
    step = np.float32(8) * np.float32(2.0**-23) * size
    return np.asarray(points.positions + points.normals * step[:, None])


@pytest.mark.parametrize("map_size", [1, 5, 8, 23, 33])
def test_rows_say_what_single_rays_say(map_size):
    scene, sky = clutter(), vc.correlation.DirectionSet(map_size=map_size)
    points, rows = rows_of(scene, 300, sky)
    directions, origins = sky.directions, spawned(scene, points)
    wanted = above(points.normals, directions)
    i, k = np.nonzero(wanted)
    expected = np.zeros_like(wanted)
    expected[i, k] = ~scene.occluded(origins[i], directions[k])
    assert rows.n_directions == map_size**2
    assert rows.bits.shape == (300, -(-(map_size**2) // 512) * 8)
    np.testing.assert_array_equal(unpacked(rows.bits, map_size**2), expected)
    assert not unpacked(rows.bits, 64 * rows.bits.shape[1])[:, map_size**2 :].any()
    assert rows.n_rays == wanted.sum()
    assert rows.seconds > 0
    if map_size > 5:
        assert 0.1 < expected.sum() / wanted.sum() < 0.9


def test_records_of_even_maps_cost_half_their_cells():
    """The identity of Table 2: cell centres are symmetric, so every point traces T/2 rays."""
    for scene in (clutter(), convex()):
        assert rows_of(scene, 300)[1].n_rays == 300 * 24**2 // 2


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("where", ["camera", "area"])
def test_points_of_a_convex_body_see_all_that_lies_above(scale, where):
    """ρ = 1 − 2θ/π follows from these bits."""
    points, rows = rows_of(convex(scale), 2000, where=where)
    seen = unpacked(rows.bits, rows.n_directions)
    np.testing.assert_array_equal(seen, above(points.normals, SKY.directions))


@pytest.mark.extreme
def test_far_from_the_origin_a_convex_body_still_sees_the_sky():
    """At 1e5 sizes rounded vertices make it slightly less convex."""
    scene = convex(1.0, at=(1e5, -1e5, 1e5), vertices=60)
    points, rows = rows_of(scene, 2000, where="area")
    wrong = unpacked(rows.bits, rows.n_directions) != above(points.normals, SKY.directions)
    assert wrong.sum() / rows.n_rays < 2e-3


def test_rays_pass_holes_and_are_stopped_by_what_is_solid():
    """Under a square that is solid for x < 0.25 and a hole beyond."""
    scene = masked(0.25)
    x = np.linspace(0.05, 0.95, 19)
    positions = np.stack([x, 0 * x + 0.5, 0 * x - 1], 1)
    rows = trace_rows(scene, positions, np.tile([0, 0, 1.0], (19, 1)), SKY)
    d = SKY.directions.astype(float)
    hit = positions[:, None, :2] + (d / np.maximum(d[:, 2:], 1e-9))[None, :, :2]
    solid = (hit[..., 0] > 0) & (hit[..., 0] < 0.25) & (hit[..., 1] > 0) & (hit[..., 1] < 1)
    edge = np.minimum(abs(hit[..., 0] - 0.25), abs(hit[..., 0] - 1)) < 1e-3
    up = np.broadcast_to(d[:, 2] > 1e-6, solid.shape) & ~edge
    seen = unpacked(rows.bits, rows.n_directions)
    np.testing.assert_array_equal(seen[up], ~solid[up])
    assert 100 < solid[up].sum() < 0.5 * up.sum()


def squares_hide(scale, t_max=np.inf):
    """Directions from below the middle of a horizontal square, one above, that it stops."""
    d = SKY.directions.astype(float)
    up = d[:, 2] > 1e-6
    distance = 1 / np.where(up, d[:, 2], 1)
    inside = (abs(d[:, :2] * distance[:, None]) < scale / 2).all(1)
    return np.asarray(up & inside & (distance < t_max))


UNDER = np.array([[0.5, 0.5, -1]]), np.array([[0, 0, 1.0]])


def test_instances_stop_rays():
    d = vc.SceneDescription()
    vertices, triangles = squares()
    card = d.add_mesh(
        vertices - [0.5, 0.5, 0], triangles, material=d.add_material(), in_world=False
    )
    d.add_instance([card], np.array([[3.9, 0, 0, 0.5], [0, 3.9, 0, 0.5], [0, 0, 1, 0.0]]))
    rows = trace_rows(vc.Scene.from_description(d), *UNDER, SKY)
    hidden = above(np.float32(UNDER[1]), SKY.directions) & ~unpacked(rows.bits, 24**2)
    np.testing.assert_array_equal(hidden[0], squares_hide(3.9))
    assert hidden.sum() > 100


def test_t_max_ends_the_rays():
    """Rays end before the square above, or reach only its middle."""
    for t_max in (0.99, 1.2, np.inf):
        rows = trace_rows(masked(1.0), *UNDER, SKY, t_max=t_max)
        hidden = above(np.float32(UNDER[1]), SKY.directions) & ~unpacked(rows.bits, 24**2)
        np.testing.assert_array_equal(hidden[0], squares_hide(1.0, t_max))
    assert squares_hide(1.0, 0.99).sum() == 0
    assert 10 < squares_hide(1.0, 1.2).sum() < squares_hide(1.0).sum()


def test_neither_threads_nor_packets_nor_the_order_of_points_change_a_bit():
    scene = clutter()
    points = vc.correlation.surface_points(scene, 3000, seed=2)

    def traced(order, threads, which=slice(None)):
        return _core.correlation.visibility_rows(
            scene._core,
            scene.caster(),
            points.positions[which],
            points.normals[which],
            SKY.directions,
            order=order,
            threads=threads,
        )

    bits, rays = traced(None, 1)
    for order in (None, *_core.PacketOrder):
        for threads in (1, 2, 8):
            again, rays_again = traced(order, threads)
            np.testing.assert_array_equal(again, bits)
            assert rays_again == rays
    turned = np.random.default_rng(0).permutation(3000)
    np.testing.assert_array_equal(traced(None, 2, turned)[0], bits[turned])
    np.testing.assert_array_equal(traced(None, 2, slice(100, 333))[0], bits[100:333])


def test_no_points_have_no_rows():
    rows = trace_rows(convex(), np.zeros((0, 3)), np.zeros((0, 3)), SKY)
    assert rows.bits.shape == (0, 16) and rows.n_rays == 0


@pytest.mark.slow
@pytest.mark.parametrize("map_size", [96, 256])
def test_ctrl_c_stops_the_tracing_soon(map_size):
    points = "vc.correlation.surface_points(scene, 1 << 18)"
    sky = f"vc.correlation.DirectionSet(map_size={map_size})"
    assert quickest_stop(f"vc.correlation.visibility_rows(scene, {points}, {sky})", 1.5) < LIMIT


ONE = [[0.0, 0.0, 1.0]]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"normals": [[0, 0, 2.0]]}, "normals must be unit vectors, row 0 has length 2"),
        ({"normals": [[0, 0, np.nan]]}, "normals must be finite and at most 1e16 in size, row 0"),
        ({"normals": np.zeros((2, 3))}, "normals must be unit vectors, row 0 has length 0"),
        ({"normals": ONE * 2}, r"positions and normals must have equal numbers of rows, got \(1"),
        ({"positions": [[1e17, 0, 0]]}, "positions must be finite and at most 1e16 in size, row 0"),
        ({"positions": [[1e40, 0, 0]]}, "positions must be finite and at most 1e16 in size, row 0"),
        ({"positions": np.zeros((1, 2))}, r"positions must have shape \(N, 3\), got \(1, 2\)"),
        ({"positions": [["a", "b", "c"]]}, "positions must be numbers"),
        ({"t_max": 0.0}, "t_max must be > 0, got 0"),
        ({"t_max": np.nan}, "t_max must be > 0, got nan"),
        ({"threads": -1}, r"threads must be a whole number in \[1, 1024\], got -1"),
        ({"scene": 5}, "scene must be a Scene, a file or a built-in name, got 5"),
        ({"directions": [[0, 0, 1.0]]}, "directions must be a DirectionSet"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    given = {"scene": convex(), "positions": ONE, "normals": ONE, "directions": SKY} | arguments
    with pytest.raises(ValueError, match=message):
        trace_rows(**given)
