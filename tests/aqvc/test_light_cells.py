"""Light cells of samples per eye point, numbered as columns."""

import numpy as np
import pytest

from aqvc import tiles
from core import testing
from reference import aqvc, aqvc_samples
from reference.isas import AVAILABLE
from viscache import _core


def cells(semantic, far, normal, density, **options):
    """Columns and clamps from C++."""
    limit = {"limit": options.pop("limit")} if "limit" in options else {}
    column, clamps = testing.light_cells(
        _core.aqvc.AqvcParameters(**options),
        tiles.CENTER,
        tiles.RADIUS,
        semantic=semantic,
        far=np.float32(far),
        normal=np.float32(normal),
        density=density,
        **limit,
    )
    return column, clamps


def directions(n, seed=3):
    """Unit vectors all around, the axes among them."""
    w = np.random.default_rng(seed).normal(size=(n, 3))
    w[:6] = np.concatenate([np.eye(3), -np.eye(3)])
    return (w / np.linalg.norm(w, axis=1, keepdims=True)).astype(np.float32)


@pytest.mark.parametrize("c_r", [1.2, 2.0])
def test_directions_get_the_columns_of_a_dictionary(c_r):
    """Eq. 9 for densities from one cell to far beyond the tables per rung."""
    w = directions(4000)
    density = np.exp(np.random.default_rng(4).uniform(-3, 12, len(w))).astype(np.float32)
    want = aqvc_samples.columns(
        [aqvc_samples.direction_key(a, b, c_r) for a, b in zip(w, density, strict=True)]
    )
    column, clamps = cells(tiles.SOLID_ANGLE, w, np.zeros_like(w), density, c_r=c_r)
    assert column == want
    assert max(want) > 2000 and (np.sqrt(4 * np.pi * density) > 400).sum() > 100
    assert clamps["low"] == (4 * np.pi * density.astype(float) < 1).sum() > 0


def test_points_of_lights_get_the_columns_of_a_dictionary():
    rng = np.random.default_rng(5)
    n = directions(1500)
    n[:700] = [0, -1, 0]
    y = rng.uniform(-2, 2, (1500, 3)).astype(np.float32)
    y[:700, 1] = 3
    density = np.exp(rng.uniform(-3, 4, 1500)).astype(np.float32)
    grid = aqvc.Grid(np.float32(tiles.CENTER), tiles.RADIUS)
    keys = [aqvc_samples.surface_key(grid, *a) for a in zip(y, n, density, strict=True)]
    assert cells(tiles.SURFACE, y, n, density)[0] == aqvc_samples.columns(keys)


@pytest.mark.extreme
def test_what_is_not_finite_has_no_column_and_odd_densities_are_counted():
    bad = [[np.nan, 0, 1], [0, 0, np.inf], [0, -np.inf, 0], [0, 0, 0], [1, np.nan, np.inf]]
    ok = [[0, 0, 1], [1e-30, 0, 0], [3e30, 3e30, 0]]
    column, _ = cells(tiles.SOLID_ANGLE, bad + ok, np.zeros((8, 3)), [20.0] * 8)
    assert column[:5] == [-1] * 5 and min(column[5:]) >= 0
    column, _ = cells(tiles.SURFACE, bad + ok, [[0, 1, 0]] * 8, [20.0] * 8)
    assert [k < 0 for k in column] == [True, True, True, False, True, False, False, False]
    column, _ = cells(tiles.SURFACE, ok, np.zeros((3, 3)), [20.0] * 3)
    assert column == [-1] * 3
    odd = [np.nan, np.inf, -1.0, 0.0, 1e-30, 1e38]
    column, clamps = cells(tiles.SOLID_ANGLE, [[0, 0, 1]] * 6, np.zeros((6, 3)), odd)
    assert min(column) == 0 and clamps["nan"] == 2 and clamps["low"] == 2 and clamps["high"] == 2
    assert column[3] == column[4] != column[0]


def test_cells_beyond_the_room_have_no_column_and_known_ones_keep_theirs():
    for semantic in (tiles.SOLID_ANGLE, tiles.SURFACE):
        for density in (30.0, 3e4):
            far = np.concatenate([directions(300), directions(300)])
            args = (semantic, far, np.tile(np.float32([0, 1, 0]), (600, 1)), [density] * 600)
            whole, part = np.array(cells(*args)[0]), np.array(cells(*args, limit=7)[0])
            np.testing.assert_array_equal(part, np.where(whole < 7, whole, -2))
            assert (whole >= 7).sum() > 100


@pytest.mark.parametrize("isa", AVAILABLE)
def test_every_instruction_set_maps_directions_to_the_same_bits(isa):
    w = directions(1001) * np.float32(7)
    u, v = testing.octahedral_batch(w, isa=isa)
    want = testing.octahedral_square(w)
    np.testing.assert_array_equal(np.stack([u, v], axis=1), want)
    u, v = testing.octahedral_batch(np.float32([[0, 0, 0], [0, 0, np.inf]]), isa=isa)
    assert np.isnan(u).all()
