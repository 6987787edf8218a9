"""Figure 6 of the quantized cache's paper: geometry that is too fine for clusters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import viscache as vc
from viscache.base import tonemap
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panels, images
from viscache_lab.figures import aqvc_printed as printed
from viscache_lab.figures.aqvc_runs import Trade, difference, group_rows
from viscache_lab.figures.aqvc_setups import PRESETS, SETUPS
from viscache_lab.figures.bands import aqvc as bands

#: C_E without and with anti-aliasing; the paper does not give its value.
C_E = {False: 16.0, True: 36.0}


@FIGURES.add("aqvc-fig6", "fine geometry: the hairball", sized=True)
def figure6(trial: Trial) -> None:
    """The hairball, exact and with three presets, without and with anti-aliasing."""
    setup = SETUPS["hairball"]
    triangles = printed.SCENES["hairball"].triangles
    trial.row("triangles", setup.scene(trial.quick).triangles, printed=triangles)
    fast = []
    for antialiased, c_e in C_E.items():
        spp = 1 if not antialiased else 4 if trial.quick else setup.antialiased
        shot = setup.shot(trial.quick, trial.size, spp=spp)
        caches: dict[str, vc.Aqvc] = {preset: setup.cache(preset, c_e) for preset in PRESETS}
        trades = shot.trades(caches, trial.quick)
        fast.append(trades["fast"].speedup)
        label = "AA" if antialiased else "no AA"
        trial.rows += _rows(label, trades, trial.quick)
        name = "aqvc-fig6-aa.png" if antialiased else "aqvc-fig6.png"
        trial.draw(name, _panels(trades), (10.0, 3.2 * len(trades)))
        trial.notes.append(
            f"{label}: C_E {c_e:g}, {shot.size[0]}x{shot.size[1]}, {spp} samples per pixel"
        )
    trial.row(
        "fast: the larger speed-up",
        max(fast),
        printed=printed.HAIRBALL_SPEEDUP,
        band=None if trial.quick else bands.HAIRBALL_FAST,
    )


def _rows(label: str, trades: Mapping[str, Trade], quick: bool) -> Iterator[Row]:
    paper, default = trades["paper"], trades["default"]
    yield Row(f"{label}, paper: RR", paper.ray_reduction, band=bands.HAIRBALL_RR, note=paper.note)
    yield Row(f"{label}, default: RR", default.ray_reduction, note=default.note)
    yield Row(
        f"{label}, default: speed-up",
        default.speedup,
        printed=printed.HAIRBALL_SPEEDUP,
        band=None if quick else bands.HAIRBALL_SPEEDUP,
    )
    yield Row(
        f"{label}, fast: speed-up",
        trades["fast"].speedup,
        printed=printed.HAIRBALL_SPEEDUP,
        note=trades["fast"].note,
    )
    yield Row(
        f"{label}, paper: speed-up",
        paper.speedup,
        printed=printed.HAIRBALL_SPEEDUP,
        note="one look-up per query on a CPU, against packets of 16 rays",
    )
    for preset, trade in trades.items():
        yield Row(
            f"{label}, {preset}: speed-up over RR",
            trade.speedup / trade.ray_reduction,
            printed="almost identical",
            note="1 where only rays cost; ours come in packets, and misses cost more",
        )
        yield Row(
            f"{label}, {preset}: rel_l1",
            trade.rel_l1,
            note=f"SSIM {trade.ssim:.3f}; the sky behind the ball is part of the picture",
        )
        yield Row(f"{label}, {preset}: rel_l1 of reflected light", trade.reflected_rel_l1)
        yield from group_rows(f"{label}, {preset}", trade)


def _panels(trades: Mapping[str, Trade]) -> Panels:
    """Per name a row of pictures: exact, cached, amplified difference."""
    rows = []
    for name, trade in trades.items():
        exact, cached = (f"{f.timings['cpu_s']:.1f} CPU s" for f in (trade.exact, trade.frame))
        shown = {f"{name}: exact, {exact}": trade.exact, f"cached, {cached}": trade.frame}
        amplified = {f"16 × difference, rel_l1 {trade.rel_l1:.4f}": difference(trade)}
        exposure = tonemap.auto_exposure(trade.exact.image, 95.0)
        rows.append(images(shown, exposure) + images(amplified, 1.0))
    return rows
