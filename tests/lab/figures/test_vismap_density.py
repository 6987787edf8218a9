"""Density of records, and its rank correlation with what attracts them."""

import numpy as np
import pytest

from viscache_lab.figures.bands import vismap as bands
from viscache_lab.figures.vismap_records import (
    equal_cells,
    per_cell_angle,
    per_cell_mean,
    rank_correlation,
    records_per_cell,
)

RNG = np.random.default_rng(5)


def test_cells_hold_equal_numbers_of_points_near_each_other():
    points = RNG.random((4096, 3)) * (4, 1, 1)
    cell = equal_cells(points, 6)
    assert set(np.bincount(cell)) == {64}
    inside = np.mean([points[cell == k].var(axis=0).sum() for k in range(64)])
    assert inside < 0.05 * points.var(axis=0).sum()


def test_records_are_counted_in_the_cell_of_the_nearest_point():
    points = RNG.random((512, 3))
    cell = equal_cells(points, 3)
    np.testing.assert_array_equal(records_per_cell(points, points, cell), np.full(8, 64))
    near_first = points[cell == 0] + 1e-6
    np.testing.assert_array_equal(records_per_cell(near_first, points, cell), [64] + 7 * [0])


def test_means_leave_out_what_is_not_finite_and_angles_are_those_of_a_cone():
    cell = np.array([0, 0, 1, 1, 2])
    means = per_cell_mean(np.array([1.0, 3.0, np.nan, 5.0, np.nan]), cell)
    np.testing.assert_array_equal(means, [2, 5, np.nan])
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    cone = np.stack([0.5 * np.cos(turn), 0.5 * np.sin(turn), 0 * turn + np.sqrt(0.75)], -1)
    flat = np.tile([0.0, 0.0, 1.0], (60, 1))
    angles = per_cell_angle(np.concatenate([cone, flat]), np.repeat([0, 1], 60))
    np.testing.assert_allclose(angles, [30, 0], atol=1e-4)


@pytest.mark.stat
def test_records_drawn_at_random_correlate_with_nothing_and_attracted_ones_do():
    points = RNG.random((8192, 3))
    cell = equal_cells(points, 9)
    attraction = per_cell_mean(points[:, 0] ** 2, cell)
    chance = points[RNG.integers(0, 8192, 3000)]
    drawn = points[RNG.choice(8192, 3000, p=points[:, 0] ** 2 / (points[:, 0] ** 2).sum())]
    counts = (records_per_cell(r, points, cell) for r in (chance, drawn))
    found = [rank_correlation(count, attraction) for count in counts]
    assert abs(found[0]) < 0.15 and found[0] not in bands.DIFFERENCE_FINDS_LOW_RHO
    assert found[1] in bands.DIFFERENCE_FINDS_LOW_RHO
