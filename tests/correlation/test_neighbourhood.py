"""Pairs near each other: exhaustive, and means per point."""

from dataclasses import replace

import numpy as np
import pytest

from correlation.points import SUMS, random_points
from correlation.test_pair_bins import assert_sums, expected
from reference.isas import AVAILABLE
from viscache.correlation import pairs


def clustered(n, seed):
    """Points on two planes and in clusters, some of them alike, far from the origin."""
    points = random_points(n, 200, seed=seed)
    positions = points.positions.copy()
    positions[: n // 2, 2] = 0
    positions[n // 2 : 3 * n // 4] *= np.float32(0.01)
    positions[-n // 10 :] = positions[0]
    return replace(points, positions=positions + np.float32(100))


@pytest.mark.parametrize("d_near", [1e-4, 0.02, 0.3, 5])
@pytest.mark.parametrize("seed", [0, 1])
def test_near_pairs_are_those_of_brute_force(d_near, seed):
    """Among 1200 points, exactly."""
    points = clustered(1200 if (d_near, seed) == (0.02, 0) else 400, seed)
    edges, angles = np.linspace(0, d_near, 4), np.arange(0, 181, 20.0)
    table = pairs.near_pairs(*points.arguments, edges, angles, d_near=edges[-1])
    sums = expected(points, edges, angles)
    assert sums["n"].sum() > 100
    assert_sums(table, sums)


def test_near_pairs_do_not_depend_on_threads_or_instruction_set():
    points = clustered(800, 3)
    tables = [
        pairs.near_pairs(
            *points.arguments, [0, 0.1, 0.2], [0, 90, 180], d_near=0.2, threads=threads, isa=isa
        )
        for threads in (1, 2, 8)
        for isa in AVAILABLE
    ]
    for table in tables[1:]:
        for name in (*SUMS, "sum_q2_high", "sum_q2_low"):
            assert getattr(table, name).tobytes() == getattr(tables[0], name).tobytes()


@pytest.mark.extreme
@pytest.mark.parametrize("scale", [1e-12, 1e-6, 1e6, 1e12])
def test_the_grid_holds_scenes_of_any_size(scale):
    points = random_points(200, 70)
    points = replace(points, positions=points.positions * np.float32(scale))
    edges, angles = np.array([0, 0.05, 0.3]) * scale, [0, 180]
    table = pairs.near_pairs(*points.arguments, edges, angles, d_near=edges[-1])
    assert_sums(table, expected(points, edges, angles))


@pytest.mark.extreme
def test_a_scene_much_larger_than_the_distance_bins_exactly():
    """More cells than an axis has numbers: cells become wider."""
    points = random_points(300, 70)
    positions = points.positions.copy()
    positions[::2] *= np.float32(1e9)
    points = replace(points, positions=positions)
    table = pairs.near_pairs(*points.arguments, [0, 0.1], [0, 180], d_near=0.1)
    assert_sums(table, expected(points, [0, 0.1], [0, 180]))


def brute_force_map(points, d_max, theta_max_deg):
    rho = pairs.phi(points.bits, points.bits, points.visible.shape[1]).astype(np.float64)
    apart = points.positions[:, None] - points.positions[None]
    near = np.linalg.norm(apart, axis=2) < d_max
    cosine = points.normals.astype(np.float64) @ points.normals.T.astype(np.float64)
    near &= np.degrees(np.arccos(np.clip(cosine, -1, 1))) < theta_max_deg
    np.fill_diagonal(near, False)
    near &= np.isfinite(rho)
    with np.errstate(invalid="ignore"):
        return np.where(near, rho, 0).sum(1) / near.sum(1)


@pytest.mark.parametrize(("d_max", "theta_max_deg"), [(0.2, 60), (0.5, 20), (3, 180)])
def test_the_spatial_map_is_the_mean_over_neighbours(d_max, theta_max_deg):
    points = random_points(600, 300)
    found = pairs.spatial_map(
        points.bits, points.positions, points.normals, d_max, theta_max_deg, n_directions=300
    )
    wanted = brute_force_map(points, d_max, theta_max_deg)
    assert found.dtype == np.float32
    assert 0 < np.isnan(wanted).sum() < 500
    np.testing.assert_allclose(found, wanted, atol=2e-6)


def test_wrong_arguments_are_refused():
    points = random_points(50, 100)
    rows = (points.bits, points.positions, points.normals)
    with pytest.raises(ValueError, match="d_max must be finite"):
        pairs.spatial_map(*rows, np.inf, 30, n_directions=100)
    with pytest.raises(ValueError, match="must increase"):
        pairs.spatial_map(*rows, 0, 30, n_directions=100)
    with pytest.raises(ValueError, match="theta_edges_deg must lie in"):
        pairs.spatial_map(*rows, 1, 200, n_directions=100)
    with pytest.raises(ValueError, match="d_near must be finite"):
        pairs.near_pairs(*points.arguments, [0, np.inf], [0, 180], d_near=np.inf)
