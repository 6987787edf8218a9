"""Table 2, Figures 8 and 12 of the visibility-map paper: number and places of records."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.correlation import measure
from viscache.scene.cameras import find_camera
from viscache.vismap import UpdateReport
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.amounts import build_scene
from viscache_lab.experiment.drawing import Panel, Panels, draw_records
from viscache_lab.figures import vismap_printed as printed
from viscache_lab.figures.bands import vismap as bands
from viscache_lab.figures.vismap_living_room import living_rooms

Floats = npt.NDArray[np.floating[Any]]
Cells = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class View:
    """A scene of the paper with its camera, and the M of its maps."""

    scene: str
    quick_scene: str
    camera: int = 0
    m: int = 5

    def open(self, quick: bool) -> vc.Scene:
        """The scene, smaller for quick runs."""
        return build_scene(self.quick_scene if quick else self.scene)


VIEWS = {
    "garage": View("garage", "garage?triangles=60000"),
    "dynamics": View("dynamics", "dynamics", m=6),
    "garden1": View("garden", "garden?triangles=100000"),
    "garden2": View("garden", "garden?triangles=100000", camera=1),
}
MUSHROOMS = View("mushrooms", "mushrooms?triangles=60000")
FULL, QUICK = (1600, 1200), (160, 120)
#: Figures 8 and 12.
FULL_PICTURE, QUICK_PICTURE = (800, 600), (200, 150)
#: Points at which ρ of the surroundings is measured, in 2^9 cells of 16.
POINTS, LEVELS, MAP_SIZE = 8192, 9, 24


@dataclass(frozen=True, kw_only=True, slots=True)
class Built:
    """A cache after its first update."""

    cache: vc.VisibilityMapCache
    report: UpdateReport

    @property
    def added(self) -> Floats:
        """(N, 3) positions of the records that a criterion requested, without the start-up's."""
        return np.asarray(self.cache.records().positions[self.report.startup :])


def build_cache(
    scene: vc.Scene, camera: int, size: tuple[int, int], settings: vc.MapSettings
) -> Built:
    """A cache for one picture."""
    cache = vc.VisibilityMapCache(scene, settings)
    return Built(cache=cache, report=cache.update(camera, size=size))


@FIGURES.add("vismap-tab2", "records, resolutions and rays per pixel of three scenes")
def table2(trial: Trial) -> None:
    """Records, resolutions and rays per pixel of three scenes, and of two not in the paper."""
    size = QUICK if trial.quick else FULL
    for name, view in VIEWS.items():
        scene = view.open(trial.quick)
        built = build_cache(scene, view.camera, size, vc.MapSettings(m=view.m))
        trial.rows += _table_rows(name, built, size)
        automatic = vc.MapSettings(preset="auto", m=view.m)
        trial.rows.append(_automatic_row(name, build_cache(scene, view.camera, size, automatic)))
    for label, scene in living_rooms(trial):
        rows = _table_rows(label, build_cache(scene, 0, size, vc.MapSettings()), size)
        trial.rows += [replace(row, band=None) for row in rows]
    if trial.quick:
        trial.notes.append(f"quick: smaller scenes at {size[0]}x{size[1]} pixels")


def _table_rows(name: str, built: Built, size: tuple[int, int]) -> Iterator[Row]:
    r, cache, said = built.report, built.cache, printed.CACHES.get(name)
    m, n = cache.settings.m, len(built.cache)
    bytes_each = cache.nbytes // max(n, 1)
    w_min, delta_max = cache.thresholds
    why = (
        f"start-up {r.startup}, none in reach {r.no_candidate}, weight {r.weight}, "
        f"difference {r.difference}, too near {r.suppressed}; "
        f"w_min {w_min:g}, delta_max {delta_max:g}"
    )
    yield Row(f"{name}: records", n, printed=said.records if said else None, note=why)
    yield Row(f"{name}: cells along an edge", 1 << m, printed=said.map_size if said else None)
    yield Row(
        f"{name}: rays per pixel",
        r.rays / (size[0] * size[1]),
        printed=said.rays_per_pixel if said else None,
    )
    yield Row(
        f"{name}: rays over records · 4^M / 2",
        r.rays / (n * 4**m / 2),
        printed=1.0,
        band=bands.RAYS_OF_RECORDS,
    )
    yield Row(
        f"{name}: bytes of a record",
        bytes_each,
        printed=printed.RECORD_BYTES if m == 5 else None,
        band=bands.RECORD_BYTES if m == 5 else None,
        note=f"{cache.nbytes / 1e6:.3g} MB in all, {cache.extra_nbytes / 1e6:.3g} MB besides",
    )


def _automatic_row(name: str, built: Built) -> Row:
    said = printed.CACHES.get(name)
    w_min, delta_max = built.cache.thresholds
    return Row(
        f'{name}: records with preset="auto"',
        len(built.cache),
        printed=said.records if said else None,
        note=f"w_min {w_min:.3g}, delta_max {delta_max:.3g}",
    )


@FIGURES.add("vismap-fig8", "positions of the records")
def figure8(trial: Trial) -> None:
    """Records by weight only, and by the difference of maps only."""
    scene, size = MUSHROOMS.open(trial.quick), QUICK_PICTURE if trial.quick else FULL_PICTURE
    by_weight = build_cache(scene, 0, size, vc.MapSettings(w_min=0.4, delta_max=1.0))
    by_difference = build_cache(scene, 0, size, vc.MapSettings(w_min=0.0, delta_max=0.06))
    trial.rows += _attraction_rows(scene, by_weight.added, by_difference.added)
    added = {"weight": by_weight.added, "difference": by_difference.added}
    trial.draw("vismap-fig8.png", _dots(scene, 0, size, added), (10.0, 4.0), dpi=150)


