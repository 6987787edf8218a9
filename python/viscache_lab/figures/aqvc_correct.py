"""Answers as control variates: noise over rays, with the cache and without any shadows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import viscache as vc
from viscache.settings.visibility import Visibility
from viscache_lab.experiment import FIGURES, Trial
from viscache_lab.experiment.amounts import student_t
from viscache_lab.experiment.drawing import lines as panels_of
from viscache_lab.figures.aqvc_runs import Shot
from viscache_lab.figures.aqvc_setups import SETUPS
from viscache_lab.figures.bands import aqvc as bands

SIZE, QUICK_SIZE = (192, 120), (64, 40)
#: q, the share of the queries that are also traced; None: no correction.
SHARES = (None, 0.05, 0.1, 0.25, 0.5)
#: The share whose rows have bands.
SHOWN = 0.1
METHODS: dict[str, Visibility] = {
    "AQVC C_E 12": vc.Aqvc(exact_groups=()),
    "no shadows": vc.Unoccluded(),
}


@dataclass(frozen=True, slots=True)
class Corrected:
    """Frames of one method and share against exact frames of the same samples."""

    rays_left: float
    """Rays per query."""
    noise: float
    """Root mean squared error of a pixel, over the mean of the picture."""
    energy: float
    """Relative error of the energy, over all frames."""
    z: float
    """The energy error in standard errors."""


@FIGURES.add(
    "aqvc-correct", 'use="correct": noise over rays, with the cache and without shadows', sized=True
)
def correction(trial: Trial) -> None:
    """Both are unbiased; a cache pays off if its corrections have less noise."""
    table, lines = [], {}
    for scene, shot in shots(trial.quick, trial.size).items():
        found = corrected(shot, seeds=6 if trial.quick else 16)
        for method in METHODS:
            mine = {share: found[method, share] for share in SHARES}
            drawn = [c for share, c in mine.items() if share]
            lines[f"{method}, {scene}"] = ([c.rays_left for c in drawn], [c.noise for c in drawn])
            table += [
                {
                    "scene": scene,
                    "method": method,
                    "share": share or 0,
                    "rays_left": c.rays_left,
                    "noise": c.noise,
                    "energy": c.energy,
                    "z": c.z,
                }
                for share, c in mine.items()
            ]
            plain, shown = mine[None], mine[SHOWN]
            note = f"{shown.energy:+.2%} of the light, {plain.energy:+.2%} without corrections"
            trial.row(
                f"{scene}, {method}: z of the energy", shown.z, band=bands.UNBIASED, note=note
            )
        cache, none = (found[method, SHOWN] for method in METHODS)
        ratio = (cache.noise / none.noise) ** 2
        note = f"rays over queries {cache.rays_left:.3f} and {none.rays_left:.3f}"
        trial.row(
            f"{scene}: squared noise, cache over no shadows, q = {SHOWN:g}",
            ratio,
            band=bands.CACHE_IS_THE_BETTER_VARIATE,
            note=note,
        )
    trial.draw("aqvc-correct.png", panels_of(lines, x="rays over queries", y="noise"))
    trial.csv("aqvc-correct.csv", table)


def shots(quick: bool, size: tuple[int, int] | None) -> dict[str, Shot]:
    """Many lights in one room, mostly hidden lamps, an area light."""
    pixels = size or (QUICK_SIZE if quick else SIZE)
    room = vc.Whitted(n_vpls=32 if quick else 256, n_area=0)
    lit = {"room": Shot(scene=vc.scenes.room(), integrator=room, size=pixels)}
    return lit | {name: SETUPS[name].shot(quick, pixels) for name in ("delta", "conference")}


def corrected(shot: Shot, seeds: int) -> dict[tuple[str, float | None], Corrected]:
    """Every method with every share, from frames of several seeds."""
    exact = [np.asarray(shot.frame(vc.Exact(), seed=s).image, np.float64) for s in range(seeds)]
    light = np.array([image.mean() for image in exact])
    found = {}
    for method, visibility in METHODS.items():
        for share in SHARES:
            use = None if share is None else vc.Correct(share=share)
            frames = [
                vc.render(
                    shot.scene,
                    shot.integrator,
                    visibility=visibility,
                    use=use,
                    seed=s,
                    size=shot.size,
                    spp=shot.spp,
                    camera=shot.camera,
                )
                for s in range(seeds)
            ]
            off = [f.image - image for f, image in zip(frames, exact, strict=True)]
            sums = np.array([o.mean() for o in off])
            rays, queries = (sum(f.counters[n] for f in frames) for n in ("rays", "queries"))
            found[method, share] = Corrected(
                rays_left=rays / queries,
                noise=float(np.sqrt(np.mean(np.square(off))) / light.mean()),
                energy=float(sums.sum() / light.sum()),
                z=student_t(sums),
            )
    return found
