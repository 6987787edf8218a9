"""The map of where numbers hold: every method's error over scale, offset and C_E."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from itertools import takewhile
from typing import Any

from viscache_lab.extremes import scenes
from viscache_lab.extremes.families.cells import FORMS
from viscache_lab.extremes.families.moves import shift
from viscache_lab.extremes.moved import moved
from viscache_lab.extremes.pictures import METHODS, SHARED, Method, lit, picture, rel_l1, two

#: What is varied, in words, and the values of a quick and of a full run.
AXES: dict[str, tuple[str, list[float], list[float]]] = {
    "scale": (
        "unit of length",
        [1e-12, 1e-9, 1e-6, 1.0, 1e6, 1e9, 1e12],
        [10.0**k for k in (-15, -12, -10, -9, -8, -7, -6, -3, 0, 3, 6, 8, 9, 10, 12)],
    ),
    "offset": (
        "distance from the origin in sizes of the scene",
        [1.0, 1e3, 1e5],
        [1.0, 10.0, 1e2, 3e2, 1e3, 3e3, 1e4, 3e4, 1e5, 1e6],
    ),
    "c_e": ("C_E", [1e-3, 1.0, 1e2, 1e4], [10.0 ** (k / 2) for k in range(-6, 9)]),
}
#: An error holds where it grows by less than this share of the light.
GROWTH = 0.01

Row = dict[str, Any]


def measure(quick: bool = False, told: Callable[[int, int], None] | None = None) -> list[Row]:
    """One row per method and value: axis, method, x, error, own. `told` gets (done, total).

    `error` is rel_l1 against exact visibility with the same samples in the scene as it is; `own`
    the same where nothing is moved. Noisy methods have virtual lights here, whose paths rounding
    changes. They are compared with exact visibility of the moved scene, and the error of exact
    visibility there is added.
    """
    jobs = list(_jobs(quick))
    rows: list[Row] = []
    for done, (axis, name, x, error) in enumerate(jobs):
        rows.append({"axis": axis, "method": name, "x": x, "error": error()})
        if told is not None:
            told(done + 1, len(jobs))
    # The error of exact visibility is added to those of noisy methods; there is none along C_E
    exact = {(r["axis"], r["x"]): r["error"] for r in rows if r["method"] == "exact by Embree"}
    for row in rows:
        if row["method"] in METHODS and METHODS[row["method"]].noisy:
            row["error"] += exact.get((row["axis"], row["x"]), 0.0)
    unmoved = {"scale": 1.0, "offset": 0.0}
    own = {
        (r["axis"], r["method"]): r["error"] for r in rows if r["x"] == unmoved.get(r["axis"], 1.0)
    }
    for row in rows:
        row["own"] = own.get((row["axis"], row["method"]))
    return [row for row in rows if row["x"] > 0]


def _jobs(quick: bool) -> Iterator[tuple[str, str, float, Callable[[], float]]]:
    values = {axis: few if quick else many for axis, (_, few, many) in AXES.items()}
    for name, method in METHODS.items():
        for x in values["scale"]:
            yield "scale", name, x, partial(_moved, method, scale=x)
        for x in [0.0, *values["offset"]]:
            yield "offset", name, x, partial(_moved, method, shift=shift(x))
    for name, form in FORMS.items():
        for x in values["c_e"]:
            cells = {"visibility": replace(form, c_e=x)}
            error = partial(two, rel_l1, cells, integrator=SHARED)
            yield "c_e", f"quantized cache, {name}", x, error


def _moved(method: Method, **transform: Any) -> float:
    placed = moved(scenes.lit_box(), **transform)
    frame = picture(placed, method)
    if method.noisy:
        return rel_l1(frame, picture(placed, method.reference()))
    # The exact frame of the unit scene, of all lights or of the sky
    return rel_l1(frame, lit("exact products" if method.maps else "exact by Embree"))


def holding(rows: Iterable[Row], axis: str, method: str) -> tuple[float, float]:
    """The least and the largest value, next to the unmoved scene, up to which an error holds."""
    mine = sorted((r["x"], r["error"], r["own"]) for r in rows
                  if r["axis"] == axis and r["method"] == method)  # fmt: skip
    fine = {x: error <= own + GROWTH for x, error, own in mine}
    start = 1.0 if axis == "scale" else min(fine)
    below, above = [x for x in reversed(fine) if x <= start], [x for x in fine if x >= start]
    low, high = ([start, *takewhile(fine.__getitem__, xs)][-1] for xs in (below, above))
    return low, high
