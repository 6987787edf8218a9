"""Every parameter at both ends of its range, as the tables of parameters have them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import viscache as vc
from viscache.settings.aqvc import ROWS as AQVC_ROWS
from viscache.settings.by_name import replaced
from viscache.settings.maps import ROWS as MAP_ROWS
from viscache.settings.parameter_rows import ParameterRows
from viscache.settings.rays import BSP_ROWS, FIELD_ROWS
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes.families.tables import SKY, sky_excess
from viscache_lab.extremes.pictures import (
    BETWEEN,
    BRIGHT,
    SHARED,
    bad_pixels,
    differing,
    one,
    outside,
    two,
)

#: Address space of the process: a structure that would need more must be refused.
MOST_BYTES = 6 << 30
#: Where a range is open: as far as anyone may go.
OPEN = 1e12
#: More than any of these structures takes here; a table of as many bytes is made at once.
ENOUGH_BYTES = 1 << 28
SIZE = (24, 16)

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
        given: dict[str, Any] = {"size": SIZE, "integrator": SHARED}
        if settings.paper.storage in ("shared",):
            given["integrator"] = vc.Bdpt(max_depth=3)
        return two(outside, {"visibility": settings}, BRIGHT, **given)
    if approximate:
        return one(bad_pixels, rays=settings, size=SIZE)
    return two(differing, {"rays": settings}, {"rays": table.settings}, size=SIZE)
