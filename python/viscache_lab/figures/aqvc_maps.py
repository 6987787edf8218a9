"""Figure 8 of the quantized cache's paper: the cache and shadow maps, with a sun and lamps."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import viscache as vc
from viscache.base import tonemap
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panel, Panels, images, lines
from viscache_lab.figures import aqvc_printed as printed
from viscache_lab.figures.aqvc_runs import Shot, Trade
from viscache_lab.figures.aqvc_setups import CLOSE_UP, SETUPS
from viscache_lab.figures.bands import aqvc as bands

#: Texels per edge; the small maps are for equal time.
RESOLUTIONS = (64, 128, 256, 512, 1024, 2048, 4096)
QUICK_RESOLUTIONS = (16, 32, 64, 128)
#: Largest share of the machine's memory for maps.
MEMORY_SHARE = 0.6


@FIGURES.add("aqvc-fig8", "error over time beside shadow maps, from afar and close up", sized=True)
def figure8(trial: Trial) -> None:
    """Error and time of both, from a distance and close up."""
    table = []
    overview = SETUPS["delta"].shot(trial.quick, trial.size)
    place, target, fov_deg = CLOSE_UP
    close = replace(overview, camera=vc.look_at(place, target, (0.0, 1.0, 0.0), fov_deg))
    resolutions = fitting(QUICK_RESOLUTIONS if trial.quick else RESOLUTIONS, trial)
    found: dict[str, dict[str, Trade]] = {}
    for view, shot in (("overview", overview), ("close-up", close)):
        found[view] = trades = compare(shot, resolutions, trial.quick)
        table += [{"view": view, "method": n, **t.record()} for n, t in trades.items()]
        trial.rows += _view_rows(view, trades, resolutions, trial.quick)
    shown = [_panels(trades, resolutions) for trades in found.values()]
    trial.draw("aqvc-fig8.png", shown, (12.0, 4.6))
    trial.draw("aqvc-fig8-trade.png", _trade(found, resolutions))
    trial.csv("aqvc-fig8.csv", table)
    trial.notes.append(
        f"24 omni lights and a sun, C_E {printed.MAPS_C_E:g}. Our maps are traced by the ray "
        "caster, the paper's rasterized by a GPU; their time includes making them."
    )


def fitting(resolutions: Sequence[int], trial: Trial, lights: int = 24) -> list[int]:
    """The resolutions whose maps fit into memory; the others are recorded in `trial.skipped`."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    kept = []
    for resolution in resolutions:
        needed = 4 * (6 * lights + 1) * resolution**2
        if needed <= MEMORY_SHARE * memory:
            kept.append(resolution)
        else:
            trial.skip(
                f"maps of {resolution}x{resolution}",
                f"they need {needed / 2**30:.1f} GiB of memory",
            )
    return kept


def compare(shot: Shot, resolutions: Sequence[int], quick: bool) -> dict[str, Trade]:
    """Frames by name: of the cache with both presets, and of maps."""
    setup, c_e = SETUPS["delta"], printed.MAPS_C_E
    settings: dict[str, Any] = {p: setup.cache(p, c_e) for p in ("default", "paper")}
    settings |= {_map(r): vc.ShadowMap(resolution=r, max_bytes=1 << 40) for r in resolutions}
    return shot.trades(settings, quick)


def _map(resolution: int) -> str:
    return f"map {resolution}"


def seconds(trade: Trade) -> float:
    """CPU seconds of the frame."""
    return trade.frame.timings["cpu_s"]


def equal_time(trades: dict[str, Trade], resolutions: Sequence[int], cache: str) -> int:
    """The largest resolution whose frame is no slower than the cached one; else the smallest."""
    within = [r for r in resolutions if seconds(trades[_map(r)]) <= seconds(trades[cache])]
    return max(within, default=min(resolutions))


def _view_rows(
    view: str, trades: dict[str, Trade], resolutions: Sequence[int], quick: bool
) -> list[Row]:
    rows = [
        Row(
            f"{view}, {name}: rel_l1",
            trade.rel_l1,
            note=f"{seconds(trade):.2f} CPU s, SSIM {trade.ssim:.3f}; "
            + ", ".join(f"{g} {trade.group_rel_l1(g):.4f}" for g in trade.groups),
        )
        for name, trade in trades.items()
    ]
    first, last = trades[_map(resolutions[0])], trades[_map(resolutions[-1])]
    rows.append(
        Row(
            f"{view}: rel_l1 with the smallest map over the largest",
            first.rel_l1 / last.rel_l1,
            band=bands.MAPS_IMPROVE,
        )
    )
    for preset in ("default", "paper"):
        rows += _preset_rows(view, preset, trades, resolutions, quick)
    return rows


def _preset_rows(
    view: str, preset: str, trades: dict[str, Trade], resolutions: Sequence[int], quick: bool
) -> Iterator[Row]:
    cache = trades[preset]
    alike = equal_time(trades, resolutions, preset)
    other = trades[_map(alike)]
    slower = "" if seconds(other) <= seconds(cache) else ", though it takes longer"
    close = view == "close-up" and preset == "default"
    yield Row(
        f"{view}, {preset}: rel_l1 at equal time, map over cache",
        other.rel_l1 / cache.rel_l1,
        band=bands.MAPS_WORSE_CLOSE_UP if close and not quick else None,
        note=f"map of {alike}{slower}: {other.rel_l1:.4f}; cache {cache.rel_l1:.4f}",
    )
    yield Row(
        f"{view}, {preset}: rel_l1, largest map over cache",
        trades[_map(resolutions[-1])].rel_l1 / cache.rel_l1,
        printed="> 1",
        note="the paper's maps of 6000² are worse; at our size a texel is below a pixel, so "
        "no band",
    )
    if printed.MAPS_RESOLUTION in resolutions:
        yield Row(
            f"{view}, {preset}: time with maps of 1024² over the cache's",
            seconds(trades[_map(printed.MAPS_RESOLUTION)]) / seconds(cache),
            printed=printed.MAPS_SLOWER,
            band=bands.MAPS_SLOWER if preset == "default" else None,
        )


def _panels(trades: dict[str, Trade], resolutions: Sequence[int]) -> list[Panel]:
    """The middle of the picture: exact, with the cache, with maps."""
    maps = [_map(r) for r in resolutions[-3:]]
    exact = trades["default"].exact
    shown = {"exact": exact, **{n: trades[n].frame for n in ("default", "paper", *maps)}}
    height, width = exact.image.shape[:2]
    middle = np.s_[height // 4 : 3 * height // 4, width // 4 : 3 * width // 4]
    exposure = tonemap.auto_exposure(exact.image, 95.0)
    return images({name: frame.image[middle] for name, frame in shown.items()}, exposure)


def _trade(found: dict[str, dict[str, Trade]], resolutions: Sequence[int]) -> Panels:
    points = {}
    for view, trades in found.items():
        ways = {"maps": [trades[_map(r)] for r in resolutions]}
        ways |= {preset: [trades[preset]] for preset in ("default", "paper")}
        for name, way in ways.items():
            points[f"{name}, {view}"] = ([seconds(t) for t in way], [t.rel_l1 for t in way])
    return lines(points, x="CPU seconds", y="rel_l1")
