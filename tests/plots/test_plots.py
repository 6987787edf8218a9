"""Figures of sweeps: what is drawn, its labels, and its files for papers."""

import io
import re
import zlib

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from viscache import plots
from viscache.plots import labels
from viscache.plots.drawing import new_figure
from viscache.sweeps import designs
from viscache.sweeps.designs import Range
from viscache.sweeps.sweep import sweep
from viscache.sweeps.swept import looks_of

pytestmark = pytest.mark.usefixtures("fake_vc")


def test_the_front_joins_what_nothing_beats():
    points = [(1.0, 5.0), (2.0, 3.0), (2.5, 4.0), (3.0, 1.0), (4.0, 1.0)]
    assert plots.pareto(points) == [(1.0, 5.0), (2.0, 3.0), (3.0, 1.0)]


def test_a_notebook_shows_a_plot_without_pyplot():
    """IPython asks for `_repr_png_`; a plain Figure has none and shows as text."""
    figure = new_figure(2.0, 1.0)
    assert figure._repr_png_().startswith(b"\x89PNG")
    with Image.open(io.BytesIO(figure._repr_png_())) as shown:
        assert shown.size == (200, 100)
    assert not hasattr(Figure(), "_repr_png_")


def test_plots_are_labelled_and_leave_pyplot_alone():
    import matplotlib.pyplot as plt

    ds = sweep(
        "room",
        "whitted",
        over={"c_e": [4, 8, 16], "c_n": [4, 8]},
        repeats=2,
        size=(32, 24),
        metrics=["rel_l1"],
    )
    figure = plots.trade(ds, x="rays")
    axes = figure.axes[0]
    assert axes.get_xlabel() == "shadow rays" and "INF" in axes.get_ylabel()
    assert axes.get_xscale() == "log" and len(axes.containers) == 6
    legend = [t.get_text() for t in axes.get_legend().get_texts()]
    assert legend[0] == "$C_E$ = 4" and legend[5:] == ["Pareto front", "exact visibility"]
    map_axes = plots.heatmap(ds, value="speedup").axes[0]
    assert map_axes.get_xlabel() == "$C_E$ [px]" and len(map_axes.texts) == 6
    assert plt.get_fignums() == []
    with pytest.raises(ValueError, match="no variable 'rel_l2'; did you mean 'rel_l1'"):
        plots.trade(ds, y="rel_l2")
    with pytest.raises(ValueError, match="two of the swept dims"):
        plots.heatmap(ds, x="c_q")


def test_pairs_show_every_two_parameters_of_a_design(tmp_path):
    import matplotlib.pyplot as plt

    over = {
        "c_e": Range(2, 32, "log"),
        "c_n": Range(2, 16, whole=True),
        "preset": ["a", "b"],
        "integrator.n_vpls": [1, 2, 3],
    }
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
    figure.savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 2000
    assert plt.get_fignums() == []
    with pytest.raises(ValueError, match=r"two swept parameters of numbers, got \['c_e'\]"):
        plots.pairs(
            sweep("room", "whitted", over={"c_e": [4, 8]}, size=(32, 24), metrics=["rel_l1"])
        )


def grid():
    return sweep(
        "room",
        "whitted",
        over={"c_e": [4, 8, 16], "c_n": [4, 8]},
        size=(32, 24),
        metrics=["rel_l1"],
    )


def pdf_text(file):
    """The strings that a PDF shows, of one byte or two a letter, without spaces."""
    streams = re.findall(rb"stream\r?\n(.*?)endstream", file.read_bytes(), re.S)
    shown = []
    for stream in streams:
        try:
            plain = zlib.decompress(stream)
        except zlib.error:
            continue
        shown += re.findall(rb"\(((?:[^()\\\\]|\\\\.)*)\)", plain)
    return b"".join(shown).decode("latin-1").replace("\0", "").replace(" ", "")


@pytest.mark.slow
def test_every_figure_is_saved_in_three_formats_with_its_labels(tmp_path):
    files = plots.save_all(grid(), tmp_path / "figures")
    names = ["trade-total_s", "trade-rays", "heatmap-rel_l1", "heatmap-rays"]
    assert [f.name for f in files] == [f"{n}.{k}" for n in names for k in ("svg", "png", "pdf")]
    trade, heat = (tmp_path / "figures" / n for n in ("trade-rays", "heatmap-rays"))
    svg = trade.with_suffix(".svg").read_text("utf-8")
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", svg)
    assert {"shadow rays", "Pareto front", "exact visibility"} <= set(texts)
    assert "INF" in re.sub(r"<!--.*?-->|<[^>]*>|\s", "", svg)  # each letter in its own place
    assert "shadowrays" in pdf_text(trade.with_suffix(".pdf"))
    assert "[px]" in pdf_text(heat.with_suffix(".pdf"))
    assert b"/FontFile2" in heat.with_suffix(".pdf").read_bytes()  # TrueType, not Type 3
    with Image.open(heat.with_suffix(".png")) as image:
        assert image.info["dpi"][0] == pytest.approx(300, abs=1) and min(image.size) > 500


