"""The report's file: self-contained, complete, safe. (tests/browser drives it.)"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reference import report_pictures as pictures
from viscache import designs, plots, report
from viscache.designs import Range
from viscache.report.svg import Axis, number
from viscache.sweep import sweep


def page(fake_vc: Any, directory: Path | None, target: Path, scene: str = "room") -> str:
    ds = sweep(scene, "whitted", over={"c_e": [4, 8, 16], "c_n": [4, 8]}, repeats=2,
               size=(48, 32), metrics=["rel_l1", "rmse"], directory=directory)  # fmt: skip
    return report.write(ds, target).read_text("utf-8")


def test_the_file_asks_the_network_for_nothing(fake_vc: Any, tmp_path: Path) -> None:
    text = page(fake_vc, tmp_path / "s", tmp_path / "r.html")
    assert "default-src 'none'" in text
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:|#)""", text)
    assert not re.search(r"https?://|@import|url\((?!#)|fetch\(|XMLHttpRequest", text)


def test_every_setting_is_a_point_in_each_plot_a_row_and_a_picture(
    fake_vc: Any, tmp_path: Path
) -> None:
    text = page(fake_vc, tmp_path / "s", tmp_path / "r.html")
    assert len(re.findall(r'<path class="point"', text)) == 2 * 6
    assert len(re.findall(r'<tr data-id="s\d"', text)) == 6
    data = pictures.model(text)
    assert len(data["settings"]) == 6 and len(data["pictures"]) == 1
    for setting in data["settings"]:
        assert pictures.picture(data, setting).shape == (32, 48, 3)
    cell = data["settings"][5]["cells"]
    assert data["settings"][5]["values"] == {"c_e": 16, "c_n": 8}
    assert cell["rel_l1"][0] == pytest.approx(0.16, rel=1e-5)


def series(text: str) -> tuple[list[tuple[str, str]], list[list[str]]]:
    """(fill, outline) of the points of the first plot, and the texts of the key's rows."""
    plot = text.split("</svg>")[0].rpartition("<svg")[2]
    points = re.findall(r'class="point"[^>]* d="([^"]*)"[^>]* fill="([^"]*)"', plot)
    rows = re.findall(r'<p class="key">(.*?)</p>', text)
    return [(fill, d) for d, fill in points], [re.findall(r"</svg>([^<]*)<", r) for r in rows]


def test_the_second_swept_parameter_is_a_shape_with_a_key_of_its_own(
    fake_vc: Any, tmp_path: Path
) -> None:
    points, key = series(page(fake_vc, tmp_path / "s", tmp_path / "r.html"))
    assert len(points) == len(set(points)) == 6
    assert len({fill for fill, _ in points}) == 3 and len({shape for _, shape in points}) == 2
    assert key == [["C_E = 4", "C_E = 8", "C_E = 16"], ["C_N = 4", "C_N = 8"]]


def test_many_levels_of_one_parameter_have_colours_of_their_own(
    fake_vc: Any, tmp_path: Path
) -> None:
    ds = sweep("room", "whitted", over={"c_e": list(range(4, 14))}, size=(16, 12),
               metrics=["rel_l1"])  # fmt: skip
    points, key = series(report.write(ds, tmp_path / "r.html").read_text("utf-8"))
    assert len({fill for fill, _ in points}) == 10 and len({shape for _, shape in points}) == 1
    assert [len(row) for row in key] == [10]


def test_a_sweep_without_a_directory_has_a_report_without_pictures(
    fake_vc: Any, tmp_path: Path
) -> None:
    text = page(fake_vc, None, tmp_path / "r.html")
    assert len(re.findall(r'<path class="point"', text)) == 12
    data = pictures.model(text)
    assert data["pictures"] == {} and not any("difference" in s for s in data["settings"])


def test_names_from_outside_cannot_break_out_of_the_page(fake_vc: Any, tmp_path: Path) -> None:
    evil = "room?</script><script>alert(1)</script>"
    text = page(fake_vc, tmp_path / "s", tmp_path / "r.html", scene=evil)
    assert "<script>alert" not in text


def test_a_directory_without_a_sweep_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="holds no sweep"):
        report.write(tmp_path)


