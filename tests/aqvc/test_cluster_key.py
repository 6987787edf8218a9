"""Keys: AQVC Eq. 4, Sec. 3.3, 3.5."""

import numpy as np
import pytest

from core import testing
from reference import aqvc as reference
from viscache import _core

aqvc = _core.aqvc
CENTER, RADIUS = np.float32([0.3, -1.0, 2.0]), 7.5


def unit(rng, n):
    v = rng.normal(size=(n, 3))
    return (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32)


def surface_points(n=500, seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform(-4, 4, (n, 3)).astype(np.float32), unit(rng, n)


def keys(points, normals, r, *, semantic=0, far=None, far_normals=None, far_r=None, d=(0, 0), **p):
    """Full keys, places and validity for the given parameters."""
    n = len(points)
    return aqvc.full_keys(
        aqvc.AqvcParameters(**p),
        CENTER,
        RADIUS,
        points,
        normals,
        np.broadcast_to(r, n),
        semantic,
        np.zeros((n, 3)) if far is None else far,
        np.zeros((n, 3)) if far_normals is None else far_normals,
        np.ones(n) if far_r is None else far_r,
        *d,
    )


@pytest.mark.parametrize("normal_mode", ["round", "floor", "octahedral", "single"])
@pytest.mark.parametrize(("c_n", "c_z"), [(8, 4), (8, 8), (2, 1), (5, 3)])
def test_surface_keys_equal_the_transcription(normal_mode, c_n, c_z):
    x, n = surface_points()
    y, m = surface_points(seed=2)
    r = np.exp(np.random.default_rng(3).uniform(0, 10, len(x)))
    modes = {"normal_mode": normal_mode, "c_n": c_n, "c_z": c_z}
    got, place, valid, _ = keys(x, n, r, semantic=2, far=y, far_normals=m, far_r=r[::-1], **modes)
    grid = reference.Grid(CENTER, RADIUS, c_n=c_n, c_z=c_z, mode=normal_mode)
    for i in range(len(x)):
        eye, light = grid.place(x[i], n[i], r[i]), grid.place(y[i], m[i], r[len(x) - 1 - i])
        assert tuple(got[i]) == (2, *eye.key, *light.key)
        assert tuple(place[i]) == eye.f
    assert valid.all()


def test_scale_free_keys_equal_the_transcription_at_any_size():
    """Levels C_R^k for any integer k; coordinates from the origin, folded if they need 64 bits."""
    x, n = surface_points()
    r = np.exp(np.random.default_rng(3).uniform(-12, 20, len(x)))
    got, place, valid, clamps = keys(x, n, r, scale_free=True, c_z=3.0)
    grid = reference.Grid(CENTER, RADIUS, c_z=3.0, scale_free=True)
    folded = 0
    for i in range(len(x)):
        eye = grid.place(x[i], n[i], r[i])
        fits = [abs(v) < 2**31 for v in eye.v]
        own = [v if fit else reference.fold(v) for v, fit in zip(eye.v, fits, strict=True)]
        assert tuple(got[i][1:8]) == (*eye.bins, *own, eye.resolution)
        assert tuple(place[i]) == eye.f
        folded += not all(fits)
    assert valid.all() and not any(clamps.values()) and 0 < folded < len(x)
    assert got[:, 7].min() < -50 and got[:, 7].max() > 50


def test_scale_free_keys_do_not_depend_on_the_scenes_bounding_sphere():
    x, n = surface_points(200)
    y, m = surface_points(200, seed=2)
    spheres = ((CENTER, RADIUS), (CENTER + np.float32(1.5), 3.3 * RADIUS))
    for free in (True, False):
        p, near, far = aqvc.AqvcParameters(scale_free=free), np.full(200, 7.3), np.full(200, 2.1)
        both = [aqvc.full_keys(p, c, b, x, n, near, 2, y, m, far)[0] for c, b in spheres]
        assert (both[0] == both[1]).all() == free


@pytest.mark.extreme
@pytest.mark.parametrize(
    ("r", "clamp"),
    [(0.0, "low"), (1e-30, "low"), (1e30, "high"), (np.inf, "high"), (np.nan, "nan")],
)
def test_scale_free_resolutions_out_of_range_are_clamped_and_counted(r, clamp):
    x, n = surface_points(20)
    got, place, valid, clamps = keys(x, n, r, scale_free=True)
    assert valid.all() and np.isfinite(place).all() and len(np.unique(got[:, 7])) == 1
    assert clamps == {name: 20 if name == clamp else 0 for name in ("low", "high", "nan")}


@pytest.mark.parametrize("semantic", [0, 1])
def test_points_and_directions_are_keyed_by_their_bits(semantic):
    """Sec. 3.5: reinterpreted floats, zero padded, semantic index first."""
    x, n = surface_points(50)
    far = unit(np.random.default_rng(4), 50)
    got = keys(x, n, 30.0, semantic=semantic, far=far)[0]
    np.testing.assert_array_equal(got[:, 8:11], far.view(np.int32))
    assert (got[:, 0] == semantic).all() and (got[:, 11:] == 0).all()


def test_environment_keys_are_octahedral_cells():
    x, n = surface_points(2000)
    w = unit(np.random.default_rng(5), 2000)
    r = np.exp(np.random.default_rng(6).uniform(0, 6, 2000))
    got = keys(x, n, 30.0, semantic=3, far=w, far_r=r)[0]
    big = reference.ladder(r)
    uv = reference.octahedron(w)
    np.testing.assert_array_equal(got[:, 10], big)
    np.testing.assert_array_equal(got[:, 8], np.minimum(big - 1, np.floor(uv[:, 0] * big)))
    np.testing.assert_array_equal(got[:, 9], np.minimum(big - 1, np.floor(uv[:, 1] * big)))


def test_the_octahedral_map_is_a_bijection_with_bounded_cell_areas():
    w = unit(np.random.default_rng(7), 10**6)
    corners = np.float32([[0, 0, 1], [0, 0, -1], [1, 0, 0.0], [1, 0, -0.0], [0, -1, 0]])
    uv = testing.octahedral_square(np.concatenate([w, corners]))
    assert ((uv >= 0) & (uv <= 1)).all()
    z = 1 - np.abs(2 * uv - 1).sum(1)
    xy = np.where(z[:, None] < 0, 0, 2 * uv - 1)
    sign = np.where(2 * uv - 1 >= 0, 1, -1)
    xy = np.where(z[:, None] < 0, (1 - np.abs(2 * uv - 1)[:, ::-1]) * sign, 2 * uv - 1)
    back = np.concatenate([xy, z[:, None]], 1)
    back /= np.linalg.norm(back, axis=1, keepdims=True)
    np.testing.assert_allclose(back, np.concatenate([w, corners]), atol=2e-6)
    counts = np.histogram2d(*uv[:-5].T, bins=8, range=[[0, 1], [0, 1]])[0] / (1e6 / 64)
    noise = 4 / np.sqrt(1e6 / 64 / 3)
    assert counts.min() > 4.0 / 12.57 - noise and counts.max() < 20.8 / 12.57 + noise


@pytest.mark.parametrize("offset", [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_neighbours_on_a_plane_are_the_cells_one_width_away(offset):
    """For any tilt, the ±1 key is the key of the point moved along the plane by one cell."""
    rng = np.random.default_rng(8)
    x, n = rng.uniform(-3, 3, (400, 3)).astype(np.float32), unit(rng, 400)
    r = 300.0
    near, _, _, _ = keys(x, n, r, d=offset)
    grid = reference.Grid(CENTER, RADIUS)
    agree = 0
    for i in range(len(x)):
        placed = grid.place(x[i], n[i], r)
        assert tuple(near[i][1:8]) == placed.neighbour(*offset, True)
        ex, ey, ez = grid.frame(placed.bins)
        w = 2 * RADIUS / placed.resolution
        along = offset[0] * ex + offset[1] * ey
        m = n[i].astype(np.float64)
        moved = x[i] + w * (along - (along @ m) / (ez @ m) * ez)
        agree += grid.place(moved, n[i], r).key == tuple(near[i][1:8])
    assert agree >= 398  # a coordinate at a face may round to either side


def test_without_tangent_neighbours_the_normal_coordinate_is_kept():
    """Alg. 2 as printed: offsets move the first two voxel coordinates only."""
    x, n = surface_points(200)
    own = keys(x, n, 50.0, tangent_neighbours=False)[0]
    near = keys(x, n, 50.0, d=(1, 0), tangent_neighbours=False)[0]
    step = np.zeros(15, np.int32)
    step[4] = 1
    np.testing.assert_array_equal(near, own + step)


def wall_of_no_thickness():
    """Front and back of a wall a thousandth of a cell thick, and a light close behind."""
    x = np.random.default_rng(20).uniform(-2, 2, (400, 3)).astype(np.float32)
    x[:, 1] = 0.0303
    up = np.tile(np.float32([0, 1, 0]), (400, 1))
    width = 2 * RADIUS / 40
    return x, up, x - np.float32(1e-3 * width) * up


@pytest.mark.parametrize(
    ("mode", "c_n", "leaks"),
    [
        ("round", 8, False),
        ("floor", 8, False),
        ("octahedral", 8, False),
        ("single", 8, True),
        ("floor", 1, False),
        ("octahedral", 1, False),
    ],
)
def test_light_leaks_through_a_thin_wall_where_all_normals_share_a_grid(mode, c_n, leaks):
    x, up, behind = wall_of_no_thickness()
    front = keys(x, up, 40.0, normal_mode=mode, c_n=c_n)[0]
    back = keys(behind, -up, 40.0, normal_mode=mode, c_n=c_n)[0]
    shared = np.isin([k.tobytes() for k in front], [k.tobytes() for k in back]).mean()
    assert shared > 0.9 if leaks else shared == 0


@pytest.mark.extreme
@pytest.mark.parametrize(("mode", "low", "high"), [("round", 1, 1), ("floor", 3, 100)])
def test_noise_on_the_normals_of_a_wall_does_not_split_cells(mode, low, high):
    rng = np.random.default_rng(10)
    x = rng.uniform(-4, 4, (5000, 3)).astype(np.float32)
    x[:, 1] = 0
    n = (np.array([0, 1, 0]) + rng.uniform(-1e-3, 1e-3, x.shape)).astype(np.float32)
    bins = np.unique(keys(x, n, 10.0, normal_mode=mode)[0][:, 1:4], axis=0)
    assert low <= len(bins) <= high


@pytest.mark.extreme
@pytest.mark.parametrize("mode", ["round", "floor", "octahedral", "single"])
@pytest.mark.parametrize("c_n", [1, 2, 3, 7, 64])
def test_every_number_of_normal_bins_gives_finite_frames(c_n, mode):
    axes = np.concatenate([np.eye(3), -np.eye(3), np.ones((1, 3)) / np.sqrt(3)]).astype(np.float32)
    got, place, valid, _ = keys(axes * 2, axes, 10.0, c_n=c_n, normal_mode=mode)
    assert valid.all() and np.isfinite(place).all()
    assert (got[:, 1:4] >= 0).all() and (got[:, 1:4] <= 2.17 * c_n + 1).all()
    keys(axes * 2, axes, 10.0, c_n=c_n, normal_mode=mode, d=(1, 0))


@pytest.mark.extreme
@pytest.mark.parametrize(("offset", "split"), [(True, False), (False, True)])
def test_the_grid_offset_keeps_a_plane_through_the_centre_off_cell_faces(offset, split):
    """Position noise of one ulp doubles the cells of such a plane without the offset."""
    rng = np.random.default_rng(11)
    x = rng.uniform(-4, 4, (5000, 3)).astype(np.float32) + CENTER
    x[:, 1] = CENTER[1] + rng.choice([-1e-7, 1e-7], 5000).astype(np.float32)
    up = np.tile(np.float32([0, 1, 0]), (5000, 1))
    got = keys(x, up, 12.0, grid_offset=offset)[0]
    assert (len(np.unique(got[:, 6])) > 1) == split


@pytest.mark.extreme
def test_negative_zero_is_zero_and_what_is_not_finite_has_no_key():
    x, n = surface_points(1)
    plus = keys(x, n, 9.0, far=np.float32([[0.0, 1, 0.0]]))[0]
    minus = keys(x, n, 9.0, far=np.float32([[-0.0, 1, -0.0]]))[0]
    np.testing.assert_array_equal(plus, minus)
    for bad in (np.nan, np.inf):
        assert not keys(x * np.float32(bad), n, 9.0)[2].any()
        assert not keys(x, n, 9.0, far=np.float32([[bad, 0, 0]]))[2].any()
    assert not keys(x, n * 0, 9.0)[2].any()


@pytest.mark.extreme
def test_folded_keys_stay_distinct():
    x, n = surface_points(20000)
    n[:] = [0, 1, 0]
    got = keys(x, n, 1e12)[0]
    assert len(np.unique(got, axis=0)) == len(x) and (got[:, 7] < 0).all()
    grid = reference.Grid(CENTER, RADIUS)
    p = grid.place(x[0], n[0], 1e12)
    assert tuple(got[0, 4:7]) == tuple(reference.fold(v) for v in p.v)


def test_every_grid_seed_shifts_the_grid():
    x, n = surface_points(300)
    all_keys = {s: keys(x, n, 40.0, grid_seed=s)[0].tobytes() for s in range(5)}
    assert len(set(all_keys.values())) == 5
    assert all_keys[0] == keys(x, n, 40.0)[0].tobytes()
