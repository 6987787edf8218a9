"""The report's file: self-contained, complete, safe. (tests/browser drives it.)"""

import re

import numpy as np
import pytest

from reference import report_pictures as pictures
from viscache import report
from viscache.plots.labels import number
from viscache.report.svg import Axis
from viscache.sweeps import designs
from viscache.sweeps.designs import Range
from viscache.sweeps.sweep import sweep

pytestmark = pytest.mark.usefixtures("fake_vc", "without_netcdf")


def page(directory, target, scene="room"):
    ds = sweep(
        scene,
        "whitted",
        over={"c_e": [4, 8, 16], "c_n": [4, 8]},
        repeats=2,
        size=(48, 32),
        metrics=["rel_l1", "rmse"],
        directory=directory,
    )
    return report.write(ds, target).read_text("utf-8")


def test_the_file_asks_the_network_for_nothing(tmp_path):
    text = page(tmp_path / "s", tmp_path / "r.html")
    assert "default-src 'none'" in text
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:|#)""", text)
    assert not re.search(r"https?://|@import|url\((?!#)|fetch\(|XMLHttpRequest", text)


def test_every_setting_is_a_point_in_each_plot_a_row_and_a_picture(tmp_path):
    text = page(tmp_path / "s", tmp_path / "r.html")
    assert len(re.findall(r'<path class="point"', text)) == 2 * 6
    assert len(re.findall(r'<tr data-id="s\d"', text)) == 6
    data = pictures.model(text)
    assert len(data["settings"]) == 6 and len(data["pictures"]) == 1
    for setting in data["settings"]:
        assert pictures.picture(data, setting).shape == (32, 48, 3)
    cell = data["settings"][5]["cells"]
    assert data["settings"][5]["values"] == {"c_e": 16, "c_n": 8}
    assert cell["rel_l1"][0] == pytest.approx(0.16, rel=1e-5)


def series(text):
    """(fill, outline) of the points of the first plot, and the texts of the key's rows."""
    plot = text.split("</svg>")[0].rpartition("<svg")[2]
    points = re.findall(r'class="point"[^>]* d="([^"]*)"[^>]* fill="([^"]*)"', plot)
    rows = re.findall(r'<p class="key">(.*?)</p>', text)
    words = [re.findall(r"</svg>(.*?)</span>", row) for row in rows]
    return [(fill, d) for d, fill in points], words


def test_the_second_swept_parameter_is_a_shape_with_a_key_of_its_own(tmp_path):
    points, key = series(page(tmp_path / "s", tmp_path / "r.html"))
    assert len(points) == len(set(points)) == 6
    assert len({fill for fill, _ in points}) == 3 and len({shape for _, shape in points}) == 2
    first, second = (
        [f"<i>C</i><sub>{n}</sub> = {v}" for v in values]
        for n, values in (("E", (4, 8, 16)), ("N", (4, 8)))
    )
    assert key == [first, second, ["Pareto front: nothing is better in both"]]


def test_a_sweep_without_a_directory_has_a_report_without_pictures(tmp_path):
    text = page(None, tmp_path / "r.html")
    assert len(re.findall(r'<path class="point"', text)) == 12
    data = pictures.model(text)
    assert data["pictures"] == {} and not any("difference" in s for s in data["settings"])


def test_names_from_outside_cannot_break_out_of_the_page(tmp_path):
    evil = "room?<!--<script></script><script>alert(1)</script>"
    text = page(tmp_path / "s", tmp_path / "r.html", scene=evil)
    assert "<script>alert" not in text and "<!--" not in text


def test_a_directory_without_a_sweep_is_refused(tmp_path):
    with pytest.raises(ValueError, match="holds no sweep"):
        report.write(tmp_path)


def cells(text, plot):
    """(id of the setting, number written) of a heat map's cells, column by column from below."""
    svg = re.search(rf'<svg id="{plot}".*?</svg>', text, re.S)[0]
    found = re.findall(r'<g class="cell"( data-id="s\d+")?[^>]*><rect.*?>([^<]*)</text></g>', svg)
    return [(which.strip().removeprefix("data-id=").strip('"'), shown) for which, shown in found]


