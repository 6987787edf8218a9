"""C_E from 1e-3 to 1e4: vanishing cells are exact, endless ones still answer in bits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from typing import Any

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import DIRECT, SHARED, differing, outside, picture, rel_l1

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
        for c_e in (1e-3, 1e-9, 1e-30):
            yield Case(
                name=f"{name}, C_E = {c_e:g}: pixels that differ from exact ones",
                measure=partial(_vanishing, cache_, c_e),
                why="a cell that holds one eye point approximates nothing",
            )
        for c_e in (1e2, 1e4, 1e9, 1e30):
            for integrator in (SHARED, DIRECT):
                yield Case(
                    name=f"{name}, C_E = {c_e:g}, {type(integrator).__name__}: "
                    "pixels not between black and unshadowed",
                    measure=partial(_endless, cache_, c_e, integrator),
                    why="a cache of bits answers visible or occluded",
                )
        yield Case(
            name=f"{name}: error at C_E = 1 over that at C_E = 48",
            measure=partial(_grows, cache_, 3),
            limit=0.35,
            why="cells of 1 pixel instead of 48: measured 0.03 … 0.17, twice that",
        )


@cache
def _frame(integrator: Any, visibility: Any = None) -> vc.Frame:
    given = {"visibility": visibility} if visibility else {}
    return picture(scenes.lit_box(), integrator=integrator, **given)


def _vanishing(cache_: vc.Aqvc, c_e: float) -> float:
    # Virtual lights that are quantized as surfaces share cells whose size does not depend on C_E
    light = POINTS if cache_.paper.vpl_key == "surface" else SHARED
    return differing(_frame(light, replace(cache_, c_e=c_e)), _frame(light))


def _endless(cache_: vc.Aqvc, c_e: float, integrator: Any) -> float:
    frame = _frame(integrator, replace(cache_, c_e=c_e))
    return outside(frame, _frame(integrator, vc.Unoccluded()))


def _grows(cache_: vc.Aqvc, seeds: int) -> float:
    def error(c_e: float) -> float:
        given: dict[str, Any] = {"integrator": SHARED, "size": (96, 64)}
        visibility = replace(cache_, c_e=c_e)
        errors = [
            rel_l1(
                picture(scenes.lit_box(), visibility=visibility, seed=s, **given),
                picture(scenes.lit_box(), seed=s, **given),
            )
            for s in range(seeds)
        ]
        return sum(errors)

    return error(1.0) / error(48.0)