@pytest.mark.slow
def test_the_same_figure_gives_the_same_bytes(tmp_path):
    ds = grid()
    for folder in ("a", "b"):
        plots.save(plots.heatmap(ds, value="rays"), tmp_path / folder / "heat")
    for kind in plots.FORMATS:
        one, other = ((tmp_path / f / f"heat.{kind}").read_bytes() for f in ("a", "b"))
        assert one == other
    with pytest.raises(ValueError, match=r"formats must be of .* got 'bmp'"):
        plots.save(plots.heatmap(ds), tmp_path / "x", ["pdf", "bmp"])
    assert not list(tmp_path.glob("x*"))


@pytest.mark.slow
def test_designs_are_saved_as_pairs_and_grids_of_three_as_both(tmp_path):
    points = designs.latin_hypercube({"c_e": Range(2, 32, "log"), "c_n": Range(2, 16)}, 5)
    random = sweep("room", "whitted", over=points, size=(16, 12), metrics=["rel_l1"])
    over = {"c_e": [4, 8], "c_n": [4, 8], "integrator.n_vpls": [1, 2]}
    three = sweep("room", "whitted", over=over, size=(16, 12), metrics=["rel_l1"])
    kinds = [
        {f.name.split("-")[0] for f in plots.save_all(ds, tmp_path, "svg")}
        for ds in (random, three)
    ]
    assert kinds == [{"trade", "pairs"}, {"trade", "heatmap", "pairs"}]


def test_the_front_and_the_levels_are_drawn():
    ds = grid()
    axes = plots.trade(ds, x="rays").axes[0]
    front = next(line for line in axes.get_lines() if line.get_label() == "Pareto front")
    rays = sorted({float(v) for v in ds.rays.values.ravel()})
    np.testing.assert_allclose(front.get_xdata(), rays)
    np.testing.assert_allclose(front.get_ydata(), [0.16, 0.08, 0.04], rtol=1e-5)
    assert sorted(t.get_text() for t in axes.texts) == ["16", "4", "8"]


def test_colour_is_never_all_that_tells_levels_apart():
    one = looks_of([[1, 2, 3]])
    assert [one([v]) for v in (1, 2, 3)] == [(plots.COLORS[i], i) for i in range(3)]
    two = looks_of([[1, 2], ["a", "b", "c"]])
    assert two([2, "c"]) == (plots.COLORS[1], 2)
    many = looks_of([list(range(20))])
    assert len({many([i])[0] for i in range(20)}) == 20 and many([19])[1] == 0


@pytest.mark.parametrize(
    ("name", "plain", "math", "markup"),
    [
        ("c_e", "C_E [px]", "$C_E$ [px]", "<i>C</i><sub>E</sub> [px]"),
        ("c_msr", "C_MSR", r"$C_{\mathrm{MSR}}$", "<i>C</i><sub>MSR</sub>"),
        (
            "theta_max_deg",
            "θ_max [°]",
            r"$\theta_{\mathrm{max}}$ [°]",
            "<i>θ</i><sub>max</sub> [°]",
        ),
        ("integrator.n_vpls", "VPLs", "VPLs", "VPLs"),
        ("rays.n_directions", "directions l", "directions $l$", "directions <i>l</i>"),
        (
            "converged_rmse",
            "total RMSE [radiance]",
            "total RMSE [radiance]",
            "total RMSE [radiance]",
        ),
        ("a_<b>", "a <b>", "a <b>", "a &lt;b&gt;"),
    ],
)
def test_labels_are_symbols_with_units(name, plain, math, markup):
    assert (labels.plain(name), labels.mathtext(name)) == (plain, math)
    assert labels.as_html(name) == markup
    assert re.sub("<[^>]*>|\u200b", "", labels.as_svg(name)) == re.sub("<[^>]*>", "", markup)


def test_every_label_is_mathtext_that_can_be_drawn():
    from matplotlib.mathtext import MathTextParser

    parser = MathTextParser("agg")
    for name in labels.LABELS:
        parser.parse(labels.mathtext(name))
        assert "$" not in labels.plain(name) and "\\" not in labels.plain(name)
