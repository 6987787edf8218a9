"""Figures 3 and 4 of the visibility-map paper: what their rows measure."""

import numpy as np
import pytest
import xarray

from viscache.correlation import correlate
from viscache.scenes.sources import SCENES_VARIABLE
from viscache_lab.figures import vismap_correlation as figure
from viscache_lab.figures.bands import vismap as bands


def slices(over_theta, over_d):
    """Both slices with 64 bins of 1000 pairs each; d ends at 8."""
    theta, d = (np.arange(64) + 0.5) * 180 / 64, (np.arange(64) + 0.5) / 8
    return xarray.Dataset(
        {
            "near_mean": ("theta_near", over_theta),
            "near_n": ("theta_near", np.full(64, 1000)),
            "aligned_mean": ("d_aligned", over_d),
            "aligned_n": ("d_aligned", np.full(64, 1000)),
        },
        {"theta_near": theta, "d_aligned": d, "d_aligned_high": ("d_aligned", d + 1 / 16)},
    )


def test_a_straight_fall_is_straight_and_a_bent_one_is_not():
    theta, d = (np.arange(64) + 0.5) / 64, (np.arange(64) + 0.5) / 64
    straight = slices(1 - 2 * theta, d)
    assert figure.straightness(straight) == pytest.approx(1)
    bent = figure.straightness(slices(np.exp(-20 * theta), d))
    assert bent is not None and bent not in bands.LINEAR_IN_THETA


def test_the_middle_of_a_line_has_half_of_the_fall_and_of_a_convex_curve_more():
    t = np.arange(64) / 63
    line = figure.fall_by_the_middle(slices(t, 1 - 0.7 * t))
    convex = figure.fall_by_the_middle(slices(t, np.exp(-4 * t)))
    concave = figure.fall_by_the_middle(slices(t, 1 - t**3))
    assert line == pytest.approx(0.53, abs=0.02) and line not in bands.CONVEX_IN_D
    assert convex in bands.CONVEX_IN_D and concave not in bands.CONVEX_IN_D
    few = slices(t, 1 - t).assign(aligned_n=("d_aligned", np.full(64, 5)))
    assert figure.fall_by_the_middle(few) is None


def test_lines_of_flat_faces_are_found_and_smooth_bodies_have_none():
    rng = np.random.default_rng(0)
    flat = np.eye(3, dtype=np.float32)[rng.integers(0, 3, 600)]
    round_ = rng.normal(size=(600, 3)).astype(np.float32)
    round_ /= np.linalg.norm(round_, axis=1, keepdims=True)
    mixed = np.where(rng.random((600, 1)) < 0.5, flat, round_)
    bits = rng.integers(0, 1 << 62, (600, 8), dtype=np.uint64)
    for normals, holds in ((mixed, True), (round_, False)):
        ds = correlate(bits, rng.random((600, 3)), normals, d_edges=4)
        assert [row.holds for row in figure._line_rows(ds)] == [holds, holds]


def test_scenes_that_are_absent_are_skipped_by_name(tmp_path, monkeypatch):
    monkeypatch.setenv(SCENES_VARIABLE, str(tmp_path))
    assert [view.find() for view in figure.OTHERS] == [None, None]
    (tmp_path / "living-room").mkdir()
    (tmp_path / "living-room" / "scene.xml").touch()
    assert figure.OTHERS[0].find() == str(tmp_path / "living-room" / "scene.xml")
    monkeypatch.delenv(SCENES_VARIABLE)
    assert figure.OTHERS[0].find() is None
    assert all(view.find() == view.scene for view in figure.PAPER)
