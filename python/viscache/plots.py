"""Figures of a sweep. Every function returns a matplotlib Figure and leaves pyplot alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscache.metrics import confidence_interval
from viscache.settings import nearest

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

#: Okabe and Ito's colours, told apart by colour-blind readers too.
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#f0e442")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")

#: Name → (symbol or words, unit).
LABELS: dict[str, tuple[str, str]] = {
    "c_e": ("$C_E$", "px"),
    "c_n": ("$C_N$", ""),
    "c_z": ("$C_Z$", ""),
    "c_r": ("$C_R$", ""),
    "c_msr": ("$C_{MSR}$", ""),
    "c_w": ("$C_W$", ""),
    "n_vpls": ("VPLs", ""),
    "n_tiles": ("tiles $n$", ""),
    "n_directions": ("directions $l$", ""),
    "rel_l1": (r"relative error $\hat L_{\mathrm{INF}}$", ""),
    "converged_rel_l1": (r"total relative error $\hat L_{\mathrm{INF}}$", ""),
    "rmse": ("RMSE", "radiance"),
    "rel_mse": ("relative MSE", ""),
    "energy": ("energy error", ""),
    "flip": ("mean HDR-FLIP", ""),
    "ssim": ("SSIM", ""),
    "max_abs": ("largest error", "radiance"),
    "total_s": ("time per frame", "s"),
    "visibility_s": ("visibility time", "s"),
    "cpu_s": ("CPU time", "s"),
    "rays": ("shadow rays", ""),
    "queries": ("visibility queries", ""),
    "ray_reduction": ("queries per ray", ""),
    "speedup": ("speed-up over exact", "×"),
    "cpu_speedup": ("CPU speed-up over exact", "×"),
}


def label(name: str) -> str:
    """A variable's axis label: symbol or words, unit in brackets."""
    words, unit = LABELS.get(name, (name.replace("_", " "), ""))
    return f"{words} [{unit}]" if unit else words


def trade(ds: xarray.Dataset, x: str = "total_s", y: str = "rel_l1") -> Figure:
    """Error against cost: a point per setting, the best ones joined.

    Parameters
    ----------
    ds : Dataset of `viscache.sweep`
    x, y : str
        Variables of the dataset. An axis is logarithmic where its values are positive
        and span more than a factor of 3.

    Returns
    -------
    Figure
        Means over repeats with 95 % intervals. The first swept parameter sets the colour, the
        second the marker. The line joins the settings that nothing beats in both.
    """
    _require(ds, x, y)
    from matplotlib.figure import Figure

    settings = settings_of(ds, x, y)
    names = list(settings[0]["values"]) if settings else []
    levels = [list(dict.fromkeys(str(s["values"][n]) for s in settings)) for n in names[:2]]
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.add_subplot()
    colors = colors_for(len(levels[0]) if levels else 1)
    for setting in settings:
        texts = [str(setting["values"][n]) for n in names[:2]]
        color = colors[levels[0].index(texts[0])] if texts else COLORS[0]
        marker = MARKERS[levels[1].index(texts[1]) % len(MARKERS)] if len(texts) > 1 else "o"
        (px, ex), (py, ey) = setting[x], setting[y]
        errors: dict[str, Any] = {"xerr": ex or None, "yerr": ey or None}
        axes.errorbar(px, py, **errors, fmt=marker, color=color, ms=6, lw=1, capsize=2, zorder=3)
    front = pareto([(s[x][0], s[y][0]) for s in settings])
    axes.plot([p[0] for p in front], [p[1] for p in front], color="0.6", lw=1, zorder=1)
    for axis, name in ((axes.xaxis, x), (axes.yaxis, y)):
        axis.set_label_text(label(name))
        if _spans([s[name][0] for s in settings]):
            _logarithmic(axes, axis)
    _legend(axes, names, levels, colors)
    axes.grid(True, which="major", color="0.9")
    axes.set_axisbelow(True)
    return figure


def heatmap(
    ds: xarray.Dataset, x: str | None = None, y: str | None = None, value: str = "rel_l1"
) -> Figure:
    """One variable over two swept parameters, its mean over all other dims written in each cell."""
    from matplotlib.figure import Figure

    swept = [str(d) for d in ds.dims if d not in ("repeat", "group", "point")]
    x, y = x or (swept[0] if swept else None), y or (swept[1] if len(swept) > 1 else None)
    if x not in swept or y not in swept or x == y:
        raise ValueError(f"x and y must be two of the swept dims {swept}, got {x!r} and {y!r}")
    _require(ds, value)
    array = ds[value].mean([d for d in ds[value].dims if d not in (x, y)]).transpose(y, x)
    cells = np.asarray(array.values, dtype=np.float64)
    figure = Figure(figsize=(1.6 + 0.9 * cells.shape[1], 1.4 + 0.6 * cells.shape[0]),
                    layout="constrained")  # fmt: skip
    axes = figure.add_subplot()
    image = axes.imshow(cells, cmap="cividis", aspect="auto", origin="lower")
    figure.colorbar(image, label=label(value))
    middle = np.nanmean([np.nanmin(cells), np.nanmax(cells)]) if np.isfinite(cells).any() else 0
    for (row, column), cell in np.ndenumerate(cells):
        color = "white" if cell < middle else "black"
        axes.text(column, row, f"{cell:.3g}", ha="center", va="center", color=color, fontsize=9)
    axes.set(xlabel=label(x), ylabel=label(y))
    axes.set_xticks(range(cells.shape[1]), [f"{v}" for v in ds[x].values])
    axes.set_yticks(range(cells.shape[0]), [f"{v}" for v in ds[y].values])
    return figure