def _attraction_rows(scene: vc.Scene, by_weight: Floats, by_difference: Floats) -> Iterator[Row]:
    """Rank correlations of the densities with curvature, and with 1 − ρ of the surroundings."""
    ds = measure(scene, n_points=POINTS, map_size=MAP_SIZE)
    positions, normals = ds["position"].values, ds["normal"].values
    cell = equal_cells(positions, LEVELS)
    low_rho = per_cell_mean(1 - ds["local_mean"].values, cell)
    curved = per_cell_angle(normals, cell)
    for name, records in (("weight", by_weight), ("difference", by_difference)):
        density = records_per_cell(records, positions, cell)
        for what, attraction in (("1 - rho", low_rho), ("mean angle of normals", curved)):
            band = {
                ("weight", "mean angle of normals"): bands.WEIGHT_FINDS_CURVATURE,
                ("difference", "1 - rho"): bands.DIFFERENCE_FINDS_LOW_RHO,
            }.get((name, what))
            yield Row(
                f"rank correlation of the density by {name} with {what}",
                rank_correlation(density, attraction),
                band=band,
                note=f"{len(records)} records, {1 << LEVELS} cells",
            )


def equal_cells(positions: Floats, levels: int) -> Cells:
    """(N,) cell in [0, 2^levels) of each point.

    Each level halves the cells along their longest axis, at equal counts. Points are the pixels'
    first hits, so cells are equal parts of the picture.
    """
    cell = np.zeros(len(positions), np.int64)
    parts = [np.arange(len(positions))]
    for _ in range(levels):
        halves = []
        for part in parts:
            axis = int(np.ptp(positions[part], axis=0).argmax())
            order = part[np.argsort(positions[part, axis], kind="stable")]
            halves += [order[: len(order) // 2], order[len(order) // 2 :]]
        parts = halves
    for number, part in enumerate(parts):
        cell[part] = number
    return cell


def records_per_cell(records: Floats, positions: Floats, cell: Cells) -> Floats:
    """Number of records (R, 3) whose nearest point is in each cell."""
    from scipy.spatial import cKDTree  # type: ignore[import-untyped,unused-ignore]

    _, nearest = cKDTree(positions).query(records)
    return np.bincount(cell[nearest], minlength=int(cell.max()) + 1).astype(float)


def per_cell_mean(values: Floats, cell: Cells) -> Floats:
    """Mean of the finite values of each cell; NaN without any."""
    known = np.isfinite(values)
    n = np.bincount(cell[known], minlength=int(cell.max()) + 1)
    sums = np.bincount(cell[known], values[known], minlength=int(cell.max()) + 1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(sums / n)


def per_cell_angle(normals: Floats, cell: Cells) -> Floats:
    """Mean angle between a cell's normals and their sum, in degrees: a measure of curvature."""
    count = int(cell.max()) + 1
    axes = [np.bincount(cell, normals[:, k], minlength=count) for k in range(3)]
    sums: Floats = np.stack(axes, axis=-1).astype(float)
    sums = sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12)
    cosine = (normals * sums[cell]).sum(axis=1)
    return per_cell_mean(np.degrees(np.arccos(np.clip(cosine, -1, 1))), cell)


def rank_correlation(a: Floats, b: Floats) -> float:
    """Spearman's coefficient of two rows of values, without entries where either is not finite."""
    from scipy.stats import spearmanr  # type: ignore[import-untyped,unused-ignore]

    known = np.isfinite(a) & np.isfinite(b)
    return float(spearmanr(a[known], b[known]).statistic)


@FIGURES.add("vismap-fig12", "records in the garden scene")
def figure12(trial: Trial) -> None:
    """Records of the garden, and their ratio to those of a simple scene."""
    size = QUICK_PICTURE if trial.quick else FULL_PICTURE
    built = {}
    for name in ("garden1", "dynamics"):
        view = VIEWS[name]
        scene = view.open(trial.quick)
        built[name] = build_cache(scene, view.camera, size, vc.MapSettings())
        panels = _dots(scene, view.camera, size, {name: built[name].cache.records().positions})
        trial.draw(f"vismap-fig12-{name}.png", panels, (5.0, 4.0), dpi=150)
    counts = {name: len(b.cache) for name, b in built.items()}
    trial.row(
        "records of garden1 over records of dynamics, same parameters",
        counts["garden1"] / counts["dynamics"],
        band=bands.HARD_SCENES_GET_MORE,
        note=f"{counts['garden1']} and {counts['dynamics']} at {size[0]}x{size[1]}",
    )


def _dots(
    scene: vc.Scene, camera: int, size: tuple[int, int], records: dict[str, Floats]
) -> Panels:
    view: vc.Camera = find_camera(scene, camera)
    image = vc.render(scene, vc.Direct(n_environment=16), camera=camera, size=size).image

    def panel(name: str, positions: Floats) -> Panel:
        title = f"{name}: {len(positions)} records"
        return Panel(more=lambda axes: draw_records(axes, image, view, positions, title))

    return [[panel(*some) for some in records.items()]]
