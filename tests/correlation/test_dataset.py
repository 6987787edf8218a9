"""The dataset: names, units, derived quantities, and saving and loading."""

import json

import numpy as np
import pytest
import xarray

from correlation.points import bumpy
from viscache.correlation import (
    correlate,
    correlation_lengths,
    high_correlation_box,
    load_dataset,
    measure,
    predicted_variance_ratio,
    save_dataset,
)


@pytest.fixture(scope="module")
def measured():
    return measure("bumpy_spheres?triangles=3000", n_points=400, map_size=16)


def made_up(mean, n=1000):
    """A table over d = 0.5, 1.5, … and θ = 5°, 15°, … with σ = 0.1."""
    values = np.array(mean, dtype=float)
    d, theta = np.arange(values.shape[0]) + 0.5, 10.0 * np.arange(values.shape[1]) + 5
    return xarray.Dataset(
        {
            "mean": (("d", "theta"), values),
            "n": (("d", "theta"), np.broadcast_to(np.array(n), values.shape).copy()),
            "variance_ratio": (("d", "theta"), 1 - values**2 - 0.01),
            "pair_share": ("d", np.ones(len(d))),
        },
        {
            "d": d,
            "d_low": ("d", d - 0.5),
            "d_high": ("d", d + 0.5),
            "theta": theta,
            "theta_low": ("theta", theta - 5),
            "theta_high": ("theta", theta + 5),
        },
    )


def test_the_interface_s_names_and_units_are_there(measured):
    for name in ("mean", "sigma", "se", "n", "n_undefined"):
        assert measured[name].dims == ("d", "theta") and measured[name].attrs["long_name"]
    assert measured.sizes["d"] == 128 and measured.sizes["theta"] == 180
    assert measured["d"].attrs["units"] == "scene units"
    assert measured["theta"].attrs["units"] == "degrees"
    assert measured["near_mean"].dims == ("theta_near",) and measured.sizes["theta_near"] == 64
    assert measured["aligned_mean"].dims == ("d_aligned",) and measured.sizes["d_aligned"] == 64
    assert np.isinf(measured["d_high"][-1]) and np.isfinite(measured["d"][-1])
    made = json.loads(measured.attrs["provenance"])
    assert {"viscache", "numpy", "isa", "date"} <= set(made)
    assert measured.attrs["scene_hash"] and measured.attrs["directions"] == "centres"
    assert measured.attrs["points"] == "camera" and measured.attrs["camera"]


def test_all_pairs_are_in_the_table(measured):
    pairs = int(measured["n"].sum() + measured["n_undefined"].sum())
    assert pairs == 400 * 399 // 2 == measured.attrs["n_pairs"]
    near = int(measured["near_n"].sum() + measured["near_n_undefined"].sum())
    p = measured["position"].values.astype(float)
    d = np.linalg.norm(p[:, None] - p, axis=2)[np.triu_indices(400, 1)]
    assert near == (d < 0.2).sum()


def test_the_mean_of_squares_is_that_of_mean_and_sigma(measured):
    expected = 1 - measured["mean"] ** 2 - measured["sigma"] ** 2
    assert np.allclose(measured["variance_ratio"], expected, atol=1e-9, equal_nan=True)


def test_the_jackknife_s_error_is_larger_than_the_naive_one():
    problem = bumpy(900, seed=1)
    ds = correlate(
        problem.bits,
        problem.positions,
        problem.normals,
        n_directions=500,
        d_edges=[0, 1, 2, 3],
        theta_edges_deg=6,
    )
    many = ds["n"].values > 5000
    assert many.sum() > 5
    assert np.median((ds["se"] / ds["se_naive"]).values[many]) > 2


def test_a_file_gives_back_the_dataset(measured, tmp_path):
    save_dataset(measured, tmp_path / "a.nc")
    assert [p.name for p in tmp_path.iterdir()] == ["a.nc"]
    xarray.testing.assert_identical(load_dataset(tmp_path / "a.nc"), measured)


