"""Figure 6 of the quantized cache's paper: geometry that is too fine for clusters."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy.typing as npt

import viscache as vc
from viscache.base import tonemap
from viscache_lab.figures import aqvc_bands as bands
from viscache_lab.figures import aqvc_printed as printed
from viscache_lab.figures.aqvc_runs import Trade, difference, group_rows
from viscache_lab.figures.aqvc_setups import PRESETS, SETUPS
from viscache_lab.figures.drawing import draw_image, new_figure, save_figure
from viscache_lab.figures.outcome import Outcome, Row
from viscache_lab.figures.registry import figure

#: C_E without and with anti-aliasing; the paper does not give its value.
C_E = {False: 16.0, True: 36.0}


@figure("aqvc-fig6", "fine geometry: the hairball")
def figure6(
    folder: Path, quick: bool, progress: bool, size: tuple[int, int] | None = None
) -> Outcome:
    """The hairball, exact and with three presets, without and with anti-aliasing."""
    setup, outcome = SETUPS["hairball"], Outcome()
    triangles = printed.SCENES["hairball"].triangles
    outcome.rows.append(Row("triangles", setup.scene(quick).triangles, printed=triangles))
    fast = []
    for antialiased, c_e in C_E.items():
        spp = 1 if not antialiased else 4 if quick else setup.antialiased
        shot = setup.shot(quick, size, spp=spp)
        caches: dict[str, vc.Aqvc] = {preset: setup.cache(preset, c_e) for preset in PRESETS}
        trades = shot.trades(caches, quick)
        fast.append(trades["fast"].speedup)
        label = "AA" if antialiased else "no AA"
        outcome.rows += _rows(label, trades, quick)
        name = "aqvc-fig6-aa.png" if antialiased else "aqvc-fig6.png"
        outcome.files.append(draw_trades(trades, folder / name))
        outcome.notes.append(
            f"{label}: C_E {c_e:g}, {shot.size[0]}x{shot.size[1]}, {spp} samples per pixel"
        )
    outcome.rows.append(
        Row(
            "fast: the larger speed-up",
            max(fast),
            printed=printed.HAIRBALL_SPEEDUP,
            band=None if quick else bands.HAIRBALL_FAST,
        )
    )
    return outcome


def _rows(label: str, trades: Mapping[str, Trade], quick: bool) -> list[Row]:
    paper, default = trades["paper"], trades["default"]
    rows = [
        Row(f"{label}, paper: RR", paper.ray_reduction, band=bands.HAIRBALL_RR, note=paper.note),
        Row(f"{label}, default: RR", default.ray_reduction, note=default.note),
        Row(
            f"{label}, default: speed-up",
            default.speedup,
            printed=printed.HAIRBALL_SPEEDUP,
            band=None if quick else bands.HAIRBALL_SPEEDUP,
        ),
        Row(
            f"{label}, fast: speed-up",
            trades["fast"].speedup,
            printed=printed.HAIRBALL_SPEEDUP,
            note=trades["fast"].note,
        ),
        Row(
            f"{label}, paper: speed-up",
            paper.speedup,
            printed=printed.HAIRBALL_SPEEDUP,
            note="one look-up per query on a CPU, against packets of 16 rays",
        ),
    ]
    for preset, trade in trades.items():
        rows += [
            Row(
                f"{label}, {preset}: speed-up over RR",
                trade.speedup / trade.ray_reduction,
                printed="almost identical",
                note="1 where only rays cost; ours come in packets, and misses cost more",
            ),
            Row(
                f"{label}, {preset}: rel_l1",
                trade.rel_l1,
                note=f"SSIM {trade.ssim:.3f}; the sky behind the ball is part of the picture",
            ),
            Row(f"{label}, {preset}: rel_l1 of reflected light", trade.reflected_rel_l1),
            *group_rows(f"{label}, {preset}", trade),
        ]
    return rows


def draw_trades(trades: Mapping[str, Trade], path: Path) -> Path:
    """Per name a row of pictures: exact, cached, amplified difference."""
    figure = new_figure(10.0, 3.2 * len(trades))
    for row, (name, trade) in enumerate(trades.items()):
        exposure = tonemap.auto_exposure(trade.exact.image, 95.0)
        panels: list[tuple[str, npt.NDArray[Any]]] = [
            (f"{name}: exact, {trade.exact.timings['cpu_s']:.1f} CPU s", trade.exact.image),
            (f"cached, {trade.frame.timings['cpu_s']:.1f} CPU s", trade.frame.image),
            (f"16 × difference, rel_l1 {trade.rel_l1:.4f}", difference(trade)),
        ]
        for column, (title, image) in enumerate(panels):
            axes = figure.add_subplot(len(trades), 3, 3 * row + column + 1)
            draw_image(axes, image, title, exposure=exposure if column < 2 else 1.0)
    return save_figure(figure, path)
