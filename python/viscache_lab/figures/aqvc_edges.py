"""Figures 3 and 4 of the quantized cache's paper: refinement and pixel order at shadow edges."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.base import tonemap
from viscache.settings.by_name import replaced
from viscache_lab.figures import aqvc_bands as bands
from viscache_lab.figures.aqvc_runs import Shot, Trade, presets
from viscache_lab.figures.drawing import draw_image, new_figure, save_figure
from viscache_lab.figures.outcome import Outcome, Row
from viscache_lab.figures.registry import figure
from viscache_lab.figures.vlf_tracers import write_csv

C_E = 16.0
SIZE = (640, 400)
#: Orders of pixels, and the numbers of random grids and orders.
ORDERS = ("scanline", "hm", "random")
GRIDS, QUICK_GRIDS = 12, 4

Plane = npt.NDArray[np.float64]


@figure("aqvc-fig3", "shadow edges with and without refinement")
def figure3(
    folder: Path, quick: bool, progress: bool, size: tuple[int, int] | None = None
) -> Outcome:
    """Stairs in the sun with and without refinement."""
    shot = Shot(scene=vc.scenes.stairs(), integrator=vc.Direct(), size=size or SIZE)
    exact = shot.frame()
    found: dict[str, dict[str, Trade]] = {"default": {}, "paper": {}}
    for refinement in ("off", "on"):
        for preset, settings in presets(C_E, refinement=refinement).items():
            found[preset][refinement] = Trade(frame=shot.frame(settings), exact=exact)
    outcome = Outcome()
    for preset, trades in found.items():
        without, refined = trades["off"], trades["on"]
        outcome.rows += [
            Row(
                f"{preset}: rel_l1 without refinement over that with it",
                without.rel_l1 / refined.rel_l1,
                band=bands.REFINEMENT_GAIN[preset],
                note=f"{without.rel_l1:.4f} to {refined.rel_l1:.4f}",
            ),
            Row(
                f"{preset}: RR without refinement over that with it",
                without.ray_reduction / refined.ray_reduction,
                band=bands.REFINEMENT_COST,
                note=f"{without.ray_reduction:.1f} to {refined.ray_reduction:.1f}",
            ),
        ]
    outcome.files.append(_draw_refinement(exact, found, folder / "aqvc-fig3.png"))
    outcome.notes.append(f"C_E {C_E:g}, one sun, {shot.size[0]}x{shot.size[1]}, one sample")
    return outcome


def _draw_refinement(exact: vc.Frame, found: Mapping[str, Mapping[str, Trade]], path: Path) -> Path:
    figure = new_figure(9.0, 6.0)
    exposure = tonemap.auto_exposure(exact.image, 95.0)
    pictures = {"exact": exact.image}
    for preset, trades in found.items():
        for refinement, trade in trades.items():
            pictures[f"{preset}, refinement {refinement}"] = trade.frame.image
    height, width = exact.image.shape[:2]
    window = np.s_[height // 3 : height, width // 4 : 3 * width // 4]
    for k, (title, image) in enumerate(pictures.items()):
        axes = figure.add_subplot(2, 3, (1, 2, 3, 5, 6)[k])
        draw_image(axes, image[window], title, exposure=exposure)
    return save_figure(figure, path)


@figure("aqvc-fig4", "a shadow's shift in scan-line order")
def figure4(
    folder: Path, quick: bool, progress: bool, size: tuple[int, int] | None = None
) -> Outcome:
    """A cube's shadow with each order of the pixels."""
    shot = Shot(scene=vc.scenes.cube_on_plane(), integrator=vc.Direct(), size=size or SIZE)
    exact = shot.frame()
    table: list[dict[str, Any]] = []
    frames: dict[str, vc.Frame] = {}
    for order in ORDERS:
        for grid in range(QUICK_GRIDS if quick else GRIDS):
            for refinement in ("off", "on"):
                base = vc.Aqvc(preset="paper", c_e=C_E, paper=vc.PaperForm(grid_seed=grid))
                chosen = {"order": order, "refinement": refinement, "storage": "exact"}
                settings = replaced(base, chosen, "visibility")
                trade = Trade(frame=shot.frame(settings), exact=exact)
                x, y = shift(shadow(trade.frame), shadow(exact))
                table.append(
                    {
                        "order": order,
                        "grid": grid,
                        "refinement": refinement,
                        "shift_x": x,
                        "shift_y": y,
                        "rel_l1": trade.rel_l1,
                        "rays": trade.frame.counters["rays"],
                    }
                )
                if refinement == "off":
                    frames.setdefault(order, trade.frame)
    outcome = Outcome(rows=_order_rows(table))
    outcome.files += [
        _draw_orders(exact, frames, folder / "aqvc-fig4.png"),
        write_csv(folder / "aqvc-fig4.csv", table),
    ]
    outcome.notes.append(
        f"Preset paper with a table without loss, C_E {C_E:g}, an order per tile of "
        f"{exact.parameters['tile_edge_px']} pixels. A shift is the one that takes the exact "
        "shadow to the cached one best, in least squares of first order; means over grids."
    )
    return outcome


