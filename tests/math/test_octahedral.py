"""math/octahedral.h: octahedral maps of the sphere."""

import numpy as np
import pytest

from core import testing
from reference.isas import AVAILABLE
from sampling.chi_square import p_value
from viscache import _core

maps = _core.sampling
EQUAL_AREA = (maps.direction_to_equal_area, maps.equal_area_to_direction)
OCTAHEDRAL = (testing.direction_to_octahedral, testing.octahedral_to_direction)
BOTH = pytest.mark.parametrize("pair", [OCTAHEDRAL, EQUAL_AREA], ids=["octahedral", "equal area"])


def directions(n):
    """Random directions, and those where the maps fold: poles, axes, z = ±0, near both."""
    rng = np.random.default_rng(1)
    d = rng.normal(size=(n, 3))
    flat = rng.normal(size=(1000, 3)) * [1, 1, 0]
    flat[500:, 2] = -0.0
    steep = rng.normal(size=(1000, 3)) * [1e-4, 1e-4, 1]
    thin = rng.normal(size=(1000, 3)) * [1, 1e-6, 1]
    low = rng.normal(size=(1000, 3)) * [1, 1, 1e-7]
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    d = np.concatenate([d, flat, steep, thin, low, axes])
    return d / np.linalg.norm(d, axis=1)[:, None]


def octahedral_transcription(d):
    u, v = d[:, :2].T / np.abs(d).sum(1)
    sign_u, sign_v = np.where(u >= 0, 1, -1), np.where(v >= 0, 1, -1)
    below = d[:, 2] < 0
    u, v = (
        np.where(below, (1 - np.abs(v)) * sign_u, u),
        np.where(below, (1 - np.abs(u)) * sign_v, v),
    )
    return np.stack([u, v], 1) / 2 + 0.5


def test_the_octahedral_map_is_the_published_one():
    d = directions(100_000)
    expected = octahedral_transcription(d)
    np.testing.assert_allclose(testing.direction_to_octahedral(d), expected, rtol=0, atol=2e-7)


def test_the_octahedral_map_takes_directions_of_any_length():
    d = np.array([[1.0, 2.0, -3.0]])
    for scale in (1e-30, 1e30):
        assert testing.direction_to_octahedral(scale * d) == pytest.approx(
            octahedral_transcription(d), abs=1e-6
        )
    assert testing.direction_to_octahedral(np.zeros((1, 3))).tolist() == [[0.5, 0.5]]


@BOTH
def test_directions_survive_the_round_trip(pair):  # type: ignore[no-untyped-def]
    there, back = pair
    d = directions(1_000_000)
    p = there(d)
    assert p.min() >= 0 and p.max() <= 1
    assert np.abs(back(p) - d).max() <= 1e-6


@BOTH
def test_the_border_of_the_square_is_folded_onto_itself(pair):  # type: ignore[no-untyped-def]
    _, back = pair
    t = np.linspace(0, 1, 101)
    for end in (0.0, 1.0):
        edge = np.stack([t, np.full(101, end)], 1)
        assert back(edge) == pytest.approx(back(edge * [-1, 1] + [1, 0]), abs=1e-6)
    assert back(np.array([[0.5, 0.5]]))[0] == pytest.approx([0, 0, 1], abs=1e-6)
    assert back(np.array([[0, 0], [0, 1], [1, 0], [1, 1.0]])) == pytest.approx(
        np.tile([0, 0, -1.0], (4, 1)), abs=1e-6
    )


def equal_area_there(d):
    """The equal-area octahedral map in double."""
    x, y, z = np.abs(d).T
    r = np.sqrt((x * x + y * y) / (1 + z))
    phi = np.where((x == 0) & (y == 0), 0, 2 / np.pi * np.arctan2(y, x))
    v = phi * r
    u = r - v
    u, v = np.where(d[:, 2] < 0, 1 - v, u), np.where(d[:, 2] < 0, 1 - u, v)
    return (np.copysign(np.stack([u, v], 1), d[:, :2]) + 1) / 2


def equal_area_back(p):
    u, v = (2 * p - 1).T
    delta = 1 - np.abs(u) - np.abs(v)
    r = 1 - np.abs(delta)
    turn = (np.abs(v) - np.abs(u)) / np.where(r == 0, 1, r) + np.where(r == 0, 0, 1)
    phi = np.where(r == 0, np.pi / 4, np.pi / 4 * turn)
    s = r * np.sqrt(np.maximum(0, 2 - r * r))
    z = np.copysign(1 - r * r, delta)
    return np.stack([np.copysign(np.cos(phi) * s, u), np.copysign(np.sin(phi) * s, v), z], 1)


