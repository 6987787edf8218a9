"""Pictures of correlation statistics. Every function returns a matplotlib Figure."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from viscache.correlation.derived import ENOUGH_PAIRS
from viscache.plots import COLORS, save
from viscache.plots.drawing import new_figure

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_map", "draw_table", "local_image", "maps", "save_all", "slices", "table"]

#: From dark blue to yellow, distinguishable by colour-blind readers; clamped to [0, 1] as in the
#: paper.
COLORMAP = "cividis"
MEAN_LABEL = r"mean correlation $\bar\rho$"
D_LABEL = "distance $d$ [scene units]"
THETA_LABEL = r"angle between normals $\theta$ [°]"


def table(dataset: xarray.Dataset) -> Figure:
    """ρ̄ over d and θ, with the box of the spatial map; bins with n < 100 are white."""
    figure, axes = _figure(6.0, 4.6)
    image = draw_table(axes, dataset)
    figure.colorbar(image, label=MEAN_LABEL)
    return figure


def draw_table(axes: Axes, dataset: xarray.Dataset) -> Any:
    """Draw `table` into axes of another figure; returns the coloured mesh."""
    shown = dataset["mean"].where(dataset["n"] >= ENOUGH_PAIRS).values
    d = _edges(dataset, "d")
    theta = _edges(dataset, "theta")
    image = axes.pcolormesh(d, theta, shown.T, cmap=COLORMAP, vmin=0.0, vmax=1.0, rasterized=True)
    width = min(dataset.attrs["box_d_max"], d[-1])
    height = dataset.attrs["box_theta_max_deg"]
    axes.plot([0, width, width], [height, height, 0], color=COLORS[1], lw=1.2)
    axes.set(xlabel=D_LABEL, ylabel=THETA_LABEL, xlim=(0, d[-1]), ylim=(180, 0))
    axes.set_yticks(range(0, 181, 30))
    return image


def slices(dataset: xarray.Dataset) -> Figure:
    """ρ̄ of near pairs over θ and of aligned pairs over d, with ±σ dashed and ±2 SE shaded."""
    figure, both = _figure(9.0, 3.6, columns=2)
    parts = (
        ("near", "theta_near", THETA_LABEL, f"$d < {dataset.attrs['slice_d']:g}$"),
        ("aligned", "d_aligned", D_LABEL, rf"$\theta < {dataset.attrs['slice_theta_deg']:g}°$"),
    )
    for axes, (prefix, name, label, title) in zip(both, parts, strict=True):
        enough = dataset[f"{prefix}_n"].values >= ENOUGH_PAIRS
        x = dataset[name].values
        mean, sigma, se = (
            np.where(enough, dataset[f"{prefix}_{v}"].values, np.nan)
            for v in ("mean", "sigma", "se")
        )
        axes.plot(x, mean, color=COLORS[0], label=r"$\bar\rho$")
        for sign in (-1, 1):
            named = r"$\pm\sigma$ of the pairs" if sign > 0 else None
            axes.plot(x, mean + sign * sigma, "--", color=COLORS[1], lw=1, label=named)
        band: dict[str, Any] = {"color": COLORS[0], "alpha": 0.25, "lw": 0}
        axes.fill_between(x, mean - 2 * se, mean + 2 * se, label=r"$\pm 2$ SE of the mean", **band)
        if prefix == "near":
            axes.plot(
                [0, 180], [1, -1], ":", color="0.5", lw=1, label=r"no occluders: $1-2\theta/\pi$"
            )
            axes.set_xticks(range(0, 181, 30))
        axes.axhline(0.0, color="0.85", lw=0.8, zorder=0)
        axes.set(xlabel=label, ylabel=r"correlation $\rho$", title=title, ylim=(-1.05, 1.05))
        axes.set_xlim(0, _edges(dataset, name)[-1])
        axes.legend(frameon=False, fontsize=8)
    return figure


def maps(dataset: xarray.Dataset) -> Figure:
    """Mean ρ of every point with its neighbourhood, in the camera's view; without a camera from
    above.

    Raises
    ------
    ValueError
        The dataset is one of `correlate`, which has no places.
    """
    figure, axes = _figure(6.0, 4.4)
    shown = draw_map(axes, dataset)
    d, theta = dataset.attrs["box_d_max"], dataset.attrs["box_theta_max_deg"]
    label = rf"{MEAN_LABEL}" + "\n" + rf"within $d<{d:.3g}$, $\theta<{theta:.3g}°$"
    figure.colorbar(shown, label=label, shrink=0.8)
    return figure


def draw_map(axes: Axes, dataset: xarray.Dataset) -> Any:
    """Draw `maps` into axes of another figure; returns the mappable for a colour bar."""
    if "local_mean" not in dataset:
        raise ValueError("the dataset must have local means, as those of measure have")
    style: dict[str, Any] = {"cmap": COLORMAP, "vmin": 0.0, "vmax": 1.0}
    if dataset.attrs["points"] == "camera":
        axes.set_axis_off()
        return axes.imshow(local_image(dataset), interpolation="nearest", **style)
    p = dataset["position"].values
    first, second = np.sort(np.argsort(np.ptp(p, axis=0))[1:])
    names = "xyz"
    axes.set(xlabel=f"{names[first]} [scene units]", ylabel=f"{names[second]} [scene units]")
    axes.set_aspect("equal")
    value = dataset["local_mean"].values
    return axes.scatter(p[:, first], p[:, second], c=value, s=2, lw=0, rasterized=True, **style)


def local_image(dataset: xarray.Dataset) -> npt.NDArray[np.float32]:
    """(height, width) local means in the camera's image; NaN where there is no surface.

    A pixel without a point takes the median of its neighbours if most of them have a value.
    """
    height, width = dataset.attrs["height"], dataset.attrs["width"]
    image = np.full(height * width, np.nan, dtype=np.float32)
    image[dataset["stratum"].values] = dataset["local_mean"].values
    image = image.reshape(height, width)
    drawn = np.zeros(height * width, dtype=bool)
    drawn[dataset["stratum"].values] = True
    around = _neighbours(image)
    known = np.isfinite(around).sum(axis=0)
    fill = ~drawn.reshape(height, width) & (known >= 5)
    if fill.any():
        image[fill] = np.nanmedian(around[:, fill], axis=0)
    return image


def _neighbours(image: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """(8, height, width): the neighbours of each pixel; NaN beyond the border."""
    padded = np.pad(image, 1, constant_values=np.nan)
    h, w = image.shape
    around = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    return np.stack([padded[i : i + h, j : j + w] for i, j in around])


def save_all(
    dataset: xarray.Dataset, folder: str | os.PathLike[str], formats: Iterable[str] = ("png",)
) -> list[Path]:
    """Write `table`, `slices` and, if there are local means, `map`, each as PNG, SVG or PDF.

    Parameters
    ----------
    dataset : Dataset of `measure`
    folder : path
        Created if missing.
    formats : iterable of {"svg", "png", "pdf"}

    Returns
    -------
    list of Path
        The files written.
    """
    drawn = {"table": table(dataset), "slices": slices(dataset)}
    if "local_mean" in dataset:
        drawn["map"] = maps(dataset)
    kinds = list(formats)
    written = (save(figure, Path(folder) / name, kinds) for name, figure in drawn.items())
    return [file for files in written for file in files]


def _figure(width: float, height: float, columns: int = 1) -> tuple[Figure, Any]:
    figure = new_figure(width, height)
    return figure, figure.subplots(1, columns)


def _edges(dataset: xarray.Dataset, name: str) -> npt.NDArray[np.float64]:
    """Edges of a coordinate; a last bin that ends at inf is drawn symmetric around its centre."""
    low, high = dataset[f"{name}_low"].values, dataset[f"{name}_high"].values
    end = high[-1] if np.isfinite(high[-1]) else 2 * dataset[name].values[-1] - low[-1]
    return np.append(low, end)
