"""Error over cost, heat maps and pair plots of a sweep; writing them to files."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscache.plots import labels
from viscache.plots.drawing import new_figure
from viscache.settings.checks import require
from viscache.settings.spelling import nearest
from viscache.sweeps.swept import (
    MOST_MARKERS,
    MOST_NAMED,
    error_of,
    first_of_levels,
    is_grid,
    levels_of,
    looks_of,
    numbers_of,
    pareto,
    settings_of,
)

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

#: One marker per value of the second swept parameter.
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
#: What `save` writes: text stays text, and PDFs hold TrueType fonts, as publishers ask.
FORMATS = ("svg", "png", "pdf")
_SAVED: dict[Any, Any] = {"svg.fonttype": "none", "svg.hashsalt": "viscache", "pdf.fonttype": 42}
_NO_DATE: dict[str, dict[str, Any]] = {
    "svg": {"Date": None},
    "png": {},
    "pdf": {"CreationDate": None},
}


def label(name: str) -> str:
    """A variable's axis label: symbol or words, unit in brackets."""
    return labels.mathtext(name)


def trade(ds: xarray.Dataset, x: str = "total_s", y: str = "rel_l1") -> Figure:
    """Error against cost: a point per setting, and the Pareto front.

    Parameters
    ----------
    ds : Dataset of `viscache.sweep`
    x, y : str
        Variables of the dataset. An axis is logarithmic if its values are positive and span more
        than a factor of 3.

    Returns
    -------
    Figure
        Means over repeats with 95 % intervals. The first swept parameter sets the colour and the
        second one the marker; a single parameter sets both. With two parameters, the values of the
        first are written beside points. The line is the Pareto front: the settings that no other
        beats in both. Dashed: the exact frame's cost.
    """
    _require(ds, x, y)
    settings = settings_of(ds, x, y)
    names = list(settings[0]["values"]) if settings else []
    levels = levels_of(settings, names[:2])
    figure = new_figure(6.4, 4.2)
    axes = figure.add_subplot()
    looks = looks_of(levels)
    for setting in settings:
        color, marker = looks([setting["values"][n] for n in names[:2]])
        (px, ex), (py, ey) = setting[x], setting[y]
        errors: dict[str, Any] = {"xerr": ex or None, "yerr": ey or None}
        axes.errorbar(
            px, py, **errors, fmt=MARKERS[marker], color=color, ms=6, lw=1, capsize=2, zorder=3
        )
    front = pareto([(s[x][0], s[y][0]) for s in settings])
    axes.plot(
        [p[0] for p in front],
        [p[1] for p in front],
        color="0.5",
        lw=1,
        zorder=1,
        label="Pareto front",
    )
    if f"exact_{x}" in ds:
        axes.axvline(
            float(ds[f"exact_{x}"].mean()),
            color="0.5",
            lw=1,
            ls="--",
            zorder=1,
            label="exact visibility",
        )
    for axis, name in ((axes.xaxis, x), (axes.yaxis, y)):
        axis.set_label_text(label(name))
        if _spans([s[name][0] for s in settings]):
            _logarithmic(axes, axis)
    for setting in first_of_levels(settings, names, x):
        axes.annotate(
            labels.level(setting["values"][names[0]]),
            (setting[x][0], setting[y][0]),
            xytext=(5, 4),
            textcoords="offset points",
            fontsize=7,
        )
    _legend(axes, names, levels, looks)
    axes.grid(True, which="major", color="0.9")
    axes.set_axisbelow(True)
    return figure


