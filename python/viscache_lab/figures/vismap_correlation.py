"""Figures 3 and 4 of the visibility-map paper: correlation of visibility in four scenes.

The paper's scenes are a garden from two cameras, mushrooms, and moving boxes; ours are modelled to
the sizes it prints. Two scenes by other authors are added if their files exist.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscache.correlation import measure, plots, save_dataset
from viscache.correlation.derived import ENOUGH_PAIRS, pairs_of_bins
from viscache.plots.drawing import new_figure
from viscache.scenes.sources import SCENES_VARIABLE, is_builtin, made_by_others
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.figures.bands import vismap as bands

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, slots=True)
class View:
    """A scene from one of its cameras."""

    name: str
    scene: str
    camera: int = 0

    def find(self) -> str | None:
        """The scene for `measure`; None if its file is absent."""
        if is_builtin(self.scene):
            return self.scene
        path = made_by_others(self.scene)
        return None if path is None else str(path)


PAPER = (
    View("garden1", "garden", 0),
    View("garden2", "garden", 1),
    View("mushrooms", "mushrooms"),
    View("dynamics", "dynamics"),
)
OTHERS = (
    View("living-room", "living-room/scene.xml"),
    View("sanmiguel-part", "sanmiguel-part/scene.xml"),
)
#: Like the paper's 1.9·10¹⁰ estimates of 96×96 samples; and a quick version.
FULL: dict[str, Any] = {"n_points": 195_000, "map_size": 96}
QUICK: dict[str, Any] = {"n_points": 6_000, "map_size": 24, "d_edges": 64}


@FIGURES.add("vismap-fig3", "correlation over distance and angle in one scene, with slices")
def figure3(trial: Trial) -> None:
    """Table and both slices of scene (a)."""
    view = PAPER[0]
    dataset = _measured(view, trial.folder, trial.quick, trial.progress, trial)
    if dataset is None:
        return
    trial.rows += _common_rows(view.name, dataset, held=True)
    trial.rows += _slice_rows(view.name, dataset)
    trial.rows += _size_rows(view.name, dataset, trial.quick)
    for name, draw in (("table", plots.table), ("slices", plots.slices)):
        trial.save(draw(dataset), f"vismap-fig3-{name}.png", dpi=150)


@FIGURES.add("vismap-fig4", "correlation in four scenes, with maps of the scenes")
def figure4(trial: Trial) -> None:
    """Tables and spatial maps of the four scenes, and of two by other authors."""
    found: dict[str, xarray.Dataset] = {}
    for view in (*PAPER, *OTHERS):
        dataset = _measured(view, trial.folder, trial.quick, trial.progress, trial)
        if dataset is not None:
            found[view.name] = dataset
    for name, dataset in found.items():
        printed = name in [view.name for view in PAPER]
        trial.rows += _common_rows(name, dataset, held=printed)
        if printed:
            trial.rows += _size_rows(name, dataset, trial.quick)
    trial.rows += _line_rows(found["dynamics"])
    trial.rows += _order_rows(found)
    trial.save(_picture(found), "vismap-fig4.png", dpi=130)


def _measured(
    view: View, folder: Path, quick: bool, progress: bool, trial: Trial
) -> xarray.Dataset | None:
    """Statistics of a view; full runs can resume and store them beside the picture."""
    scene = view.find()
    if scene is None:
        trial.skip(view.name, f"{view.scene} is absent: set {SCENES_VARIABLE} to its folder")
        return None
    store = None if quick else folder / "blocks"
    dataset = measure(
        scene, camera=view.camera, directory=store, progress=progress, **(QUICK if quick else FULL)
    )
    if not quick:
        trial.files.append(folder / f"{view.name}.nc")
        save_dataset(dataset, trial.files[-1])
    return dataset


# Rows


def _common_rows(name: str, ds: xarray.Dataset, *, held: bool) -> Iterator[Row]:
    """What the paper says of every scene; bands apply if `held`, that is for the paper's scenes."""
    enough = (ds["n"] >= ENOUGH_PAIRS).values & (ds["theta_high"].values <= 90.0)
    negative = ds["mean"].values[enough] < 0
    a = ds.attrs
    limits = f"d < {a['slice_d']:g}, theta < {a['slice_theta_deg']:g} deg"
    yield Row(
        f"{name}: mean rho of pairs with {limits}",
        float(ds["corner"]),
        printed="close to 1" if held else None,
        band=bands.CORNER if held else None,
        note=f"{int(ds['corner_n'])} pairs, SE {float(ds['corner_se']):.2g}",
    )
    yield Row(
        f"{name}: share of bins with theta < 90 deg whose mean rho is negative",
        float(negative.mean()) if negative.size else None,
        printed="rarely" if held else None,
        band=bands.NEGATIVE_SHARE if held else None,
        note=f"{negative.size} bins",
    )
    yield Row(
        f"{name}: d_max of the spatial map",
        a["box_d_max"],
        note=f"largest box with mean rho >= 0.8; it has {a['box_mean']:.3f}",
    )
    yield Row(f"{name}: theta_max of the spatial map [deg]", a["box_theta_max_deg"])


