"""C_E from 1e-3 to 1e4: vanishing cells are exact, endless ones still answer in bits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes.pictures import BRIGHT, DIRECT, SHARED, differing, outside, rel_l1, two

#: Point and directional lights alone.
POINTS = vc.Direct(n_area=0, n_environment=0, n_brdf=0)
#: Presets and forms, all light groups through the cache.
FORMS: dict[str, vc.Aqvc] = {
    "default": vc.Aqvc(exact_groups=()),
    "fast": vc.Aqvc(preset="fast", exact_groups=()),
    "paper": vc.Aqvc(preset="paper"),
    "as_printed": vc.Aqvc(preset="as_printed"),
    "pairs, full keys": vc.Aqvc(exact_groups=(), paper=vc.PaperForm(form="pairs", storage="exact")),
    "scale-free": vc.Aqvc(exact_groups=(), paper=vc.PaperForm(scale_free=True)),
}


@FAMILIES.add("cell_sizes", "C_E from 1e-3 to 1e4, presets and forms")
def cell_sizes(full: bool) -> Iterator[Case]:
    for name, cache_ in FORMS.items():
        # Cells of virtual lights that are quantized as surfaces do not depend on C_E
        light = POINTS if cache_.paper.vpl_key == "surface" else SHARED
        for c_e in (1e-3, 1e-9, 1e-30):
            fine = {"visibility": replace(cache_, c_e=c_e)}
            yield Case(
                name=f"{name}, C_E = {c_e:g}: pixels that differ from exact ones",
                measure=partial(two, differing, fine, integrator=light),
                why="a cell that holds one eye point approximates nothing",
            )
        for c_e, integrator in product((1e2, 1e4, 1e9, 1e30), (SHARED, DIRECT)):
            coarse = {"visibility": replace(cache_, c_e=c_e)}
            yield Case(
                name=f"{name}, C_E = {c_e:g}, {type(integrator).__name__}: "
                "pixels not between black and unshadowed",
                measure=partial(two, outside, coarse, BRIGHT, integrator=integrator),
                why="a cache of bits answers visible or occluded",
            )
        yield Case(
            name=f"{name}: error at C_E = 1 over that at C_E = 48",
            measure=partial(_grows, cache_, 3),
            limit=0.35,
            why="cells of 1 pixel instead of 48: measured 0.03 … 0.17, twice that",
        )


def _grows(cache_: vc.Aqvc, seeds: int) -> float:
    def error(c_e: float) -> float:
        mine = {"visibility": replace(cache_, c_e=c_e)}
        error = partial(two, rel_l1, mine, integrator=SHARED, size=(96, 64))
        return sum(error(seed=seed) for seed in range(seeds))

    return error(1.0) / error(48.0)