def heatmap(
    ds: xarray.Dataset, x: str | None = None, y: str | None = None, value: str = "rel_l1"
) -> Figure:
    """One variable over two swept parameters.

    Parameters
    ----------
    ds : Dataset of `viscache.sweep`
        The sweep must be a grid.
    x, y : str, optional
        Two of the swept parameters; the first two by default.
    value : str
        Variable of the dataset.

    Returns
    -------
    Figure
        The colour and number of a cell are the mean over repeats and all other parameters. Colours
        are logarithmic if values are positive and span more than a factor of 3.
    """
    swept = [str(d) for d in ds.dims if d not in ("repeat", "group", "point")]
    x, y = x or (swept[0] if swept else None), y or (swept[1] if len(swept) > 1 else None)
    if x not in swept or y not in swept or x == y:
        raise ValueError(f"x and y must be two of the swept dims {swept}, got {x!r} and {y!r}")
    _require(ds, value)
    array = ds[value].mean([d for d in ds[value].dims if d not in (x, y)]).transpose(y, x)
    cells = np.asarray(array.values, dtype=np.float64)
    figure = new_figure(1.6 + 0.9 * cells.shape[1], 1.4 + 0.6 * cells.shape[0])
    axes = figure.add_subplot()
    norm = "log" if _spans(cells[np.isfinite(cells)]) else "linear"
    image: Any = axes.imshow(cells, cmap="cividis", norm=norm, aspect="auto", origin="lower")
    bar = figure.colorbar(image, label=label(value))
    if norm == "log":
        ticks_1_2_5(bar.ax.yaxis)
    for (row, column), cell in np.ndenumerate(cells):
        color = "white" if image.norm(cell) < 0.5 else "black"
        axes.text(
            column,
            row,
            labels.number(float(f"{cell:.3g}")),
            ha="center",
            va="center",
            color=color,
            fontsize=9,
        )
    axes.set(xlabel=label(x), ylabel=label(y))
    axes.set_xticks(range(cells.shape[1]), [labels.level(v) for v in ds[x].values.tolist()])
    axes.set_yticks(range(cells.shape[0]), [labels.level(v) for v in ds[y].values.tolist()])
    return figure


def pairs(ds: xarray.Dataset, value: str = "rel_l1") -> Figure:
    """One variable over every pair of many swept parameters, as after a random design.

    Parameters
    ----------
    ds : Dataset of `viscache.sweep`
        Two or more numeric swept parameters; others are omitted.
    value : str
        Variable of the dataset.

    Returns
    -------
    Figure
        Below the diagonal: a point per setting, with colour and size by its mean over repeats. On
        the diagonal: the value over one parameter. Axes and colours are logarithmic if values are
        positive and span more than a factor of 3.
    """
    _require(ds, value)
    settings = settings_of(ds, value)
    names = numbers_of(settings)
    if len(names) < 2:
        raise ValueError(f"pairs needs two swept parameters of numbers, got {names}")
    means = np.array([s[value][0] for s in settings])
    columns = {n: np.array([s["values"][n] for s in settings], dtype=float) for n in names}
    k = len(names)
    figure = new_figure(1.2 + 1.9 * k, 0.8 + 1.7 * k)
    grid = figure.subplots(k, k, squeeze=False)
    norm = "log" if _spans(means) else "linear"
    sizes = 10 + 24 * np.argsort(np.argsort(means)) / max(1, len(means) - 1)
    shown: Any = None
    for (row, column), axes in np.ndenumerate(grid):
        if column > row:
            axes.set_axis_off()
            continue
        over = means if row == column else columns[names[row]]
        style: dict[str, Any] = {"c": means, "cmap": "cividis", "norm": norm, "s": sizes}
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
        ticks_1_2_5(bar.ax.xaxis)
    return figure


def save(
    figure: Figure, path: str | os.PathLike[str], formats: Iterable[str] = FORMATS
) -> list[Path]:
    """Write a figure as files for a paper; the same figure gives the same bytes.

    Parameters
    ----------
    figure : Figure
    path : path
        Without suffix: each format adds its own. The folder is created if missing.
    formats : iterable of {"svg", "png", "pdf"}
        PNG has 300 pixels per inch.

    Returns
    -------
    list of Path
        The files written.
    """
    import matplotlib

    wanted = [formats] if isinstance(formats, str) else list(formats)
    for kind in wanted:
        require(kind in FORMATS, f"formats must be of {FORMATS}", kind)
    stem = Path(path)
    stem.parent.mkdir(parents=True, exist_ok=True)
    files = [stem.with_name(f"{stem.name}.{kind}") for kind in wanted]
    for file, kind in zip(files, wanted, strict=True):
        with matplotlib.rc_context(_SAVED):
            figure.savefig(file, dpi=300, metadata=_NO_DATE[kind])
    return files


