"""`viscache bench picks` and `skies`: error over time of frames of many seeds.

All frames have lights and eye samples of their own. Without bias, the error of the mean of k frames
is the k-th part, and gains hold for any number of passes; for the cache, for one frame alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.scenes.sources import made_by_others
from viscache_lab.bench.errors import NOTE, error_over_time
from viscache_lab.experiment import BENCHES, Trial


@dataclass(frozen=True, slots=True)
class Picks:
    """A picture of lights that all eye points share."""

    name: str
    scene: str
    goals: Mapping[int, float]  # least gain by number of picks
    integrator: vc.Direct | vc.Whitted
    picks: tuple[int, ...] = (8, 16, 64)
    size: tuple[int, int] = (192, 120)
    spp: int = 1
    seeds: int = 12
    references: int = 24


# Of the lights that all eye points share alone: samples of their own have noise that no way changes
VPLS = vc.Whitted(n_vpls=1024, n_area=0, n_environment=0, n_brdf=0)
LAMPS = vc.Direct(n_area=0, n_environment=0, n_brdf=0)
ROOM, SMALL_ROOM = "room?triangles=200000", "room?triangles=3000"
PICKS = (
    Picks("room", ROOM, {8: 3, 16: 3, 64: 2}, VPLS),
    Picks("apartment", "apartment", {16: 3}, VPLS),
    Picks("conference", "conference", {16: 3}, VPLS),
    Picks("living-room", "living-room/scene.xml", {16: 1}, VPLS),
    Picks("sponza", "sponza-dabrovic/scene.xml", {16: 1}, VPLS),
    Picks("room, 24 lamps", ROOM, {4: 1}, LAMPS, (2, 4, 8), spp=4),
)
FEW: dict[str, Any] = {"size": (48, 32), "seeds": 8, "references": 8}
QUICK_PICKS = (
    Picks("room, 48×32", SMALL_ROOM, {}, replace(VPLS, n_vpls=100), (8,), **FEW),
    Picks("room, 24 lamps, 48×32", SMALL_ROOM, {}, LAMPS, (4,), **FEW),
)


@BENCHES.add(
    "picks",
    "error over time: exact, cached, or a few lights picked by each eye point",
    cases=PICKS,
    quick_cases=QUICK_PICKS,
    note=NOTE.format("exact"),
)
def picks(trial: Trial, case: Picks, scene: vc.Scene) -> None:
    """MSE · CPU time of exact frames over that of picks, of cached frames, and of both."""
    scene.caster()
    shot = vc.Shot(scene, case.integrator, size=case.size, spp=case.spp)
    cached = {"visibility": vc.Aqvc()}
    corrected = {**cached, "use": "correct"}
    most = case.picks[-1]
    picked = {n: {"integrator": replace(case.integrator, pick=n)} for n in case.picks}
    ways: dict[str, dict[str, Any]] = {
        "exact": {},
        "cache": cached,
        "corrected": corrected,
        **{f"{n} picks": way for n, way in picked.items()},
        f"{most} picks, corrected": {**picked[most], **corrected},
    }
    error_over_time(
        trial,
        case.name,
        {name: partial(_frame, shot.with_(**way)) for name, way in ways.items()},
        partial(_frame, shot),
        seeds=case.seeds,
        references=case.references,
        goals={f"{n} picks": goal for n, goal in case.goals.items()},
        biased=("cache",),
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class Sky:
    """A scene, and a map of $VISCACHE_SCENES, or the radiance of a constant sky."""

    scene: str
    sky: str | float
    size: tuple[int, int] = (192, 192)
    seeds: int = 16
    references: int = 16
    reference_spp: int = 32

    @property
    def name(self) -> str:
        return f"{self.scene.partition('/')[0]} under {self.sky}"


SKIES = (
    Sky(scene="sponza-dabrovic/scene.xml", sky="hdr/kloppenheim_05_1k.hdr"),
    Sky(scene="sanmiguel-part/scene.xml", sky="hdr/potsdamer_platz_1k.hdr"),
    Sky(scene="sanmiguel-part/scene.xml", sky="hdr/st_peters_square_night_1k.hdr"),
    Sky(scene="classroom/scene.xml", sky="hdr/kloppenheim_05_1k.hdr"),
    Sky(scene="living-room/scene.xml", sky="hdr/venice_sunset_1k.hdr"),
)
QUICK_SKY = Sky(
    scene="cube_on_plane", sky=1.0, size=(32, 24), seeds=4, references=4, reference_spp=16
)
OWN = "4 + 4 own samples"
SETS = vc.Direct(n_area=0, environment="shared", n_environment=512, interleave=16)
#: Integrator and samples per pixel; the sets are those of `viscache bench peers`, chosen elsewhere.
WAYS = {
    OWN: (vc.Direct(n_area=0, n_environment=4, n_brdf=4), 4),
    "1 + 1 own samples": (vc.Direct(n_area=0, n_environment=1, n_brdf=1), 16),
    "512 directions in 16 sets": (SETS, 16),
    "the sets, without samples of lobes": (replace(SETS, n_brdf=0), 16),
}
REFERENCE = vc.Direct(n_area=0, n_environment=8, n_brdf=8)


@BENCHES.add(
    "skies",
    "error over time under real skies: own samples, or directions in sets",
    cases=SKIES,
    quick_cases=(QUICK_SKY,),
    note=NOTE.format(OWN),
)
def skies(trial: Trial, case: Sky, scene: vc.Scene) -> None:
    """MSE · CPU time of own samples over that of the other ways."""
    sky = made_by_others(case.sky) if isinstance(case.sky, str) else case.sky
    if sky is None:
        trial.skip(case.name, "VISCACHE_SCENES has no such file")
        return
    shot = vc.Shot(scene.with_environment(sky), REFERENCE, size=case.size, spp=case.reference_spp)
    frame = partial(_frame, layer="environment")
    error_over_time(
        trial,
        case.name,
        {n: partial(frame, shot.with_(integrator=i, spp=spp)) for n, (i, spp) in WAYS.items()},
        partial(frame, shot),
        seeds=case.seeds,
        references=case.references,
    )


def _frame(shot: vc.Shot, seed: int, layer: str = "") -> tuple[npt.NDArray[Any], float]:
    """Light on surfaces, without the noise of lamps' edges, and CPU seconds of the whole frame."""
    frame = shot.with_(seed=seed, threads=1).render()
    light = frame.layers[layer] if layer else frame.image - frame.layers["emitted"].astype(float)
    return np.asarray(light, np.float64), float(frame.timings["cpu_s"])
