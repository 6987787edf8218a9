"""Structures of the smallest size: one slot, one record, one voxel, one texel, one tile."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

import viscache as vc
from viscache.settings.by_name import replaced
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import (
    BETWEEN,
    BRIGHT,
    METHODS,
    SHARED,
    WHITTED,
    bad_pixels,
    differing,
    lit,
    one,
    outside,
    picture,
    two,
)

SKY = "a blend of maps is a share of the sky; its integral over an open sky errs by 5e-4"


@FAMILIES.add("tables", "tables of one slot, maps of one record, one voxel, one texel")
def tables(full: bool) -> Iterator[Case]:
    pairs = {"form": "pairs", "storage": "table"}

    def quantized(c_e: float, paper: dict[str, Any], **more: Any) -> vc.Aqvc:
        return vc.Aqvc(c_e=c_e, exact_groups=(), paper=vc.PaperForm(**paper), **more)

    yield Case(
        name="a table of one slot, vanishing cells: pixels that differ from exact ones",
        measure=partial(
            two,
            differing,
            {"visibility": quantized(1e-3, pairs, table_bytes=4)},
            integrator=SHARED,
        ),
        why="a slot holds the last key, and no two keys are equal",
    )
    lights = {"direct": {}, "virtual lights": {"integrator": WHITTED}}
    small: dict[str, tuple[Any, dict[str, dict[str, Any]]]] = {
        "a table of one slot": (quantized(8, pairs, table_bytes=4), lights),
        "digests of one bit": (quantized(8, {**pairs, "digest_bits": 1}), lights),
        "one slot, digests of one bit": (
            quantized(8, {**pairs, "digest_bits": 1}, table_bytes=4),
            lights,
        ),
        "rows without room": (quantized(8, {}, table_bytes=4), lights),
        "shadow maps of one texel": (vc.ShadowMap(resolution=1), lights),
        "one slot for all connections of Bdpt": (
            vc.Aqvc(c_e=8, table_bytes=4),
            {"": {"integrator": vc.Bdpt(max_depth=4)}},
        ),
    }
    for name, (visibility, ways) in small.items():
        for way, light in ways.items():
            yield Case(
                name=f"{name}{', ' if way else ''}{way}: pixels not between black and unshadowed",
                measure=partial(two, outside, {"visibility": visibility}, BRIGHT, **light),
                why=BETWEEN,
            )
    yield Case(
        name="one slot kept over frames: pixels not between black and unshadowed",
        measure=_kept,
        why=BETWEEN,
    )
    for name, rays in {
        "a field of one direction and one tile": vc.Vlf(n_directions=1, n_tiles=1),
        "a field of one tile per direction": vc.Vlf(n_directions=33, n_tiles=1),
        "a tree of depth 1": vc.Bsp(max_depth=1),
        "cells of one triangle": vc.Bsp(leaf_size=1),
    }.items():
        yield Case(
            name=f"{name}: pixels that differ from a BSP's",
            measure=partial(two, differing, {"rays": rays}, {"rays": vc.Bsp()}),
            why="the structure finds hits, its size only time",
        )
    for name, nee in {
        "one voxel": vc.NeePlusPlus(n_voxels=1),
        "one cell of directions": vc.NeePlusPlus(n_directions=1),
        "learnt from one pixel": vc.NeePlusPlus(learn_pixels=1),
    }.items():
        yield Case(
            name=f"NEE++, {name}: pixels that are negative or not finite",
            measure=partial(one, bad_pixels, integrator=WHITTED, visibility=nee),
            why="weights are at most 1 / min_probability",
        )
        yield Case(
            name=f"NEE++, {name}, corrected: energy against exact",
            measure=partial(_energy, nee),
            limit=5e-4,
            why="no bias: the noise of three frames is below; measured 4e-5, twelve times that",
        )
    for name, values in {
        "one start-up record": {"n_startup": 1},
        "at most one record": {"n_startup": 1, "max_records": 1},
        "one blended record": {"n_startup": 64, "n_best": 1, "m_nearest": 1},
    }.items():
        yield Case(
            name=f"maps, {name}: light above what the open sky brings",
            measure=partial(sky_excess, replaced(vc.VisMaps(), values, "visibility")),
            limit=1e-3,
            why=SKY,
        )


def _energy(nee: vc.NeePlusPlus) -> float:
    """How far the energy of corrected frames is from that of exact ones."""
    found, exact = (
        sum(lit(integrator=WHITTED, seed=s, **how).image.astype(float).sum() for s in range(3))
        for how in ({"visibility": nee, "use": "correct"}, {})
    )
    return float(abs(found / exact - 1))


def sky_excess(visibility: vc.VisMaps) -> float:
    """The brightest pixel under a sky of radiance 1 over the albedo of all surfaces, minus 1."""
    scene = scenes.with_parts(scenes.floor(), scenes.table(), lights=())
    frame = picture(scene, METHODS["visibility maps"], visibility=visibility, env=1.0)
    light = np.asarray(frame.layers["environment"], float)
    return float(max(light.max() / 0.5 - 1, -light.min()))


def _kept() -> float:
    table = vc.AqvcTable(table_bytes=4)
    cached = vc.Aqvc(c_e=8, exact_groups=())
    frames = [picture(scenes.lit_box(), visibility=cached, keep=table, seed=s) for s in (1, 2)]
    return sum(outside(f, lit(seed=s, **BRIGHT)) for s, f in enumerate(frames, 1))