def _slice_rows(name: str, ds: xarray.Dataset) -> Iterator[Row]:
    """What the paper shows with its only example, Figure 3."""
    enough = ds["near_n"].values >= ENOUGH_PAIRS
    theta, sigma = ds["theta_near"].values[enough], ds["near_sigma"].values[enough]
    yield Row(
        f"{name}: R^2 of a line through the slice over theta, 0 to 120 deg",
        straightness(ds),
        printed="near linear",
        band=bands.LINEAR_IN_THETA,
    )
    yield Row(
        f"{name}: share of the fall over d done by the middle",
        fall_by_the_middle(ds),
        printed="convex",
        band=bands.CONVEX_IN_D,
    )
    yield Row(
        f"{name}: theta of the largest sigma of the slice [deg]",
        float(theta[sigma.argmax()]) if theta.size else None,
        band=bands.LARGEST_SIGMA,
    )


def _size_rows(name: str, ds: xarray.Dataset, quick: bool) -> Iterator[Row]:
    a = ds.attrs
    per_second = a["n_pairs"] / a["pairs_s"] / 1e6 if a["pairs_s"] > 0 else 0.0
    note = (
        f"{a['n_rays']:.3g} rays, {a['rows_s']:.0f} s; pairs {a['pairs_s']:.0f} s, "
        f"{per_second:.0f} M/s"
    )
    yield Row(
        f"{name}: pair estimates",
        a["n_pairs"],
        printed="1.9e10 to 3.2e10",
        band=None if quick else bands.ESTIMATES,
        note=note,
    )
    yield Row(f"{name}: directions of an estimate", float(a["map_size"] ** 2), printed=9216.0)


def _line_rows(ds: xarray.Dataset) -> Iterator[Row]:
    """Horizontal lines of the flat scene: pairs at its typical angles over those nearby."""
    n = pairs_of_bins(ds).sum(axis=0)

    def per_degree(*ranges: tuple[int, int]) -> float:
        """Pairs per degree; at least one, for scenes with nothing but lines."""
        return max(1.0, float(np.concatenate([n[a:b] for a, b in ranges]).mean()))

    yield Row(
        "dynamics: pairs with theta in [0, 1) deg over those nearby",
        per_degree((0, 1)) / per_degree((2, 7)),
        printed="a line",
        band=bands.LINES,
    )
    yield Row(
        "dynamics: pairs with theta in [89, 91) deg over those nearby",
        per_degree((89, 91)) / per_degree((80, 88), (92, 100)),
        printed="a line",
        band=bands.LINES,
    )


def _order_rows(found: dict[str, xarray.Dataset]) -> list[Row]:
    """Overall correlation: dynamics above mushrooms above garden1."""
    overall = {name: overall_correlation(ds) for name, ds in found.items()}
    rows = [
        Row(f"{name}: mean rho of pairs with theta < 30 deg", value)
        for name, value in overall.items()
    ]
    for more, less in (("dynamics", "mushrooms"), ("mushrooms", "garden1")):
        rows.append(
            Row(
                f"overall correlation, {more} over {less}",
                overall[more] / overall[less],
                printed="more than 1",
                band=bands.ORDER,
            )
        )
    return rows


def straightness(ds: xarray.Dataset) -> float | None:
    """R² of a straight line through ρ̄ over θ of near pairs, 0° to 120°."""
    kept = (ds["near_n"].values >= ENOUGH_PAIRS) & (ds["theta_near"].values <= 120.0)
    if kept.sum() < 3:
        return None
    x, y = ds["theta_near"].values[kept], ds["near_mean"].values[kept]
    residual = y - np.polyval(np.polyfit(x, y, 1), x)
    return float(1.0 - residual.var() / y.var())


def fall_by_the_middle(ds: xarray.Dataset) -> float | None:
    """Share of the fall of ρ̄ over d, of aligned pairs, that is reached at the slice's middle.

    The slice runs from the first bins with 100 pairs to the last eighth, without an open last bin.
    Its middle is the eighth around the centre.
    """
    closed = np.isfinite(ds["d_aligned_high"].values)
    d, n = ds["d_aligned"].values[closed], ds["aligned_n"].values[closed]
    mean = np.nan_to_num(ds["aligned_mean"].values[closed])
    end = ds["d_aligned_high"].values[closed][-1]
    first = n.cumsum() - n < ENOUGH_PAIRS
    parts = (first, np.abs(d - end / 2) <= end / 16, d >= end * 7 / 8)
    if min(n[part].sum() for part in parts) < ENOUGH_PAIRS:
        return None
    start, middle, last = (float((n * mean)[part].sum() / n[part].sum()) for part in parts)
    return (start - middle) / (start - last)


def overall_correlation(ds: xarray.Dataset) -> float:
    """Mean ρ of all pairs with θ < 30°."""
    kept = ds["theta_high"].values <= 30.0
    weight = pairs_of_bins(ds)[:, kept]
    return float((weight * np.nan_to_num(ds["mean"].values[:, kept])).sum() / weight.sum())


def _picture(found: dict[str, xarray.Dataset]) -> Any:
    """Maps above, tables below; one column per scene."""
    columns = len(found)
    figure = new_figure(3.4 * columns, 6.2)
    axes = figure.subplots(2, columns, squeeze=False)
    image = None
    for k, (name, dataset) in enumerate(found.items()):
        image = plots.draw_map(axes[0, k], dataset)
        axes[0, k].set_title(f"({'abcdefgh'[k]}) {name}")
        plots.draw_table(axes[1, k], dataset)
        if k:
            axes[1, k].set_ylabel("")
    if image is not None:
        figure.colorbar(image, ax=axes, label=plots.MEAN_LABEL, shrink=0.6)
    return figure