def test_axes_have_round_ticks_inside_their_range() -> None:
    wide = Axis([0.001, 2.0], 0, 100)
    assert wide.log and 0.01 in wide.ticks() and wide(0.001) < wide(0.01) < wide(2.0)
    narrow = Axis([10.0, 12.0], 0, 100)
    assert not narrow.log and set(narrow.ticks()) >= {10.0, 11.0, 12.0}
    assert all(0 <= narrow(t) <= 100 for t in narrow.ticks())
    assert Axis([5.0], 0, 1)(5.0) == pytest.approx(0.5)
    assert [number(v) for v in (0.02, 15000, 2e6, 3.5)] == ["0.02", "15k", "2M", "3.5"]


def test_the_front_joins_what_nothing_beats() -> None:
    points = [(1.0, 5.0), (2.0, 3.0), (2.5, 4.0), (3.0, 1.0), (4.0, 1.0)]
    assert plots.pareto(points) == [(1.0, 5.0), (2.0, 3.0), (3.0, 1.0)]


def test_plots_are_labelled_and_leave_pyplot_alone(fake_vc: Any) -> None:
    import matplotlib.pyplot as plt

    ds = sweep("room", "whitted", over={"c_e": [4, 8, 16], "c_n": [4, 8]}, repeats=2, size=(32, 24),
               metrics=["rel_l1"])  # fmt: skip
    figure = plots.trade(ds, x="rays")
    axes = figure.axes[0]
    assert axes.get_xlabel() == "shadow rays" and "INF" in axes.get_ylabel()
    assert axes.get_xscale() == "log" and len(axes.containers) == 6
    legend = [t.get_text() for t in axes.get_legend().get_texts()]
    assert legend[0] == "$C_E$ = 4" and len(legend) == 5
    map_axes = plots.heatmap(ds, value="speedup").axes[0]
    assert map_axes.get_xlabel() == "$C_E$ [px]" and len(map_axes.texts) == 6
    assert plt.get_fignums() == []
    with pytest.raises(ValueError, match="no variable 'rel_l2'; did you mean 'rel_l1'"):
        plots.trade(ds, y="rel_l2")
    with pytest.raises(ValueError, match="two of the swept dims"):
        plots.heatmap(ds, x="c_q")


def test_pairs_show_every_two_parameters_of_a_design(fake_vc: Any, tmp_path: Path) -> None:
    import matplotlib.pyplot as plt

    over = {"c_e": Range(2, 32, "log"), "c_n": Range(2, 16, whole=True), "preset": ["a", "b"],
            "integrator.n_vpls": [1, 2, 3]}  # fmt: skip
    points = designs.latin_hypercube(over, 12)
    ds = sweep("room", "whitted", over=points, size=(32, 24), metrics=["rel_l1"])
    figure = plots.pairs(ds)
    shown = [a for a in figure.axes if a.axison and a.collections and a.get_label() == ""]
    assert len(shown) == 6  # three parameters are numbers: three pairs and the diagonal
    first, pair = shown[0], shown[1]
    np.testing.assert_allclose(first.collections[0].get_offsets()[:, 1], ds.rel_l1[:, 0])
    np.testing.assert_allclose(pair.collections[0].get_offsets(), np.stack([ds.c_e, ds.c_n], 1))
    np.testing.assert_allclose(pair.collections[0].get_array(), ds.rel_l1[:, 0])
    assert first.get_xscale() == "log" and "INF" in first.get_ylabel()
    assert shown[-1].get_xlabel() == "VPLs" and shown[3].get_xlabel() == "$C_E$ [px]"
    for kind in ("svg", "png", "pdf"):
        figure.savefig(tmp_path / f"a.{kind}")
        assert (tmp_path / f"a.{kind}").stat().st_size > 2000
    assert plt.get_fignums() == []
    with pytest.raises(ValueError, match=r"two swept parameters of numbers, got \['c_e'\]"):
        plots.pairs(sweep("room", "whitted", over={"c_e": [4, 8]}, size=(32, 24),
                          metrics=["rel_l1"]))  # fmt: skip


def test_a_dark_room_around_a_bright_window_is_shown_brighter_within_a_limit() -> None:
    from viscache import tonemap

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
