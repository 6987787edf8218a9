"""Pictures: empty bins stay white, the map is the camera's view, files are written."""

import numpy as np
import pytest

from viscache.correlation import measure, plots


@pytest.fixture(scope="module")
def measured():
    return measure("bumpy_spheres?triangles=3000", n_points=600, map_size=16, points="camera")


def test_bins_with_fewer_than_100_pairs_are_white(measured):
    figure = plots.table(measured)
    shown = figure.axes[0].collections[0].get_array()
    few = (measured["n"].values < 100).T
    assert (np.ma.getmaskarray(shown).reshape(few.shape) == few).all() and 0 < few.sum() < few.size
    means = measured["mean"].values.T
    np.testing.assert_array_equal(np.ma.getdata(shown).reshape(few.shape)[~few], means[~few])
    axes = figure.axes[0]
    assert axes.get_ylim() == (180, 0) and "scene units" in axes.get_xlabel()
    assert r"\theta" in axes.get_ylabel() and r"\rho" in figure.axes[1].get_ylabel()


def test_slices_show_mean_spread_and_error(measured):
    near, aligned = plots.slices(measured).axes
    mean, upper = near.lines[0].get_ydata(), near.lines[2].get_ydata()
    enough = measured["near_n"].values >= 100
    assert np.allclose(mean[enough], measured["near_mean"].values[enough])
    assert np.allclose((upper - mean)[enough], measured["near_sigma"].values[enough])
    assert np.isnan(mean[~enough]).all()
    assert near.lines[0].get_linestyle() == "-"
    for line in near.lines[1:3]:
        assert line.get_linestyle() == "--" and line.get_color() != near.lines[0].get_color()
    band = np.concatenate([path.vertices[:, 1] for path in near.collections[0].get_paths()])
    two = 2 * measured["near_se"].values
    assert band.min() == pytest.approx(np.nanmin((mean - two)[enough]))
    assert band.max() == pytest.approx(np.nanmax((mean + two)[enough]))
    assert [axes.get_xlabel()[0] for axes in (near, aligned)] == ["a", "d"]
    assert "0.2" in near.get_title() and "2°" in aligned.get_title()


def test_the_map_puts_every_point_in_its_pixel(measured):
    image = plots.local_image(measured)
    assert image.shape == (measured.attrs["height"], measured.attrs["width"])
    drawn = measured["stratum"].values
    assert np.array_equal(image.ravel()[drawn], measured["local_mean"].values, equal_nan=True)
    # A pixel left out between many others is filled, the sky is not
    hole = measured.isel(point=slice(1, None))
    row, column = divmod(int(measured["stratum"][0]), measured.attrs["width"])
    around = image[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2].ravel()
    filled = plots.local_image(hole)[row, column]
    known = np.isfinite(around).sum() - np.isfinite(image[row, column])
    assert np.isfinite(filled) == (known >= 5)


def test_all_pictures_are_written(measured, tmp_path):
    files = plots.save_all(measured, tmp_path / "new")
    assert [f.name for f in files] == ["table.png", "slices.png", "map.png"]
    assert all(f.read_bytes()[:4] == b"\x89PNG" for f in files)


def test_without_a_camera_the_map_is_seen_along_the_shortest_side():
    ds = measure("bumpy_spheres?triangles=3000", n_points=100, map_size=16, points="area")
    axes = plots.maps(ds).axes[0]
    assert {axes.get_xlabel()[0], axes.get_ylabel()[0]} == {"x", "z"}
    with pytest.raises(ValueError, match="must have local means"):
        plots.maps(ds.drop_vars("local_mean"))
