"""Directions of the visibility field: how many, where, how much of the sky, which is nearest."""

import numpy as np
import pytest
from scipy.spatial import SphericalVoronoi, cKDTree

import viscache as vc
from viscache.vlf import DIRECTION_COUNTS

SUBDIVIDED = DIRECTION_COUNTS[1:]


def random_directions(n, seed=0):
    return np.random.default_rng(seed).normal(size=(n, 3)).astype(np.float32)


def both_signs(axes):
    """Axes in double, on the sphere, then their opposites."""
    exact = axes.astype(float)
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    return np.concatenate([exact, -exact])


@pytest.mark.parametrize("n", DIRECTION_COUNTS)
def test_axes_are_distinct_units_of_the_upper_half(n):
    axes = vc.vlf.directions(n)
    assert axes.shape == (n, 3) and axes.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(axes.astype(float), axis=1), 1, atol=2e-7)
    assert (axes[:, 2] >= 0).all()
    assert len(np.unique(both_signs(axes).round(6) + 0.0, axis=0)) == 2 * n
    subdivisions = round(((n - 1) / 2) ** 0.5)
    assert (axes[:, 2] == 0).sum() == 2 * subdivisions  # half of the equator's 4N vertices


def test_the_lattice_is_the_octahedron_halved_again_and_again():
    """Written from the definition: midpoints of all edges, moved to the sphere."""
    triangles = [
        np.array(t, float)
        for t in (
            [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
            [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
            [[0, 0, 1], [-1, 0, 0], [0, -1, 0]],
            [[0, 0, 1], [0, -1, 0], [1, 0, 0]],
        )
    ]
    for _ in range(4):
        parts = []
        for a, b, c in triangles:
            ab, bc, ca = (m / np.linalg.norm(m) for m in (a + b, b + c, c + a))
            parts += [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        triangles = [np.array(t) for t in parts]
    vertices = np.unique(np.concatenate(triangles).round(9) + 0.0, axis=0)
    assert len(vertices) == 545
    found = both_signs(vc.vlf.directions(513))
    assert cKDTree(found).query(vertices)[0].max() < 1e-6
    x, y, z = vertices.T
    kept = vertices[(z > 0) | (y > 0) | ((y == 0) & (x > 0))]
    assert len(kept) == 513
    assert cKDTree(kept).query(vc.vlf.directions(513))[0].max() < 1e-6


@pytest.mark.parametrize("n", DIRECTION_COUNTS)
def test_frames_are_orthonormal_right_handed_and_turn_the_axis_to_z(n):
    frames = vc.vlf.direction_frames(n).astype(float)
    np.testing.assert_allclose(
        frames @ frames.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (n, 3, 3)), atol=1e-6
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1, atol=1e-6)
    np.testing.assert_array_equal(frames[:, 2], vc.vlf.directions(n))


@pytest.mark.parametrize("n", SUBDIVIDED)
def test_weights_are_the_areas_of_spherical_voronoi_cells(n):
    weights = vc.vlf.direction_weights(n).astype(float)
    assert abs(weights.sum() / (2 * np.pi) - 1) < 1e-6
    areas = SphericalVoronoi(both_signs(vc.vlf.directions(n)), threshold=1e-9).calculate_areas()
    np.testing.assert_allclose(weights, areas[:n], rtol=2e-4)
    np.testing.assert_allclose(weights, areas[n:], rtol=2e-4)


def test_one_direction_has_the_whole_half_sphere():
    np.testing.assert_array_equal(vc.vlf.directions(1), [[0, 0, 1]])
    np.testing.assert_allclose(vc.vlf.direction_weights(1), [2 * np.pi], rtol=1e-6)
    assert (vc.vlf.nearest_direction(random_directions(100), 1) == 0).all()


def test_cells_vary_as_the_documentation_says():
    weights = vc.vlf.direction_weights(513)
    assert weights.min() / weights.mean() == pytest.approx(0.79, abs=0.01)
    assert weights.max() / weights.mean() == pytest.approx(1.60, abs=0.01)


@pytest.mark.parametrize("n", SUBDIVIDED)
def test_the_nearest_axis_is_the_one_a_search_finds(n):
    axes = vc.vlf.directions(n)
    d = random_directions(100_000, seed=n)
    d[:10_000, 2] *= 1e-3  # near the equator, where axes meet their opposites
    d[10_000:20_000, :2] *= 1e-3
    found = vc.vlf.nearest_direction(d, n)
    unit = d.astype(float) / np.linalg.norm(d.astype(float), axis=1, keepdims=True)
    distance, _ = cKDTree(both_signs(axes)).query(unit)
    chosen = np.abs((unit * both_signs(axes)[found]).sum(1))
    # By chords: |d − ω|² = 2 − 2 cos. Equal within the rounding of a float's cosine
    assert (chosen >= 1 - distance**2 / 2 - 3e-7).all()


@pytest.mark.parametrize("n", SUBDIVIDED)
def test_opposite_directions_have_the_same_axis(n):
    d = random_directions(100_000, seed=5)
    d[:1000, 2] = 0
    d[1000:2000, 2] = -0.0
    d[2000:2500, 2] = 1e-42
    d[2500:3000, :2] *= 1e-30
    np.testing.assert_array_equal(vc.vlf.nearest_direction(d, n), vc.vlf.nearest_direction(-d, n))


@pytest.mark.parametrize("n", DIRECTION_COUNTS)
@pytest.mark.parametrize("sign", [1, -1])
def test_axes_are_nearest_to_themselves_at_any_length(n, sign):
    axes = vc.vlf.directions(n)
    for length in (1e-30, 1.0, 1e16):
        given = (axes * np.float32(sign * length)).astype(np.float32)
        np.testing.assert_array_equal(vc.vlf.nearest_direction(given, n), np.arange(n))


def test_angles_to_the_nearest_axis_halve_from_level_to_level():
    d = random_directions(200_000)
    unit = d / np.linalg.norm(d, axis=1, keepdims=True)
    angles = {}
    for n in (33, 129, 513, 2049, 8193):
        near = vc.vlf.directions(n)[vc.vlf.nearest_direction(d, n)]
        angles[n] = np.degrees(np.arccos(np.minimum(1, np.abs((unit * near).sum(1)))))
    assert angles[513].mean() == pytest.approx(2.46, abs=0.03)
    assert angles[513].max() == pytest.approx(4.99, abs=0.1)
    for n in (33, 129, 513, 2049):
        assert angles[n].mean() / angles[4 * n - 3].mean() == pytest.approx(2, rel=0.02)


@pytest.mark.parametrize("n", [0, 2, 4, 5, 512, 514, 545, 32769, -1, 513.5, "many", None, True])
def test_other_counts_are_refused_with_those_there_are(n):
    with pytest.raises(ValueError, match=r"1, 3, 9, 33, 129, 513, 2049, 8193 .*, got"):
        vc.vlf.directions(n)


@pytest.mark.parametrize("bad", [[0, 0, 0], [np.nan, 0, 1], [np.inf, 0, 0]])
def test_directions_without_direction_are_refused_by_row(bad):
    with pytest.raises(ValueError, match="row 1"):
        vc.vlf.nearest_direction([[0, 0, 1], bad], 33)
