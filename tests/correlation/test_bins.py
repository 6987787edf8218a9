"""Bins and slices: unions of cells, exactly."""

import numpy as np
import pytest

from viscache.correlation.bins import Bins, centers, linear_bins, merge, pilot_d_max


def test_cells_serve_the_table_and_both_slices():
    bins = linear_bins(25.0)
    assert len(bins.d_edges) == 129 and np.isinf(bins.d_edges[-1])
    assert len(bins.theta_edges_deg) == 181 and bins.theta_edges_deg[-1] == 180
    assert len(bins.slice_d_edges) == len(bins.slice_theta_edges_deg) == 65
    for edges in (bins.d_edges, bins.slice_d_edges, [0.0, 0.2]):
        assert set(edges) <= set(bins.d_cells)
    for edges in (bins.theta_edges_deg, bins.slice_theta_edges_deg, [0.0, 2.0]):
        assert set(edges) <= set(bins.theta_cells)
    assert len(bins.d_cells) == 130  # the slice over d takes every second edge


@pytest.mark.parametrize("d_max", [0.6, 6.4, 25.6, 12.8, 1 / 3, 1e-4, 3e6])
def test_edges_that_rounding_alone_tells_apart_are_one(d_max):
    bins = linear_bins(d_max)
    finite = bins.d_cells[np.isfinite(bins.d_cells)]
    assert (np.diff(finite) > 1e-6 * finite[1:]).all()
    assert bins.slice_d in bins.d_cells and bins.slice_d == pytest.approx(0.2)


def test_merging_cells_is_counting_in_bins():
    rng = np.random.default_rng(0)
    fine, coarse = np.array([0, 0.2, 0.5, 1, 2, np.inf]), np.array([0.2, 1, np.inf])
    values = rng.integers(0, 100, (3, 5))
    assert (
        merge(values, 1, fine, coarse)
        == np.stack([values[:, 1] + values[:, 2], values[:, 3] + values[:, 4]], axis=1)
    ).all()
    with pytest.raises(ValueError, match="edges must be among those of the cells"):
        merge(values, 1, fine, np.array([0.1, 1.0]))


def test_centres_of_an_open_bin_are_as_wide_as_its_neighbour():
    assert centers(np.array([0.0, 1.0, 2.0, np.inf])).tolist() == [0.5, 1.5, 2.5]


def test_the_pilot_finds_the_99th_percentile_of_all_distances():
    p = np.random.default_rng(1).random((500, 3)).astype(np.float32)
    i, j = np.triu_indices(500, 1)
    exact = np.percentile(np.linalg.norm(p[i].astype(float) - p[j], axis=1), 99)
    found = pilot_d_max(p, 0)
    assert exact <= found <= exact * 1.011
    many = np.random.default_rng(2).random((5000, 3)).astype(np.float32)
    assert pilot_d_max(many, 0) == pilot_d_max(many, 0)
    assert pilot_d_max(many, 0) == pytest.approx(found, rel=0.03)
    assert pilot_d_max(np.ones((5, 3), np.float32), 0) == 1.0


@pytest.mark.extreme
@pytest.mark.parametrize("scale", [1e-15, 1e15])
def test_the_pilot_takes_any_unit(scale):
    p = np.random.default_rng(1).random((300, 3)).astype(np.float32)
    assert pilot_d_max(p * np.float32(scale), 0) == pytest.approx(
        pilot_d_max(p, 0) * scale, rel=0.02
    )


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"d_edges": [0.0]}, "d_edges must be at least two rising numbers"),
        ({"d_edges": [0.0, 2.0, 1.0]}, "rising"),
        ({"d_edges": [-1.0, 2.0]}, "numbers >= 0"),
        ({"d_edges": [0.0, np.nan]}, "rising"),
        ({"d_edges": [[0.0, 1.0]]}, "rising"),
        ({"theta_edges_deg": [0.0, 181.0]}, r"theta_edges_deg must lie in \[0, 180\]"),
        ({"slice_d": 0.0}, "slice_d must be a number > 0"),
        ({"slice_d": np.nan}, "slice_d must be a number > 0"),
        ({"slice_theta_deg": 200.0}, "slice_theta_deg must be a number in"),
        ({"d_end": -1.0}, "d_end must be a number > 0"),
        ({"slice_d": [0.2, 1.0]}, "slice_d must be a number > 0"),
        ({"slice_theta_deg": "2"}, "slice_theta_deg must be a number in"),
        ({"d_end": [1.0]}, "d_end must be a number > 0"),
    ],
)
def test_bins_that_cannot_be_are_refused(change, says):
    given = {"d_edges": [0.0, 1.0], "theta_edges_deg": [0.0, 180.0]} | change
    with pytest.raises(ValueError, match=says):
        Bins(**given)


@pytest.mark.parametrize(("d_max", "n"), [(0.0, 4), (np.inf, 4), (1.0, 0), (1.0, 2000)])
def test_even_bins_that_cannot_be_are_refused(d_max, n):
    with pytest.raises(ValueError, match="must be"):
        linear_bins(d_max, n)
