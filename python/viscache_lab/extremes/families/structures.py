"""Structures of every size: one slot, one record, one voxel; maps; both ends of every parameter."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

import viscache as vc
from viscache.settings.aqvc import ROWS as AQVC_ROWS
from viscache.settings.by_name import replaced
from viscache.settings.maps import ROWS as MAP_ROWS
from viscache.settings.parameter_rows import ParameterRows
from viscache.settings.rays import BSP_ROWS, FIELD_ROWS
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import (
    BETWEEN,
    BRIGHT,
    METHODS,
    SHARED,
    SIZE,
    WHITTED,
    bad_pixels,
    differing,
    lit,
    one,
    outside,
    picture,
    rel_l1,
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
            two, differing, {"visibility": quantized(1e-3, pairs, table_bytes=4)}, integrator=SHARED
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


MAPS = METHODS["visibility maps"]


@FAMILIES.add("map_sizes", "visibility maps of 2^M × 2^M cells, M = 4 … 7")
def map_sizes(full: bool) -> Iterator[Case]:
    row = MAP_ROWS.by_name["m"]
    for m in range(int(row["low"]), int(row["high"]) + 1):
        maps = vc.VisMaps(n_startup=400 if full else 64, m=m)
        yield Case(
            name=f"M = {m}, maps in place of rays: rel_l1 against 1024 rays per pixel",
            measure=partial(_error, maps, "replace"),
            limit=0.025,
            why="blends of maps some pixels away: measured 0.0104 … 0.0108, twice that",
        )
        yield Case(
            name=f"M = {m}, maps as control variate: energy against 1024 rays per pixel",
            measure=partial(_map_energy, maps),
            limit=3e-3,
            why="no bias; noise of 16 samples per pixel: measured 8e-4 at most, 4 times that",
        )
        yield Case(
            name=f"M = {m}: light above what the open sky brings",
            measure=partial(sky_excess, maps),
            limit=1e-3,
            why=SKY,
        )
        yield Case(
            name=f"M = {m}, saved and loaded: pixels that differ",
            measure=partial(_reloaded, m),
            why="a file holds every bit of the records",
        )


@cache
def _scene() -> vc.Scene:
    return scenes.with_parts(scenes.floor(), scenes.table(), lights=()).with_environment(1.0)


@cache
def _exact() -> vc.Frame:
    return picture(_scene(), integrator=vc.Direct(environment="product", n_environment=1024))


def _error(maps: vc.VisMaps, use: str) -> float:
    return rel_l1(picture(_scene(), MAPS, visibility=maps, use=use, env=None), _exact())


def _map_energy(maps: vc.VisMaps) -> float:
    frame = picture(
        _scene(),
        integrator=vc.Direct(environment="product", n_environment=16),
        visibility=maps,
        use="correct",
    )
    return float(abs(frame.image.astype(float).sum() / _exact().image.astype(float).sum() - 1))


def _reloaded(m: int) -> float:
    scene, settings = _scene(), vc.MapSettings(n_startup=64, m=m)
    made = vc.VisibilityMapCache(scene, settings)
    made.update(size=SIZE, threads=1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "maps"
        made.save(path)
        again = vc.VisibilityMapCache.load(path, scene)
    frames = [
        picture(scene, MAPS, visibility=vc.VisMaps(cache=kept), env=None).image
        for kept in (made, again)
    ]
    return float((np.asarray(frames[0]) != np.asarray(frames[1])).any(axis=-1).sum())


#: Address space of the process: a structure that would need more must be refused.
MOST_BYTES = 6 << 30
#: Where a range is open: as far as anyone may go.
OPEN = 1e12
#: More than any of these structures takes here; a table of as many bytes is made at once.
ENOUGH_BYTES = 1 << 28
SMALL = (24, 16)

SAME = "a structure of rays finds hits, its parameters only time"


@dataclass(frozen=True, slots=True)
class Table:
    """A table of parameters, and what must hold at the ends of each."""

    name: str
    settings: Any
    rows: ParameterRows
    why: str
    limit: float = 0.0


TABLES = (
    Table("Aqvc", vc.Aqvc(exact_groups=(), c_e=8.0), AQVC_ROWS, BETWEEN),
    Table(
        "Aqvc, pairs",
        vc.Aqvc(exact_groups=(), c_e=8.0, paper=vc.PaperForm(form="pairs")),
        AQVC_ROWS,
        BETWEEN,
    ),
    Table("VisMaps", vc.VisMaps(n_startup=50), MAP_ROWS, SKY, 1e-3),
    Table("Vlf", vc.Vlf(n_directions=33, n_tiles=16), FIELD_ROWS, SAME),
    Table("Bsp", vc.Bsp(), BSP_ROWS, SAME),
)
#: What another parameter must be at the end of one.
BESIDE: dict[tuple[str, float], dict[str, Any]] = {("m_nearest", 1): {"n_best": 1}}
#: Where 0 is excluded: smaller numbers vanish among others of single precision.
LEAST = 1e-30
#: Ends that would be days of work, not numbers at risk: so many instead.
WORK = {"n_startup": 2000, "n_tiles": 512}
#: Frames of these are not those of other values: other rays, or a leaky test of triangles.
APPROXIMATE = {("Vlf", "snap", True), ("Vlf", "kernel", "wald"), ("Bsp", "kernel", "wald")}


@FAMILIES.add(
    "parameters",
    "every parameter of every cache and structure at both ends of its range",
    most_bytes=MOST_BYTES,
)
def parameters(full: bool) -> Iterator[Case]:
    for table in TABLES:
        for name, row in table.rows.by_name.items():
            for value in ends(row):
                yield Case(
                    name=f"{table.name}, {name} = {value!r}: {_what(table)}",
                    measure=partial(_measured, table, name, value),
                    limit=table.limit,
                    why=table.why,
                )


def _what(table: Table) -> str:
    if table.rows is MAP_ROWS:
        return "light above what the open sky brings"
    if table.rows is AQVC_ROWS:
        return "pixels not between black and unshadowed"
    return "pixels that differ from the default's"


def ends(row: dict[str, Any]) -> list[Any]:
    """Both ends of a parameter's range, or all values of a closed set."""
    kind = row["kind"]
    if kind == "bool":
        return [False, True]
    if kind.startswith("{"):
        return [word.strip('" ') for word in kind.strip("{}").split(",")]
    whole = kind.startswith("int")
    if not whole and not kind.startswith("float"):
        return []  # tables by light group; their values are those of other rows
    low = row["low"] if math.isfinite(row["low"]) else -OPEN
    high = row["high"] if math.isfinite(row["high"]) else OPEN
    if whole:
        most = min(high, (1 << 31) - 1 if not math.isfinite(row["high"]) else high)
        if row["name"].endswith("_bytes"):
            most = ENOUGH_BYTES
        most = WORK.get(row["name"], most)
        return [int(low) + bool(row["above"]), int(most)]
    return [low + LEAST if row["above"] else low, high]


def _measured(table: Table, name: str, value: Any) -> float:
    """What must hold; 0 where the settings or the structure are refused by name."""
    beside = next((b for (n, v), b in BESIDE.items() if n == name and v == value), {})
    try:
        settings = replaced(table.settings, {name: value, **beside}, table.name)
        return _value(table, settings, (table.name, name, value) in APPROXIMATE)
    except MemoryError:
        return 0.0  # a budget that is too small for the structure, or a structure too large
    except ValueError as error:
        if name in str(error):
            return 0.0
        raise


def _value(table: Table, settings: Any, approximate: bool) -> float:
    if table.rows is MAP_ROWS:
        return 0.0 if settings.criterion == "ambient" else sky_excess(settings)
    if table.rows is AQVC_ROWS:
        given: dict[str, Any] = {"size": SMALL, "integrator": SHARED}
        if settings.paper.storage in ("shared",):
            given["integrator"] = vc.Bdpt(max_depth=3)
        return two(outside, {"visibility": settings}, BRIGHT, **given)
    if approximate:
        return one(bad_pixels, rays=settings, size=SMALL)
    return two(differing, {"rays": settings}, {"rays": table.settings}, size=SMALL)
