"""Structures of the smallest size: one slot, one record, one voxel, one texel, one tile."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial
from typing import Any

import numpy as np

import viscache as vc
from viscache.settings.by_name import replaced
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import (
    METHODS,
    SHARED,
    WHITTED,
    bad_pixels,
    differing,
    outside,
    picture,
)

BETWEEN = "a cache of bits lies between black and the picture without shadows"
SAME = "the structure finds hits, its size only time"
BDPT = vc.Bdpt(max_depth=4)


@FAMILIES.add("tables", "tables of one slot, maps of one record, one voxel, one texel")
def tables(full: bool) -> Iterator[Case]:
    pairs = {"form": "pairs", "storage": "table"}

    def quantized(c_e: float, paper: dict[str, Any], **more: Any) -> vc.Aqvc:
        return vc.Aqvc(c_e=c_e, exact_groups=(), paper=vc.PaperForm(**paper), **more)

    yield Case(
        name="a table of one slot, vanishing cells: pixels that differ from exact ones",
        measure=partial(_vanishing, quantized(1e-3, pairs, table_bytes=4)),
        why="a slot holds the last key, and no two keys are equal",
    )
    small: dict[str, Any] = {
        "a table of one slot": quantized(8, pairs, table_bytes=4),
        "digests of one bit": quantized(8, {**pairs, "digest_bits": 1}),
        "one slot, digests of one bit": quantized(8, {**pairs, "digest_bits": 1}, table_bytes=4),
        "rows without room": quantized(8, {}, table_bytes=4),
        "shadow maps of one texel": vc.ShadowMap(resolution=1),
    }
    for name, visibility in small.items():
        for way, integrator in {"direct": None, "virtual lights": WHITTED}.items():
            yield Case(
                name=f"{name}, {way}: pixels not between black and unshadowed",
                measure=partial(_outside, visibility, integrator),
                why=BETWEEN,
            )
    yield Case(
        name="one slot for all connections of Bdpt: pixels not between black and unshadowed",
        measure=partial(_outside, vc.Aqvc(c_e=8, table_bytes=4), BDPT),
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
            measure=partial(_unlike_bsp, rays),
            why=SAME,
        )
    for name, nee in {
        "one voxel": vc.NeePlusPlus(n_voxels=1),
        "one cell of directions": vc.NeePlusPlus(n_directions=1),
        "learnt from one pixel": vc.NeePlusPlus(learn_pixels=1),
    }.items():
        yield Case(
            name=f"NEE++, {name}: pixels that are negative or not finite",
            measure=partial(_bad, nee),
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
            why="a blend of maps is a share of the sky; its integral over an open sky errs by 5e-4",
        )


def _lit(integrator: Any, **given: Any) -> vc.Frame:
    """The lit box; the integrator of `picture` by default."""
    return picture(scenes.lit_box(), **given, **({"integrator": integrator} if integrator else {}))


@cache
def _unshadowed(integrator: Any) -> vc.Frame:
    return _lit(integrator, visibility=vc.Unoccluded())


def _vanishing(visibility: Any) -> float:
    return differing(_lit(SHARED, visibility=visibility), _lit(SHARED))


def _outside(visibility: Any, integrator: Any) -> float:
    return outside(_lit(integrator, visibility=visibility), _unshadowed(integrator))


def _unlike_bsp(rays: Any) -> float:
    return differing(_lit(None, rays=rays), _lit(None, rays=vc.Bsp()))


def _bad(nee: vc.NeePlusPlus) -> float:
    return bad_pixels(_lit(WHITTED, visibility=nee))


def _energy(nee: vc.NeePlusPlus) -> float:
    """How far the energy of corrected frames is from that of exact ones."""
    found, exact = (
        sum(_lit(WHITTED, seed=s, **how).image.astype(float).sum() for s in range(3))
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
    cache_ = vc.Aqvc(c_e=8, exact_groups=())
    found = 0.0
    for seed in (1, 2):
        frame = picture(scenes.lit_box(), visibility=cache_, keep=table, seed=seed)
        bright = picture(scenes.lit_box(), visibility=vc.Unoccluded(), seed=seed)
        found += outside(frame, bright)
    return found