def save_all(
    ds: xarray.Dataset,
    folder: str | os.PathLike[str],
    formats: Iterable[str] = FORMATS,
    *,
    error: str | None = None,
) -> list[Path]:
    """Write every figure that a sweep's parameters allow.

    Trade plots over time and rays; heat maps of error and rays for a grid of two parameters; pair
    plots for three numeric parameters, or for two of a random design.

    Parameters
    ----------
    ds : Dataset of `viscache.sweep`
    folder : path
        Receives `trade-total_s.pdf`, `heatmap-rel_l1.pdf`, `pairs-rel_l1.pdf` and so on.
    formats : iterable of {"svg", "png", "pdf"}
    error : str, optional
        A metric of the sweep; the first by default.

    Returns
    -------
    list of Path
        The files written.
    """
    error = error_of(ds, error)
    costs = [c for c in ("total_s", "rays") if c in ds and bool(ds[c].notnull().any())]
    figures = {f"trade-{cost}": trade(ds, cost, error) for cost in costs}
    if is_grid(ds):
        figures |= {f"heatmap-{v}": heatmap(ds, value=v) for v in (error, *costs[-1:])}
    settings = settings_of(ds, error)
    if len(numbers_of(settings)) >= (2 if "point" in ds.dims else 3):
        figures[f"pairs-{error}"] = pairs(ds, error)
    kinds = [formats] if isinstance(formats, str) else list(formats)
    written = (save(figure, Path(folder) / name, kinds) for name, figure in figures.items())
    return [file for files in written for file in files]


def _require(ds: xarray.Dataset, *names: str) -> None:
    for name in names:
        if name not in ds.data_vars:
            known = [str(v) for v in ds.data_vars]
            raise ValueError(f"the dataset has no variable {name!r}{nearest(name, known)}")


def _spans(values: Any) -> bool:
    """Whether values are positive and span more than a factor of 3."""
    return len(values) > 0 and min(values) > 0 and max(values) > 3 * min(values)


def _logarithmic(axes: Any, axis: Any) -> None:
    axes.set_xscale("log") if axis is axes.xaxis else axes.set_yscale("log")
    ticks_1_2_5(axis)


def ticks_1_2_5(axis: Any) -> None:
    """Ticks of a logarithmic axis: at 1, 2, 5; at every digit if short; at 1 only if long."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    digits: Sequence[float] = range(1, 10) if high < 6 * low else (1, 2, 5)
    axis.set_major_locator(LogLocator(subs=digits if high < 500 * low else (1,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: labels.number(value)))
    axis.set_minor_formatter(NullFormatter())


def _legend(
    axes: Any,
    names: Sequence[str],
    levels: Sequence[Sequence[Any]],
    looks: Callable[[Sequence[Any]], tuple[str, int]],
) -> None:
    """The levels of a parameter; only both ends if there are more than `MOST_NAMED`."""
    from matplotlib.lines import Line2D

    handles: list[Any] = []
    for i, (name, values) in enumerate(zip(names, levels, strict=False)):
        named = values if len(values) <= MOST_NAMED else [values[0], values[-1]]
        if i and len(values) > MOST_MARKERS:
            continue
        for j, value in enumerate(named):
            color, marker = looks([value if k == i else known[0] for k, known in enumerate(levels)])
            shape = MARKERS[marker if i or len(levels) == 1 else 0]
            style: dict[str, Any] = {"ls": "", "color": color if i == 0 else "0.4"}
            more = " …" if named is not values and j == 0 else ""
            words = f"{labels.mathtext(name, unit=False)} = {labels.level(value)}{more}"
            handles.append(Line2D([], [], **style, marker=shape, label=words))
    handles += [h for h in axes.get_lines() if not h.get_label().startswith("_")]
    axes.legend(handles=handles, fontsize=8, frameon=False, loc="upper left", bbox_to_anchor=(1, 1))