def test_a_grid_has_heat_maps_whose_cells_are_the_settings(tmp_path):
    text = page(None, tmp_path / "r.html")
    error = cells(text, "heatmap-rel_l1")
    assert [which for which, _ in error] == [f"s{i}" for i in range(6)]
    assert [shown for _, shown in error] == ["0.04", "0.04", "0.08", "0.08", "0.16", "0.16"]
    assert len(cells(text, "heatmap-rays")) == 6 and "pairs-rel_l1" not in text
    assert "<tspan" in text and "[px]" in text  # C_E with its index and unit


def test_three_parameters_have_pair_plots_and_heat_maps_of_means(tmp_path):
    over = {"c_e": [4, 8], "c_n": [4, 8, 16], "integrator.n_vpls": [10, 30]}
    ds = sweep("room", "whitted", over=over, size=(16, 12), metrics=["rel_l1"])
    text = report.write(ds, tmp_path / "r.html").read_text("utf-8")
    rays = cells(text, "heatmap-rays")
    assert [which for which, _ in rays] == [""] * 6  # means over VPLs belong to no one setting
    assert rays[0][1] == "240"  # (10 + 30) / 2 · 16 · 12 / 4²
    assert "Means over 1 more parameter." in text
    svg = re.search(r'<svg id="pairs-rel_l1".*?</svg>', text, re.S)[0]
    dots = re.findall(r'<circle class="dot" data-id="(s\d+)" cx="([\d.]+)" cy="([\d.]+)"', svg)
    assert len(dots) == 6 * 12  # three pairs and the diagonal
    assert len({x for _, x, _ in dots[:12]}) == 2 and len({y for *_, y in dots[12:24]}) == 3
    assert "VPLs" in svg and "[px]" in svg


def test_a_random_design_has_pair_plots_and_short_words(tmp_path):
    points = designs.latin_hypercube({"c_e": Range(2, 32, "log"), "c_n": Range(2, 64)}, 14)
    ds = sweep("room", "whitted", over=points, size=(16, 12), metrics=["rel_l1"])
    text = report.write(ds, tmp_path / "r.html").read_text("utf-8")
    assert "heatmap" not in text and 'id="pairs-rel_l1"' in text
    ordered = sorted(p["c_e"] for p in points)
    ends = f"{ordered[0]:.5g} to {ordered[-1]:.5g}"
    assert f"C_E: 14 values from {ends}" in text
    _, key = series(text)
    assert len(key[0]) == 2 and key[0][0].endswith(f"= {ordered[0]:.5g} …")


def test_axes_have_round_ticks_inside_their_range():
    wide = Axis([0.001, 2.0], 0, 100)
    assert wide.log and 0.01 in wide.ticks() and wide(0.001) < wide(0.01) < wide(2.0)
    narrow = Axis([10.0, 12.0], 0, 100)
    assert not narrow.log and set(narrow.ticks()) >= {10.0, 11.0, 12.0}
    assert all(0 <= narrow(t) <= 100 for t in narrow.ticks())
    assert Axis([5.0], 0, 1)(5.0) == pytest.approx(0.5)
    assert [number(v) for v in (0.02, 15000, 2e6, 3.5)] == ["0.02", "15k", "2M", "3.5"]


def test_a_dark_room_around_a_bright_window_is_shown_brighter_within_a_limit():
    from viscache.base import tonemap

    image = np.full((20, 20, 3), 0.02, np.float32)
    image[:2] = 1.0
    assert tonemap.auto_exposure(image) == pytest.approx(1)
    assert tonemap.display_exposure(image) == pytest.approx(5)  # the median becomes 0.1
    image[2:] = 1e-4
    assert tonemap.display_exposure(image) == pytest.approx(8)
    image[2:] = 0.5
    assert tonemap.display_exposure(image) == pytest.approx(1)
    assert tonemap.display_exposure(np.zeros((2, 2, 3), np.float32)) == 1
    shown = tonemap.difference8(image + np.float32(1 / 64), image)
    np.testing.assert_array_equal(shown, np.uint8(128 + round(127 * 16 / 64)))
