"""The quantized cache beside Next Event Estimation++, its closest successor."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from statistics import median
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.settings.visibility import Visibility
from viscache.sweeps.exact_frames import ExactFrames
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import lines as drawn
from viscache_lab.figures.aqvc_runs import Shot, Trade
from viscache_lab.figures.aqvc_setups import SETUPS
from viscache_lab.figures.bands import aqvc as bands

SIZE, QUICK_SIZE = (320, 200), (96, 60)
#: C_E of the cache: points of its curve of error over rays.
C_E = (4.0, 8.0, 12.0, 24.0)
#: Exponent of the roulette's probability: q = p^exponent for a visibility p.
EXPONENTS = (0.25, 0.5, 1.0)
#: Frames per method for the variance, and samples per pixel of the reference.
SEEDS, REFERENCE_SPP = 5, 64


@FIGURES.add("aqvc-nee", "rays and error beside Next Event Estimation++", sized=True)
def comparison(trial: Trial) -> None:
    """Rays and error at equal samples; variance against a converged picture."""
    table, lines = [], {}
    for name, shot in shots(trial.quick, trial.size).items():
        found = shot.trades(methods(trial.quick), trial.quick)
        table += [
            {"scene": name, "method": m, **t.record(), "rays_left": rays_left(t)}
            for m, t in found.items()
        ]
        trial.rows += _same_rows(name, found, trial.quick)
        for kind in ("NEE++", "AQVC"):
            mine = [t for m, t in found.items() if m.startswith(kind)]
            lines[f"{kind}, {name}"] = ([rays_left(t) for t in mine], [t.rel_l1 for t in mine])
        if not shot.integrator.n_vpls:  # type: ignore[union-attr]
            trial.rows += _noise_rows(name, noise(shot, trial.quick, trial.exact_frames()))
    trial.draw("aqvc-nee.png", drawn(lines, x="rays per query", y="rel_l1"))
    trial.csv("aqvc-nee.csv", table)
    trial.notes.append(
        "NEE++ is ours, after the paper's idea: Russian roulette alone, its map learnt before the "
        "frame. Its error is noise and leaves with more samples; the cache's is partly bias."
    )


def shots(quick: bool, size: tuple[int, int] | None = None) -> dict[str, Shot]:
    """Mostly hidden lamps, many lights in one room, an area light, fine geometry."""
    pixels = size or (QUICK_SIZE if quick else SIZE)
    setups = {name: SETUPS[name].shot(quick, pixels) for name in ("delta", "conference")}
    hairball = SETUPS["hairball"].shot(quick, pixels)
    sky = replace(SETUPS["hairball"].integrator(quick), n_vpls=0)
    room = vc.Whitted(n_vpls=32 if quick else 256, n_area=0)
    return setups | {
        "hairball": replace(hairball, integrator=sky),
        "room": Shot(scene=vc.scenes.room(), integrator=room, size=pixels),
    }


def methods(quick: bool) -> dict[str, Visibility]:
    """Settings by name."""
    plain = vc.NeePlusPlus(n_voxels=8, learn_pixels=512) if quick else vc.NeePlusPlus()
    roulette = {f"NEE++ p^{e:g}": replace(plain, exponent=e) for e in EXPONENTS}
    return {**roulette, **{f"AQVC C_E {c_e:g}": vc.Aqvc(c_e=c_e, exact_groups=()) for c_e in C_E}}


def rays_left(trade: Trade) -> float:
    """Share of the connections that cost a ray, including learning."""
    return 1 / trade.ray_reduction


def discarded(frame: vc.Frame) -> float:
    """Share of the connections that the roulette skipped."""
    return float(frame.counters["discarded"] / frame.counters["queries"])


def _same_rows(name: str, found: Mapping[str, Trade], quick: bool) -> list[Row]:
    full, cache = found["NEE++ p^1"], found["AQVC C_E 12"]
    occluded = full.exact.counters["occluded"] / full.exact.counters["queries"]
    energy = full.frame.image.mean(dtype=float) / full.exact.image.mean(dtype=float) - 1
    rows = [
        Row(
            f"{name}, NEE++: visibility tests discarded",
            discarded(full.frame),
            printed="up to 0.8",
            band=bands.NEE_DISCARDED if name == "delta" and not quick else None,
            note=f"{occluded:.0%} of them are blocked",
        ),
        Row(
            f"{name}, NEE++: discarded over blocked",
            discarded(full.frame) / occluded,
            band=bands.NEE_WITHIN_BLOCKED,
        ),
        Row(f"{name}, NEE++: energy against exact", energy, band=bands.NEE_ENERGY),
        Row(
            f"{name}: rays of NEE++ over those of the cache, C_E 12",
            rays_left(full) / rays_left(cache),
            band=bands.NEE_MORE_RAYS,
        ),
    ]
    return rows + [
        Row(
            f"{name}, {method}: rel_l1",
            trade.rel_l1,
            note=f"{rays_left(trade):.1%} of the rays, speed-up {trade.speedup:.2f}",
        )
        for method, trade in found.items()
    ]


@dataclass(frozen=True, slots=True)
class Noise:
    """Mean squared error of reflected light against a converged picture, and CPU seconds."""

    mse: float
    cpu_s: float

    def at_equal_time(self, other: Noise) -> float:
        """This error over the other's, if more samples per pixel made both take the same time."""
        return self.mse * self.cpu_s / (other.mse * other.cpu_s)


def noise(shot: Shot, quick: bool, exact: ExactFrames) -> dict[str, Noise]:
    """Mean squared error and CPU seconds of each method, over independent frames."""
    spp = REFERENCE_SPP // 4 if quick else REFERENCE_SPP
    reference = _double(
        exact(shot.scene, shot.integrator, size=shot.size, spp=spp, seed=1000, camera=shot.camera)
    )
    chosen: dict[str, Visibility] = {"exact": vc.Exact(engine="packets"), **methods(quick)}
    seeds = range(2 if quick else SEEDS)
    frames = {n: [shot.frame(v, seed=s) for s in seeds] for n, v in chosen.items()}
    return {
        name: Noise(
            float(np.mean([np.mean((_double(f) - reference) ** 2) for f in made])),
            median(f.timings["cpu_s"] for f in made),
        )
        for name, made in frames.items()
    }


def _noise_rows(name: str, found: Mapping[str, Noise]) -> Iterator[Row]:
    exact = found["exact"]
    for method, mine in found.items():
        if method == "exact":
            continue
        full = method == "NEE++ p^1"
        yield Row(
            f"{name}, {method}: squared error at equal samples over the exact frame's",
            mine.mse / exact.mse,
            band=bands.NEE_ADDS_NOISE if full else None,
            note=f"at equal time {mine.at_equal_time(exact):.2f}",
        )


def _double(frame: vc.Frame) -> npt.NDArray[Any]:
    """Reflected light only, because directly visible emitters have noise of their own."""
    return np.asarray(frame.image, np.float64) - frame.layers["emitted"]
