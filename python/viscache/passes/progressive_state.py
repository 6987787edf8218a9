"""Sums over the passes of a picture, and their file."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.aqvc.rows import AqvcRows
from viscache.base.formats import (
    COUNT,
    NUMBERS,
    TABLE,
    TEXT,
    TEXTS,
    ArrayField,
    Field,
    Format,
    is_count,
    is_number,
    list_of,
)
from viscache.base.provenance import VERSION
from viscache.frame import Frame
from viscache.frame.emitted_light import seen_emitters
from viscache.oracles.learned import MOST_OCTAVES, N_CLASSES, Shares
from viscache.settings.aqvc import LIGHT_GROUPS
from viscache.shot.shot import require_same
from viscache.vismap.cache_file import RECORDS

Array = npt.NDArray[np.float64]

#: Counters that do not add up over passes.
OF_ONE_PASS = (
    "sha256",
    "audit",
    "vpls",
    "lost_throughput",
    "kept_cells",
    "kept_bytes",
    "tiles_not_kept",
    "map_bytes",
    "records",
    "voxel_pairs",
)
#: First hits are summed over the samples that hit.
BY_HITS = ("depth", "normal", "albedo")
#: Earlier sums that are kept, so that one of them has about half of the passes.
PARTS = 2


def _is_share(value: Any) -> bool:
    """Fields of `Shares`, or null."""
    if value is None:
        return True
    if not isinstance(value, dict) or value.keys() != {"octaves", "scale"}:
        return False
    octaves, scale = value["octaves"], value["scale"]
    of_class = list_of(lambda octave: is_count(octave) and octave <= MOST_OCTAVES)
    fits = octaves is None or (
        list_of(lambda row: of_class(row) and len(row) == N_CLASSES)(octaves)
        and len(octaves) == len(LIGHT_GROUPS)
    )
    return fits and (scale == math.inf or (is_number(scale) and scale > 0))


def _are_passes(value: Any) -> bool:
    """Ranges of passes in ascending order."""
    if not list_of(lambda r: list_of(is_count)(r) and len(r) == 2 and r[0] < r[1])(value):
        return False
    return all(a[1] < b[0] for a, b in pairwise(value))


def _is_row(value: Any) -> bool:
    """[tile, group, digest, words] of rows that a cache keeps."""
    if not isinstance(value, list) or len(value) != 4:
        return False
    tile, group, digest, words = value
    known = isinstance(digest, str) and digest.isascii() and digest.isdecimal()
    return is_count(tile) and group in range(len(LIGHT_GROUPS)) and known and is_count(words)


FORMAT = Format(
    kind="a saved state of vc.Progressive",
    version=2,
    fields={
        "shows": TABLE,
        "version": TEXT,
        **dict.fromkeys(("n", "next_pass", "row_frames"), COUNT),
        "row_tiles": Field("a number of tiles", lambda v: is_count(v) and v < 1 << 24),
        "numbers": Field("ranges of passes in ascending order", _are_passes),
        **dict.fromkeys(("counters", "parameters"), TABLE),
        "timings": NUMBERS,
        **dict.fromkeys(("warnings", "layers"), TEXTS),
        "shares": Field("shares of light groups, or null", _is_share),
        "parts": Field("numbers of passes", list_of(lambda v: is_count(v) and v > 0)),
        "rows": Field("a list of [tile, group, digest, words]", list_of(_is_row)),
    },
    arrays={
        "squares": ArrayField("f8", ("H", "W", 3)),
        "layer color?": ArrayField("f8", ("H", "W", 3)),
        "layer *": ArrayField("f8", ("H", "W", None)),
        "part *": ArrayField("f8", ("H", "W", 3)),
        "cells *": ArrayField("i8", None),
        "rows *": ArrayField("u8", None),
        **{f"kept {name}?": array for name, array in RECORDS.items()},
        "kept counts?": ArrayField("i8", (3,)),
        "kept thresholds?": ArrayField("f8", (2,)),
        "kept place?": ArrayField("u8", ("places",)),
        **dict.fromkeys(("kept tested?", "kept seen?"), ArrayField("u4", ("places",))),
        "kept frames?": ArrayField("i8", ()),
    },
)


@dataclass(frozen=True)
class Sums:
    """Sums over passes, and the sum of squared deviations of the colour (Welford).

    They never change: a pass makes new ones. So a picture has those before a pass or those after
    it, whoever reads them at whatever time.

    `numbers` of the passes are ascending ranges [first, end]. Layers (H, W, C) of the first hit are
    weighted by their coverage. `parts` are the sums of the light on surfaces over the first n
    passes, for the last powers of two. The parameters are those of the last pass, warnings those of
    all, and `shares` what the first passes decided for the draws of later ones.
    """

    n: int = 0
    next_pass: int = 0
    numbers: list[list[int]] = field(default_factory=list)
    layers: dict[str, Array] = field(default_factory=dict)
    squares: Array = field(default_factory=lambda: np.zeros((0, 0, 3)))
    parts: list[tuple[int, Array]] = field(default_factory=list)
    counters: dict[str, Any] = field(default_factory=dict)
    timings: dict[str, float] = field(default_factory=dict)
    parameters: dict[str, Any] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    shares: Shares | None = None

    def plus(self, frame: Frame, number: int) -> Sums:
        """The sums with one more pass."""
        numbers = _joined([*self.numbers, [number, number + 1]])
        color = frame.layers["color"].astype(np.float64)
        if self.n == 0:
            layers = {n: np.zeros(p.shape) for n, p in frame.layers.items()}
            squares, parts = np.zeros_like(color), self.parts
        else:
            layers, parts = self.layers, self._with_part()
            deviation = color - layers["color"] / self.n
            squares = self.squares + deviation**2 * (self.n / (self.n + 1))
        hits = frame.layers["coverage"].astype(np.float64) if "coverage" in frame.layers else 1.0
        added = {
            name: layers[name] + pixels * (hits if name in BY_HITS else 1.0)
            for name, pixels in frame.layers.items()
        }
        counters = _added(self.counters, frame.counters)
        if self.n > 0:  # the audit of one pass tells nothing about their mean
            counters.pop("audit", None)
        if counters.get("rays"):
            counters["ray_reduction"] = counters["queries"] / counters["rays"]
        return replace(
            self,
            n=self.n + 1,
            next_pass=number + 1,
            numbers=numbers,
            layers=layers | added,
            squares=squares,
            parts=parts,
            counters=counters,
            timings=_times(self.timings, frame.timings),
            parameters=frame.parameters,
            warnings=_each_once(self.warnings, frame.warnings),
        )

    def merged(self, other: Sums) -> Sums:
        """The sums with the passes of other ones (Chan, Golub, LeVeque 1979)."""
        numbers = _joined([*self.numbers, *other.numbers])
        first = self if self.n else other
        squares, parts, layers = first.squares, first.parts, first.layers
        if other.n and self.n:
            deviation = self.layers["color"] / self.n - other.layers["color"] / other.n
            between = deviation**2 * (self.n * other.n / (self.n + other.n))
            squares = self.squares + other.squares + between
            parts = self._with_part()
            layers = {
                name: p + other.layers[name]
                for name, p in self.layers.items()
                if name in other.layers
            }
        counters = _added(self.counters, other.counters)
        if self.n + other.n > 1:
            counters.pop("audit", None)
        return replace(
            first,
            n=self.n + other.n,
            next_pass=self.next_pass,
            numbers=numbers,
            layers=layers,
            squares=squares,
            parts=parts,
            counters=counters,
            timings=_times(self.timings, other.timings),
            warnings=_each_once(self.warnings, other.warnings),
        )

    def _with_part(self) -> list[tuple[int, Array]]:
        """The parts, with all passes so far if they are twice those of the last one."""
        if not self.parts or self.n >= 2 * self.parts[-1][0]:
            return [*self.parts, (self.n, self._light())][-PARTS:]
        return self.parts

    def _light(self) -> Array:
        emitted = seen_emitters(self)
        color = self.layers["color"]
        return color.copy() if emitted is None else color - emitted

    def means(self) -> dict[str, Array]:
        """The layers of the mean."""
        hits = self.layers.get("coverage", np.zeros(0))
        return {
            name: np.divide(total, hits, out=np.zeros_like(total), where=hits > 0)
            if name in BY_HITS
            else total / self.n
            for name, total in self.layers.items()
        }

    def variance(self) -> Array:
        """The variance of the mean's colour from the noise between single passes.

        Passes share the sequences of their samples, so it errs towards more.
        """
        return self.squares / (self.n * (self.n - 1))

    def deviation(self) -> Array:
        """How far the mean's light on surfaces is from that of endless passes, as draws.

        It is the difference of two parts of the passes, scaled as for parts that are independent.
        Each part goes through a sequence of its own, so that its error falls as the mean's does. If
        this is as n^-p, the draws of halves are right at p = 1/2 and √3 times too large at p = 1.
        """
        m, first = min(self.parts, key=lambda part: abs(2 * part[0] - self.n))
        rest = self.n - m
        difference = first / m - (self._light() - first) / rest
        return difference * math.sqrt(m * rest) / self.n


def _joined(ranges: list[list[int]]) -> list[list[int]]:
    """Ranges in ascending order, neighbours joined."""
    out: list[list[int]] = []
    for first, end in sorted(ranges):
        if out and first < out[-1][1]:
            raise ValueError(f"passes must be counted once, got pass {first} twice")
        if out and first == out[-1][1]:
            out[-1] = [out[-1][0], end]
        else:
            out.append([first, end])
    return out


def _times(sums: dict[str, float], more: dict[str, float]) -> dict[str, float]:
    return sums | {name: sums.get(name, 0.0) + seconds for name, seconds in more.items()}


def _each_once(texts: list[str], more: list[str]) -> list[str]:
    return [*texts, *(text for text in more if text not in texts)]


def _added(sums: dict[str, Any], more: dict[str, Any]) -> dict[str, Any]:
    """Sums of whole numbers, by name; other values are those of the last pass."""
    out = dict(sums)
    for name, value in more.items():
        before = sums.get(name)
        if before is not None and name not in OF_ONE_PASS:
            like = isinstance(before, dict) == isinstance(value, dict)
            if not like or (isinstance(value, int) and not isinstance(before, int | float)):
                raise ValueError(f"the counter {name} must be like {value!r}, got {before!r}")
        if isinstance(value, dict) and name not in OF_ONE_PASS:
            out[name] = _added(before or {}, value)
        elif isinstance(value, int) and not isinstance(value, bool) and name not in OF_ONE_PASS:
            out[name] = (before or 0) + value
        else:
            out[name] = value
    return out


def save(
    path: str | os.PathLike[str],
    shows: dict[str, Any],
    sums: Sums,
    rows: AqvcRows | None,
    kept: dict[str, npt.NDArray[Any]],
) -> None:
    """Write an uncompressed `.npz` of the sums, rows and other arrays that caches keep."""
    records: dict[str, Any] = {
        "shows": shows,
        "version": VERSION,
        "n": sums.n,
        "numbers": sums.numbers,
        "next_pass": sums.next_pass,
        "counters": sums.counters,
        "timings": sums.timings,
        "parameters": sums.parameters,
        "warnings": sums.warnings,
        "shares": asdict(sums.shares) if sums.shares else None,
        "layers": list(sums.layers),
        "parts": [n for n, _ in sums.parts],
        "rows": [],
        "row_tiles": 0,
        "row_frames": 0,
    }
    arrays: dict[str, Any] = {"squares": sums.squares}
    arrays |= {f"part {n}": total for n, total in sums.parts}
    arrays |= {f"kept {name}": values for name, values in kept.items()}
    arrays |= {f"layer {name}": pixels for name, pixels in sums.layers.items()}
    if rows is not None:
        records["row_tiles"], records["row_frames"] = rows._core.tiles, rows.frames
        for tile, group, (digest, row_words, cells, bits) in rows._state():
            records["rows"].append([tile, group, str(digest), row_words])
            arrays[f"cells {tile} {group}"] = cells
            arrays[f"rows {tile} {group}"] = bits
    FORMAT.write_npz(Path(path), records, arrays)


def load(
    path: str | os.PathLike[str],
    shows: dict[str, Any],
    rows: AqvcRows | None,
    restore: Callable[[dict[str, npt.NDArray[Any]]], None],
) -> Sums:
    """The sums of a file whose picture shows this.

    Once all is checked, its rows go to `rows`, and other arrays that caches keep to `restore`.
    """
    source = Path(path)
    records, arrays = FORMAT.read_npz(source)
    version = records["version"]
    if version != VERSION:
        raise ValueError(f"{source} must be of viscache {VERSION}, got {version}")
    require_same(records["shows"], shows, f"as in {source}")
    try:
        passes = sum(end - first for first, end in records["numbers"])
        if records["n"] != passes or (passes > 0) != ("color" in records["layers"]):
            raise ValueError(f"{records['n']} passes with the numbers {records['numbers']}")
        kept_rows = []
        for tile, group, digest, words in records["rows"]:
            cells, bits = (arrays[f"{name} {tile} {group}"] for name in ("cells", "rows"))
            kept_rows.append((tile, group, (int(digest), words, cells, bits)))
        same = ("n", "next_pass", "numbers", "counters", "timings", "parameters", "warnings")
        sums = Sums(
            **{name: records[name] for name in same},
            layers={name: arrays[f"layer {name}"] for name in records["layers"]},
            squares=arrays["squares"],
            parts=[(n, arrays[f"part {n}"]) for n in records["parts"]],
            shares=Shares(**records["shares"]) if records["shares"] else None,
        )
        width, height = shows["size"]
        if sums.n and sums.squares.shape[:2] != (height, width):
            raise ValueError(f"pictures of shape {sums.squares.shape}, not {(height, width, 3)}")
        # Nothing has changed until here. A picture has rows or others, never both
        others = {n.removeprefix("kept "): a for n, a in arrays.items() if n.startswith("kept ")}
        restore(others)
        if rows is not None:
            rows._restore(records["row_tiles"], records["row_frames"], kept_rows)
    except (LookupError, TypeError, ValueError, OverflowError) as error:
        raise FORMAT.refusal(source, f"its parts do not fit: {error}") from error
    return sums