def shadow(frame: vc.Frame) -> Plane:
    """(H, W): luminance from the point lights."""
    return tonemap.luminance(frame.layers["point"])


def shift(image: Plane, reference: Plane) -> tuple[float, float]:
    """The shift (x, y), in pixels right and down, that moves the reference best onto the image.

    Least squares of reference(p − s) − image(p), to first order in s, over all pixels except the
    border. Both images are smoothed by a Gaussian of 4 pixels. Three steps are taken.
    """
    from scipy.ndimage import gaussian_filter
    from scipy.ndimage import shift as moved

    a, b = (gaussian_filter(plane, 4.0) for plane in (image, reference))
    x = y = 0.0
    for _ in range(3):
        at = moved(b, (y, x), order=1, mode="nearest")
        down, right = (g[8:-8, 8:-8] for g in np.gradient(at))
        residual = (at - a)[8:-8, 8:-8]
        normal = [[(right**2).sum(), (right * down).sum()], [(right * down).sum(), (down**2).sum()]]
        step = np.linalg.solve(normal, [(right * residual).sum(), (down * residual).sum()])
        x, y = x + float(step[0]), y + float(step[1])
    return x, y


def _order_rows(table: list[dict[str, Any]]) -> list[Row]:
    def mean(order: str, refinement: str, what: str) -> float:
        chosen = [r[what] for r in table if (r["order"], r["refinement"]) == (order, refinement)]
        return float(np.mean(chosen))

    rows, length = [], {}
    for order in ORDERS:
        x, y = mean(order, "off", "shift_x"), mean(order, "off", "shift_y")
        length[order] = float(np.hypot(x, y))
        for axis, value in (("right", x), ("down", y)):
            rows.append(
                Row(
                    f"{order}: shift to the {axis}"
                    if axis == "right"
                    else f"{order}: shift {axis}",
                    value,
                    band=bands.SCANLINE_SHIFT if order == "scanline" else None,
                    note="pixels",
                )
            )
    for order in ORDERS[1:]:
        rows.append(
            Row(
                f"{order}: length of the shift over that of scanline",
                length[order] / length["scanline"],
                band=bands.ORDER_CURES,
            )
        )
    hurt = mean("scanline", "on", "rel_l1") / mean("hm", "on", "rel_l1")
    rows.append(
        Row(
            "with refinement, rel_l1 of scanline over that of hm",
            hurt,
            band=bands.SCANLINE_HURTS_REFINEMENT,
            note=f"{mean('scanline', 'on', 'rel_l1'):.4f} over {mean('hm', 'on', 'rel_l1'):.4f}",
        )
    )
    for order in ("scanline", "random"):
        rows.append(
            Row(
                f"without refinement, rays of {order} over those of hm",
                mean(order, "off", "rays") / mean("hm", "off", "rays"),
                band=bands.ORDER_KEEPS_RAYS,
            )
        )
    return rows


def _draw_orders(exact: vc.Frame, frames: Mapping[str, vc.Frame], path: Path) -> Path:
    figure = new_figure(10.0, 3.0)
    exposure = tonemap.auto_exposure(exact.image, 95.0)
    pictures = {"scanline": frames["scanline"], "exact": exact, "random": frames["random"]}
    for k, (title, frame) in enumerate(pictures.items()):
        draw_image(figure.add_subplot(1, 3, k + 1), frame.image, title, exposure=exposure)
    return save_figure(figure, path)