def test_the_equal_area_map_is_the_published_one():
    p = np.random.default_rng(4).random((1_000_000, 2)).astype(np.float32).astype(float)
    d = equal_area_back(p)
    assert np.abs(equal_area_there(d) - p).max() < 1e-13
    assert np.abs(maps.equal_area_to_direction(p) - d).max() < 1e-7
    assert np.abs(maps.direction_to_equal_area(d) - p).max() < 5e-7
    special = directions(1000)
    assert np.abs(equal_area_back(equal_area_there(special)) - special).max() < 5e-9
    assert np.abs(maps.direction_to_equal_area(special) - equal_area_there(special)).max() < 5e-7


@pytest.mark.parametrize("isa", AVAILABLE)
def test_batches_have_the_bits_of_single_points(isa):
    inside = np.random.default_rng(6).random((4096, 2))
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 8)] * 2), -1).reshape(-1, 2)
    p = np.concatenate([inside, grid, np.full((16, 2), 0.5)]).astype(np.float32)
    directions, back = testing.equal_area_round_trip(p, isa=isa)
    single = maps.equal_area_to_direction(p)
    assert directions.tobytes() == single.tobytes()
    assert back.tobytes() == maps.direction_to_equal_area(single).tobytes()


def test_a_batch_is_whole_vectors():
    with pytest.raises(ValueError, match="multiple of 16, got 3"):
        testing.equal_area_round_trip(np.zeros((3, 2)))


def spherical_triangles(a, b, c):
    """Solid angles (Van Oosterom and Strackee 1983)."""
    numerator = np.abs(np.einsum("...i,...i", a, np.cross(b, c)))
    dots = [np.einsum("...i,...i", *pair) for pair in ((a, b), (b, c), (c, a))]
    return 2 * np.arctan2(numerator, 1 + sum(dots))


def cell_solid_angles(back, cells, sub):  # type: ignore[no-untyped-def]
    """Of cells × cells, each cut into sub × sub quads, each into two triangles along the fold."""
    n = cells * sub
    t = np.arange(n + 1) / n
    corner = back(np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2)).astype(float)
    corner = corner.reshape(n + 1, n + 1, 3)
    p00, p10, p01, p11 = corner[:-1, :-1], corner[1:, :-1], corner[:-1, 1:], corner[1:, 1:]
    anti = spherical_triangles(p00, p10, p01) + spherical_triangles(p11, p10, p01)
    main = spherical_triangles(p00, p10, p11) + spherical_triangles(p00, p01, p11)
    half = t[:-1] + 0.5 / n > 0.5
    quads = np.where(half[:, None] == half[None, :], anti, main)
    return quads.reshape(cells, sub, cells, sub).sum((1, 3))


def test_octahedral_cells_differ_by_the_factor_that_is_derived():
    """Solid angle per unit square in [4.0, 20.8], mean 4π; cells are exact spherical quads."""
    cells = cell_solid_angles(testing.octahedral_to_direction, 128, 1)
    assert cells.sum() == pytest.approx(4 * np.pi, rel=1e-5)
    ratio = cells * 128**2 / (4 * np.pi)
    assert ratio.min() >= 4.0 / 12.57 - 1e-3 and ratio.max() <= 20.8 / 12.57
    assert ratio.min() < 4.2 / 12.57 and ratio.max() > 19.8 / 12.57  # the bounds are tight


def test_equal_area_texels_span_equal_solid_angles():
    cells = cell_solid_angles(maps.equal_area_to_direction, 16, 32)
    assert cells == pytest.approx(4 * np.pi / 256, rel=2e-3)
    assert cells.sum() == pytest.approx(4 * np.pi, rel=1e-4)


@pytest.mark.stat
def test_uniform_directions_fill_equal_area_texels_evenly():
    d = np.random.default_rng(3).normal(size=(400_000, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]

    def counts(there):  # type: ignore[no-untyped-def]
        i, j = np.minimum((there(d) * 32).astype(int), 31).T
        return np.bincount(i * 32 + j, minlength=1024).astype(float)

    expected = np.full(1024, 400_000 / 1024)
    assert p_value(counts(maps.direction_to_equal_area), expected) >= 1e-3
    assert p_value(counts(testing.direction_to_octahedral), expected) < 1e-6  # negative control
