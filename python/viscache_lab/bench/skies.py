"""`viscache bench skies`: error over time under real skies, own samples against sets of directions.

All ways are exact and unbiased. The converged picture is the mean of frames of each point's own
samples with other seeds; its noise is taken out of the errors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.scenes.sources import made_by_others
from viscache_lab.bench.errors import NOTE, error_over_time
from viscache_lab.experiment import BENCHES, Trial

Array = npt.NDArray[Any]

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


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
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


CASES = (
    Case(scene="sponza-dabrovic/scene.xml", sky="hdr/kloppenheim_05_1k.hdr"),
    Case(scene="sanmiguel-part/scene.xml", sky="hdr/potsdamer_platz_1k.hdr"),
    Case(scene="sanmiguel-part/scene.xml", sky="hdr/st_peters_square_night_1k.hdr"),
    Case(scene="classroom/scene.xml", sky="hdr/kloppenheim_05_1k.hdr"),
    Case(scene="living-room/scene.xml", sky="hdr/venice_sunset_1k.hdr"),
)
QUICK = (
    Case(scene="cube_on_plane", sky=1.0, size=(32, 24), seeds=4, references=4, reference_spp=16),
)


@BENCHES.add(
    "skies",
    "error over time under real skies: own samples, or directions in sets",
    cases=CASES,
    quick_cases=QUICK,
    note=NOTE.format(OWN),
)
def skies(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """MSE · CPU time of own samples over that of the other ways."""
    sky = made_by_others(case.sky) if isinstance(case.sky, str) else case.sky
    if sky is None:
        trial.skip(case.name, "VISCACHE_SCENES has no such file")
        return
    render = partial(_render, case, scene.with_environment(sky))
    error_over_time(
        trial,
        case.name,
        {way: partial(render, integrator=light, spp=spp) for way, (light, spp) in WAYS.items()},
        partial(render, integrator=REFERENCE, spp=case.reference_spp),
        seeds=case.seeds,
        references=case.references,
    )


def _render(
    case: Case, scene: vc.Scene, seed: int, integrator: vc.Direct, spp: int
) -> tuple[Array, float]:
    """Light of the sky on surfaces, and CPU seconds of the whole frame."""
    frame = vc.render(scene, integrator, size=case.size, spp=spp, seed=seed, threads=1)
    return np.asarray(frame.layers["environment"], np.float64), float(frame.timings["cpu_s"])
