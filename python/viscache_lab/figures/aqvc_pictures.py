"""Figure 5 of the quantized cache's paper: exact and cached pictures, amplified differences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.base import tonemap
from viscache_lab.experiment import FIGURES, Band, Row, Trial
from viscache_lab.experiment.drawing import Panel, Panels
from viscache_lab.figures import aqvc_printed as printed
from viscache_lab.figures.aqvc_runs import (
    AMPLIFIED,
    Shot,
    Trade,
    difference,
    error_row,
    group_rows,
    presets,
)
from viscache_lab.figures.aqvc_setups import PRESETS, SETUPS
from viscache_lab.figures.bands import aqvc as bands


@dataclass(frozen=True, slots=True)
class Case:
    """One picture: its C_E, and its samples per pixel in full and quick runs."""

    setup: str
    spp: int
    quick_spp: int
    c_e: float
    c_e_note: str


#: The paper's samples are 9, 1, 16 and 16. A cluster spans C_E/√spp pixels, so fewer samples need
#: a smaller C_E.
PANELS = (
    Case("courtyard", 2, 1, printed.SAN_MIGUEL_C_E * (2 / 9) ** 0.5, "36 at 9 samples"),
    Case("conference", 1, 1, 12.0, "not told"),
    Case("apartment", 1, 1, 12.0, "not told; 4 for the lamps"),
    Case("delta", 16, 4, printed.MAPS_C_E, "14 in Figure 8"),
)
BIDIRECTIONAL_SIZE, QUICK_BIDIRECTIONAL_SIZE = (256, 256), (48, 48)
BIDIRECTIONAL_SPP, QUICK_BIDIRECTIONAL_SPP = 64, 4


@FIGURES.add("aqvc-fig5", "exact and cached images, amplified difference", sized=True)
def figure5(trial: Trial) -> None:
    """Four scenes with three presets, and bidirectional path tracing with two."""
    for panel in PANELS:
        setup = SETUPS[panel.setup]
        shot = setup.shot(
            trial.quick, trial.size, spp=panel.quick_spp if trial.quick else panel.spp
        )
        caches: dict[str, vc.Aqvc] = {p: setup.cache(p, panel.c_e) for p in PRESETS}
        trades = shot.trades(caches, trial.quick)
        trial.rows += _panel_rows(panel, trades, trial.quick)
        trial.draw(f"aqvc-fig5-{panel.setup}.png", *drawing(panel.setup, trades))
        trial.notes.append(
            f"{panel.setup}: {shot.size[0]}x{shot.size[1]}, {shot.spp} samples, C_E "
            f"{panel.c_e:.3g}; the paper's C_E: {panel.c_e_note}"
        )
    light_paths = bidirectional(trial.quick, trial.size)
    for preset, trade in light_paths.items():
        band = bands.BIDIRECTIONAL_RR if preset == "paper" and not trial.quick else None
        trial.rows += _rows(
            "bidirectional", preset, trade, band, printed_rr=printed.BIDIRECTIONAL_REDUCTION
        )
    trial.draw("aqvc-fig5-bidirectional.png", *drawing("bidirectional", light_paths))
    trial.notes.append(
        "bidirectional: Cornell box, "
        f"{QUICK_BIDIRECTIONAL_SPP if trial.quick else BIDIRECTIONAL_SPP} paths per pixel, "
        f"C_E {printed.BIDIRECTIONAL_C_E:g}, no refinement; the paper's 750 "
        "paths in a scene that it does not name"
    )


def bidirectional(quick: bool, size: tuple[int, int] | None) -> dict[str, Trade]:
    """Bidirectional path tracing, by preset."""
    shot = Shot(
        scene=vc.scenes.cornell_box(),
        integrator=vc.Bdpt(),
        size=size or (QUICK_BIDIRECTIONAL_SIZE if quick else BIDIRECTIONAL_SIZE),
        spp=QUICK_BIDIRECTIONAL_SPP if quick else BIDIRECTIONAL_SPP,
    )
    return shot.trades(presets(printed.BIDIRECTIONAL_C_E), quick)


def _panel_rows(panel: Case, trades: Mapping[str, Trade], quick: bool) -> Iterator[Row]:
    stand_in = SETUPS[panel.setup]
    band = bands.QUICK_PICTURE_RR if quick else bands.PICTURE_RR[panel.setup]
    error = bands.QUICK_PICTURE_ERROR if quick else bands.PICTURE_ERROR
    yield Row(
        f"{panel.setup}: triangles",
        stand_in.scene(quick).triangles,
        printed=printed.SCENES[stand_in.printed].triangles,
    )
    for preset, trade in trades.items():
        yield from _rows(
            panel.setup,
            preset,
            trade,
            band if preset == "paper" else None,
            printed_speedup=printed.SCENES[stand_in.printed].implied_speedup,
            error=error if preset != "fast" else None,
        )


def _rows(
    name: str,
    preset: str,
    trade: Trade,
    band: Band | None,
    *,
    printed_rr: float | None = None,
    printed_speedup: float | None = None,
    error: Band | None = None,
) -> Iterator[Row]:
    label = f"{name}, {preset}"
    yield Row(f"{label}: RR", trade.ray_reduction, printed=printed_rr, band=band, note=trade.note)
    yield Row(f"{label}: speed-up", trade.speedup, printed=printed_speedup)
    yield error_row(label, trade, error)
    yield from group_rows(label, trade)


def diagonal(above: npt.NDArray[Any], below: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """One picture above the rising diagonal, the other below it, a thin black line between them."""
    height, width = above.shape[:2]
    rows, columns = np.mgrid[0:height, 0:width]
    # Negative above the line from the lower left to the upper right corner
    side = (rows + 0.5) / height + (columns + 0.5) / width - 1
    picture = np.where((side < 0)[..., None], above, below)
    picture[np.abs(side) < 1.0 / max(height, width)] = 0
    return picture


def drawing(name: str, trades: Mapping[str, Trade]) -> tuple[Panels, tuple[float, float]]:
    """Per preset: the exact picture above the cached one, and the amplified difference."""
    rows = []
    for preset, trade in trades.items():
        exposure = tonemap.auto_exposure(trade.exact.image, 95.0)
        exact, cached = (f"{f.timings['cpu_s']:.1f} CPU s" for f in (trade.exact, trade.frame))
        both = diagonal(trade.exact.image, trade.frame.image)
        title = f"{name}: exact, {exact}, over {preset}, {cached}"
        amplified = f"{AMPLIFIED:g} × difference"
        rows.append(
            [
                Panel(title=title, image=both, exposure=exposure),
                Panel(title=amplified, image=difference(trade), exposure=1.0),
            ]
        )
    return rows, (9.0, 3.0 * len(trades))
