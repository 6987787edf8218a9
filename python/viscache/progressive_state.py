"""Sums over the passes of a picture, and their file."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.aqvc_rows import AqvcRows
from viscache.array_digests import arrays_digest
from viscache.emitted_light import seen_emitters
from viscache.files import DAMAGED_ARRAYS, whole_file
from viscache.frame import Frame
from viscache.oracles.learned import Shares
from viscache.provenance import VERSION
from viscache.shot import require_same

__all__ = ["Sums", "load", "save"]

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
#: Name of the hash among the records.
DIGEST = "sha256"
#: First hits are summed over the samples that hit.
BY_HITS = ("depth", "normal", "albedo")
#: Earlier sums that are kept, so that one of them has about half of the passes.
PARTS = 2


@dataclass(frozen=True)
class Sums:
    """Sums over passes, and the sum of squared deviations of the colour (Welford).

    They never change: a pass makes new ones. So a picture has those before a pass or those after
    it, whoever reads them at whatever time.

    Attributes
    ----------
    n : int
    next_pass : int
        Number of the next pass.
    numbers : list of [first, end]
        Numbers of the passes, as ranges in ascending order.
    layers : dict of str to (H, W, C) float64
        Layers of the first hit are weighted by their coverage.
    squares : (H, W, 3) float64
    parts : list of (n, (H, W, 3) float64)
        Sums of the light on surfaces over the first n passes, for the last powers of two.
    counters, timings : dict
    parameters : dict
        Of the last pass.
    warnings : list of str
        Of all passes, each once.
    shares : Shares, optional
        What the first passes decided for the draws of later ones.
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
        return Sums(
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
            shares=self.shares,
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
        return Sums(
            n=self.n + other.n,
            next_pass=self.next_pass,
            numbers=numbers,
            layers=layers,
            squares=squares,
            parts=parts,
            counters=counters,
            timings=_times(self.timings, other.timings),
            parameters=first.parameters,
            warnings=_each_once(self.warnings, other.warnings),
            shares=first.shares,
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
    records = json.loads(json.dumps(records))  # as they will be read
    text = json.dumps(records | {DIGEST: _digest(records, arrays)}).encode()
    with whole_file(Path(path)) as partial, partial.open("wb") as file:
        np.savez(file, records=np.frombuffer(text, np.uint8), **arrays)


def _digest(records: dict[str, Any], arrays: dict[str, npt.NDArray[Any]]) -> str:
    return arrays_digest(json.dumps(records, sort_keys=True).encode(), arrays)


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
    if not source.is_file():
        raise FileNotFoundError(f"no such file: {source}")
    try:
        with source.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        records = json.loads(arrays["records"].tobytes())
        whole, version = records.pop(DIGEST, None), records["version"]
        rest = {n: a for n, a in arrays.items() if n != "records"}
        if whole != _digest(records, rest):
            raise ValueError("its content does not fit its hash")
    except DAMAGED_ARRAYS as error:
        raise ValueError(f"{source} must be a saved state of vc.Progressive: {error}") from error
    if version != VERSION:
        raise ValueError(f"{source} must be of viscache {VERSION}, got {version}")
    if "shows" not in records:
        raise ValueError(
            f"{source} must name its sky and camera by value, got a state of an earlier viscache,"
            " whose passes have other seeds, too: render its passes again"
        )
    require_same(records["shows"], shows, f"as in {source}")
    try:
        kept_rows = [
            (
                tile,
                group,
                (
                    int(digest),
                    words,
                    arrays[f"cells {tile} {group}"],
                    arrays[f"rows {tile} {group}"],
                ),
            )
            for tile, group, digest, words in records["rows"]
        ]
        sums = Sums(
            n=records["n"],
            next_pass=int(records["next_pass"]),
            numbers=records["numbers"],
            layers={name: arrays[f"layer {name}"] for name in records["layers"]},
            squares=arrays["squares"],
            parts=[(n, arrays[f"part {n}"]) for n in records["parts"]],
            counters=records["counters"],
            timings=records["timings"],
            parameters=records["parameters"],
            warnings=records["warnings"],
            shares=Shares(**records["shares"]) if records["shares"] else None,
        )
        kept = {n.removeprefix("kept "): a for n, a in arrays.items() if n.startswith("kept ")}
        _check_shapes(sums, shows["size"], source)
        if rows is not None:
            rows._restore(records["row_tiles"], records["row_frames"], kept_rows)
        restore(kept)
    except (KeyError, IndexError, TypeError) as error:
        raise ValueError(f"{source} must be a whole saved state, it lacks {error}") from error
    return sums


def _check_shapes(sums: Sums, size: list[int], source: Path) -> None:
    """Pictures must have the pixels of the frame, and the numbers of a sum."""
    named = {"squares": sums.squares, **sums.layers} | {f"part {n}": p for n, p in sums.parts}
    for name, pixels in named.items() if sums.n else ():
        fits = pixels.ndim == 3 and pixels.shape[:2] == (size[1], size[0])
        if not fits or pixels.dtype != np.float64:
            raise ValueError(
                f"{source}: {name} must be float64 of shape ({size[1]}, {size[0]}, channels),"
                f" got {pixels.dtype} of shape {pixels.shape}"
            )