def pairs(ds: xarray.Dataset, value: str = "rel_l1") -> Figure:
    """One variable over every pair of many swept parameters, as after a random design.

    Parameters
    ----------
    ds : Dataset of `viscache.sweep`
        Two or more swept parameters of numbers; others are left out.
    value : str
        Variable of the dataset.

    Returns
    -------
    Figure
        Below the diagonal a point per setting, coloured by its mean over repeats; on the diagonal
        the value over one parameter. Axes and colours are logarithmic where values are positive
        and span more than a factor of 3.
    """
    _require(ds, value)
    from matplotlib.figure import Figure

    settings = settings_of(ds, value)
    names = [
        n
        for n in (settings[0]["values"] if settings else {})
        if all(isinstance(s["values"][n], (int, float)) for s in settings)
    ]
    if len(names) < 2:
        raise ValueError(f"pairs needs two swept parameters of numbers, got {names}")
    means = np.array([s[value][0] for s in settings])
    columns = {n: np.array([s["values"][n] for s in settings], dtype=float) for n in names}
    k = len(names)
    figure = Figure(figsize=(1.2 + 1.9 * k, 0.8 + 1.7 * k), layout="constrained")
    grid = figure.subplots(k, k, squeeze=False)
    norm = "log" if _spans(means) else "linear"
    shown: Any = None
    for (row, column), axes in np.ndenumerate(grid):
        if column > row:
            axes.set_axis_off()
            continue
        over = means if row == column else columns[names[row]]
        style: dict[str, Any] = {"c": means, "cmap": "cividis", "norm": norm, "s": 18}
        shown = axes.scatter(columns[names[column]], over, **style)
        for axis, values in ((axes.xaxis, columns[names[column]]), (axes.yaxis, over)):
            if _spans(values):
                _logarithmic(axes, axis)
        axes.tick_params(labelsize=7)
        if row == k - 1:
            axes.set_xlabel(label(names[column]))
        if column == 0:
            axes.set_ylabel(label(names[row]) if row else label(value))
    bar = figure.colorbar(shown, ax=grid[0, 1:].tolist(), label=label(value), location="top")
    if norm == "log":
        _ticks_1_2_5(bar.ax.xaxis)
    return figure


def settings_of(ds: xarray.Dataset, *variables: str) -> list[dict[str, Any]]:
    """Every setting with its means over repeats.

    Returns
    -------
    list of dict
        `{"index": (...), "values": {name: value}, variable: (mean, half of its 95 % interval)}`;
        settings without a finished repeat are left out; the half is 0 with one repeat.
    """
    dims = [str(d) for d in ds.dims if d not in ("repeat", "group")]
    names = [str(n) for n, c in ds.coords.items() if set(c.dims) <= set(dims) and c.dims]
    names = [n for n in names if n != "point"]
    result = []
    for index in np.ndindex(*(ds.sizes[d] for d in dims)):
        chosen = ds.isel(dict(zip(dims, index, strict=True)))
        setting: dict[str, Any] = {"index": index, "values": {n: chosen[n].item() for n in names}}
        for variable in variables:
            samples = [float(v) for v in chosen[variable].values.ravel() if np.isfinite(v)]
            if not samples:
                break
            low, high = confidence_interval(samples) if len(samples) > 1 else (0.0, 0.0)
            setting[variable] = (float(np.mean(samples)), (high - low) / 2)
        else:
            result.append(setting)
    return result


def colors_for(levels: int) -> tuple[str, ...]:
    """At least `levels` colours, all different: `COLORS`, or a scale where they do not suffice."""
    if levels <= len(COLORS):
        return COLORS
    import matplotlib

    scale = matplotlib.colormaps["viridis"](np.linspace(0, 0.95, levels))
    return tuple(matplotlib.colors.to_hex(c) for c in scale)


def pareto(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The points that no other beats in both coordinates (smaller is better), in order."""
    best: list[tuple[float, float]] = []
    for point in sorted(set(points)):
        if not best or point[1] < best[-1][1]:
            best.append(point)
    return best


def _require(ds: xarray.Dataset, *names: str) -> None:
    for name in names:
        if name not in ds.data_vars:
            known = [str(v) for v in ds.data_vars]
            raise ValueError(f"the dataset has no variable {name!r}{nearest(name, known)}")


def _spans(values: Any) -> bool:
    """Whether values are positive and span more than a factor of 3."""
    return len(values) > 0 and min(values) > 0 and max(values) > 3 * min(values)


def _logarithmic(axes: Any, axis: Any) -> None:
    """Makes an axis logarithmic."""
    axes.set_xscale("log") if axis is axes.xaxis else axes.set_yscale("log")
    _ticks_1_2_5(axis)


def _ticks_1_2_5(axis: Any) -> None:
    """Ticks of a logarithmic axis at 1, 2, 5, with numbers as people write them."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.4g}"))
    axis.set_minor_formatter(NullFormatter())


def _legend(axes: Any, names: list[str], levels: list[list[str]], colors: tuple[str, ...]) -> None:
    from matplotlib.lines import Line2D

    handles = []
    for i, (name, texts) in enumerate(zip(names, levels, strict=False)):
        for j, text in enumerate(texts):
            color = colors[j] if i == 0 else "0.4"
            marker = "o" if i == 0 else MARKERS[j % len(MARKERS)]
            what = LABELS.get(name, (name, ""))[0]
            style: dict[str, Any] = {
                "ls": "",
                "color": color,
                "marker": marker,
                "label": f"{what} = {text}",
            }
            handles.append(Line2D([], [], **style))
    if handles:
        axes.legend(handles=handles, fontsize=8, frameon=False, loc="upper left",
                    bbox_to_anchor=(1, 1))  # fmt: skip