def test_files_that_are_none_of_ours_are_refused(tmp_path):
    with pytest.raises(ValueError, match="no such file"):
        load_dataset(tmp_path / "none.nc")
    xarray.Dataset({"a": 1}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(ValueError, match="must be a NetCDF file of corr"):
        load_dataset(tmp_path / "other.nc")


def test_correlation_lengths_lie_where_the_mean_crosses_the_level():
    ds = made_up([[1.0, 0.8, 1.0, 0.9], [0.8, 0.6, 1.0, 0.7], [0.4, 0.4, 1.0, 0.6]])
    lengths = correlation_lengths(ds)
    assert lengths[0].tolist() == pytest.approx([1.0, 0.0, np.inf, 0.0])
    assert lengths[1].tolist() == pytest.approx([2.25, 2.0, np.inf, np.inf])
    few = made_up([[1.0, 1.0], [0.0, 0.0], [0.5, 0.5]], [[1000, 9], [99, 9], [1000, 9]])
    found = correlation_lengths(few, (0.75,))
    assert found[0, 0] == pytest.approx(1.5) and np.isnan(found[0, 1])


def test_the_predicted_ratio_is_the_mean_of_one_minus_rho_squared_around_a_record():
    # Evenly spread points have equally many pairs per area
    n = [[1000], [3000], [5000]]
    ds = made_up([[0.9], [0.6], [0.0]], n)
    left = 1 - np.array([0.9, 0.6, 0.0]) ** 2 - 0.01
    root = np.sqrt(np.pi)
    found = predicted_variance_ratio(ds, [0.1 * root, root, 2 * root, 3 * root, 3.1 * root])
    assert found[:2] == pytest.approx(left[0])
    assert found[2] == pytest.approx((left[0] + 3 * left[1]) / 4)
    assert found[3] == pytest.approx((left[0] + 3 * left[1] + 5 * left[2]) / 9)
    assert np.isnan(found[4])
    half = ds.assign(pair_share=("d", [1.0, 0.5, 0.5]))  # sampled bins stand for all of their pairs
    assert predicted_variance_ratio(half, 2 * root)[0] == pytest.approx((left[0] + 6 * left[1]) / 7)
    with pytest.raises(ValueError, match="spacing must be > 0"):
        predicted_variance_ratio(ds, 0.0)
    with pytest.raises(ValueError, match="theta_max_deg must reach"):
        predicted_variance_ratio(ds, 1.0, 5.0)


def test_points_of_a_plane_predict_no_variance_left():
    p = np.random.default_rng(0).random((300, 3)).astype(np.float32) * [1, 1, 0]
    up = np.tile([0, 0, 1.0], (300, 1))
    bits = np.zeros((300, 8), np.uint64)
    bits[:, :4] = ~np.uint64(0)
    ds = correlate(bits, p, up, d_edges=20, theta_edges_deg=18)
    assert predicted_variance_ratio(ds, [0.1, 0.5, 1.0]) == pytest.approx([0, 0, 0], abs=1e-6)
    assert ds["predicted_variance_ratio"].values[-1] == pytest.approx(0, abs=1e-6)
    assert np.isinf(ds["correlation_length"].values[:, 0]).all()


def test_the_box_is_the_largest_whose_pairs_have_a_mean_of_at_least_the_level():
    ds = made_up([[1.0, 0.9, 0.0], [0.9, 0.7, 0.0], [0.5, 0.2, 0.0]])
    box = high_correlation_box(ds)
    assert (box.d_max, box.theta_max_deg) == (2.0, 20.0)
    assert box.mean == pytest.approx((1.0 + 0.9 + 0.9 + 0.7) / 4)
    # Many pairs of low ρ in one bin push the box off it
    heavy = made_up(
        [[1.0, 0.9, 0.0], [0.9, 0.7, 0.0], [0.5, 0.2, 0.0]],
        [[1000, 1000, 1000], [1000, 9000, 1000], [1000, 1000, 1000]],
    )
    assert high_correlation_box(heavy).mean >= 0.8
    assert (high_correlation_box(heavy).d_max, high_correlation_box(heavy).theta_max_deg) != (2, 20)
    # Empty bins have no area
    empty = made_up([[1.0, 0.9, 0.0], [0.9, 0.7, 0.0]], [[1000, 0, 0], [1000, 0, 0]])
    assert high_correlation_box(empty).theta_max_deg == 10.0
    low = high_correlation_box(made_up([[0.5, 0.4], [0.3, 0.2]]))
    assert (low.d_max, low.theta_max_deg, low.mean) == (1.0, 10.0, 0.5)
