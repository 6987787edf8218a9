"""Figures 3 and 4 of the quantized cache's paper: refinement and pixel order at shadow edges."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.base import tonemap
from viscache.settings.by_name import replaced
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panels, images
from viscache_lab.figures.aqvc_runs import Shot, Trade, presets
from viscache_lab.figures.bands import aqvc as bands

C_E = 16.0
SIZE = (640, 400)
#: Orders of pixels, and the numbers of random grids and orders.
ORDERS = ("scanline", "hm", "random")
GRIDS, QUICK_GRIDS = 12, 4

Plane = npt.NDArray[np.float64]


@FIGURES.add("aqvc-fig3", "shadow edges with and without refinement", sized=True)
def figure3(trial: Trial) -> None:
    """Stairs in the sun with and without refinement."""
    shot = Shot(scene=vc.scenes.stairs(), integrator=vc.Direct(), size=trial.size or SIZE)
    exact = shot.frame()
    found: dict[str, dict[str, Trade]] = {"default": {}, "paper": {}}
    for refinement in ("off", "on"):
        for preset, settings in presets(C_E, refinement=refinement).items():
            found[preset][refinement] = Trade(frame=shot.frame(settings), exact=exact)
    for preset, trades in found.items():
        without, refined = trades["off"], trades["on"]
        trial.row(
            f"{preset}: rel_l1 without refinement over that with it",
            without.rel_l1 / refined.rel_l1,
            band=bands.REFINEMENT_GAIN[preset],
            note=f"{without.rel_l1:.4f} to {refined.rel_l1:.4f}",
        )
        trial.row(
            f"{preset}: RR without refinement over that with it",
            without.ray_reduction / refined.ray_reduction,
            band=bands.REFINEMENT_COST,
            note=f"{without.ray_reduction:.1f} to {refined.ray_reduction:.1f}",
        )
    trial.draw("aqvc-fig3.png", _refinement(exact, found), (9.0, 6.0))
    trial.notes.append(f"C_E {C_E:g}, one sun, {shot.size[0]}x{shot.size[1]}, one sample")


def _refinement(exact: vc.Frame, found: Mapping[str, Mapping[str, Trade]]) -> Panels:
    """The exact picture beside those of one preset, and those of the other below."""
    height, width = exact.image.shape[:2]
    window = np.s_[height // 3 : height, width // 4 : 3 * width // 4]
    shown = {"exact": exact.image[window]}
    for preset, trades in found.items():
        for refinement, trade in trades.items():
            shown[f"{preset}, refinement {refinement}"] = trade.frame.image[window]
    panels = images(shown, tonemap.auto_exposure(exact.image, 95.0))
    return [panels[:3], [None, *panels[3:]]]


@FIGURES.add("aqvc-fig4", "a shadow's shift in scan-line order", sized=True)
def figure4(trial: Trial) -> None:
    """A cube's shadow with each order of the pixels."""
    shot = Shot(scene=vc.scenes.cube_on_plane(), integrator=vc.Direct(), size=trial.size or SIZE)
    exact = shot.frame()
    table: list[dict[str, Any]] = []
    frames: dict[str, vc.Frame] = {}
    for order in ORDERS:
        for grid in range(QUICK_GRIDS if trial.quick else GRIDS):
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
    trial.rows += _order_rows(table)
    exposure = tonemap.auto_exposure(exact.image, 95.0)
    shown = {"scanline": frames["scanline"], "exact": exact, "random": frames["random"]}
    trial.draw("aqvc-fig4.png", [images(shown, exposure)], (10.0, 3.0))
    trial.csv("aqvc-fig4.csv", table)
    trial.notes.append(
        f"Preset paper with a table without loss, C_E {C_E:g}, an order per tile of "
        f"{exact.parameters['tile_edge_px']} pixels. A shift is the one that takes the exact "
        "shadow to the cached one best, in least squares of first order; means over grids."
    )


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


def _order_rows(table: list[dict[str, Any]]) -> Iterator[Row]:
    def mean(order: str, refinement: str, what: str) -> float:
        chosen = [r[what] for r in table if (r["order"], r["refinement"]) == (order, refinement)]
        return float(np.mean(chosen))

    length = {}
    for order in ORDERS:
        x, y = mean(order, "off", "shift_x"), mean(order, "off", "shift_y")
        length[order] = float(np.hypot(x, y))
        for axis, value in (("right", x), ("down", y)):
            yield Row(
                f"{order}: shift to the {axis}" if axis == "right" else f"{order}: shift {axis}",
                value,
                band=bands.SCANLINE_SHIFT if order == "scanline" else None,
                note="pixels",
            )
    for order in ORDERS[1:]:
        yield Row(
            f"{order}: length of the shift over that of scanline",
            length[order] / length["scanline"],
            band=bands.ORDER_CURES,
        )
    hurt = mean("scanline", "on", "rel_l1") / mean("hm", "on", "rel_l1")
    yield Row(
        "with refinement, rel_l1 of scanline over that of hm",
        hurt,
        band=bands.SCANLINE_HURTS_REFINEMENT,
        note=f"{mean('scanline', 'on', 'rel_l1'):.4f} over {mean('hm', 'on', 'rel_l1'):.4f}",
    )
    for order in ("scanline", "random"):
        yield Row(
            f"without refinement, rays of {order} over those of hm",
            mean(order, "off", "rays") / mean("hm", "off", "rays"),
            band=bands.ORDER_KEEPS_RAYS,
        )
