"""Pixels on which `tune` measures errors: tiles of the frame, or whole frames of other seeds."""

from __future__ import annotations

import math
import typing
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import tiles
from viscache.render import render_part
from viscache.scene import Scene
from viscache.settings.checks import require
from viscache.settings.visibility import Exact

__all__ = ["Measured", "Sample", "Setting", "ratio", "samples"]

#: Visibility and use, as `render` takes them.
Setting: TypeAlias = tuple[Any, Any]
Piece: TypeAlias = dict[str, npt.NDArray[np.float64]]

EXACT: Setting = (Exact(), None)
#: Pilots see this many tiles, or a 16th of the frame, and as many others check the result. Smaller
#: frames are sampled by whole frames.
ENOUGH_TILES, MOST_PARTS = 24, 16
#: Whole frames that check the result.
CHECK_FRAMES = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """The error of one setting: `rel_l1` with its 95 % interval, and by light group."""

    rel_l1: float
    interval: tuple[float, float]
    ray_reduction: float
    groups: dict[str, float]


class Sample:
    """Pieces of exact pictures, and errors of other settings on them.

    Parameters
    ----------
    render : callable
        Takes a setting and a run, returns tiles.
    runs : sequence of int
        Parts of a frame, or seeds. Of one run every tile is a sample, else every run.
    """

    def __init__(
        self, render: Callable[[Setting, int], tiles.Part], runs: Sequence[int], *, whole: bool
    ) -> None:
        self._render, self._runs, self.whole = render, runs, whole
        self._exact = [_pieces(render(EXACT, run)) for run in runs]
        self._light = sum(float(p["color"].sum()) for run in self._exact for p in run)
        require(self._light > 0, "the picture must have light", "none")

    @property
    def count(self) -> int:
        """Number of samples behind an interval."""
        return len(self._runs) if self.whole else len(self._exact[0])

    @property
    def groups(self) -> set[str]:
        """Light groups of the frame."""
        return set(self._exact[0][0]) - {"color"}

    def measured(self, setting: Setting) -> Measured:
        """The error of a setting."""
        wrong, light, queries, rays = [], [], 0, 0
        groups: dict[str, float] = {}
        for run, exact in zip(self._runs, self._exact, strict=True):
            part = self._render(setting, run)
            queries += part.frame.counters["queries"]
            rays += part.frame.counters["rays"]
            pieces = list(zip(_pieces(part), exact, strict=True))
            wrong.append([_difference(a, b, "color") for a, b in pieces])
            light.append([float(b["color"].sum()) for _, b in pieces])
            for name in [n for n in pieces[0][1] if n != "color" and n in pieces[0][0]]:
                error = sum(_difference(a, b, name) for a, b in pieces)
                groups[name] = groups.get(name, 0.0) + error / self._light
        join = (lambda rows: [sum(r) for r in rows]) if self.whole else (lambda rows: rows[0])
        found, interval = ratio(join(wrong), join(light))
        reduction = queries / rays if rays else math.inf
        return Measured(rel_l1=found, interval=interval, ray_reduction=reduction, groups=groups)


def ratio(over: Sequence[float], under: Sequence[float]) -> tuple[float, tuple[float, float]]:
    """Σ over / Σ under with its 95 % jackknife interval (Student's t); (0, inf) of one sample."""
    from scipy.stats import t  # type: ignore[import-untyped,unused-ignore]

    a, b = np.asarray(over), np.asarray(under)
    n, total = len(a), float(a.sum() / b.sum())
    if n < 2:
        return total, (0.0, math.inf)
    rest = b.sum() - b
    without = np.where(rest > 0, (a.sum() - a) / np.where(rest > 0, rest, 1), total)
    deviation = math.sqrt((n - 1) / n * float(np.square(without - without.mean()).sum()))
    half = float(t.ppf(0.975, n - 1)) * deviation
    return total, (max(0.0, total - half), total + half)


def samples(
    scene: Scene, integrator: Any, given: dict[str, Any], seed: int, *, in_parts: bool
) -> tuple[Sample, Sample]:
    """What the pilots see, and what checks the result.

    Tiles are independent of each other, so some tiles of a large frame have the frame's own error.

    Parameters
    ----------
    given : dict
        Other arguments of `render_part`.
    in_parts : bool
        Whether the settings can render parts of a frame. Else whole frames of other seeds serve.
    """

    def tiles_of(setting: Setting, number: int) -> tiles.Part:
        return rendered(setting, seed, (number, parts))

    def frame_of(setting: Setting, other: int) -> tiles.Part:
        return rendered(setting, other, (0, 1))

    def rendered(setting: Setting, of_seed: int, part: tuple[int, int]) -> tiles.Part:
        visibility, use = setting
        made = render_part(
            scene, integrator, part, visibility=visibility, use=use, seed=of_seed, **given
        )
        return tiles.cut(made, *part)

    parts = _parts(scene, integrator, given) if in_parts else 1
    if parts < 2:
        checks = [seed + 2 + i for i in range(CHECK_FRAMES)]
        return Sample(frame_of, [seed + 1], whole=False), Sample(frame_of, checks, whole=True)
    rng = np.random.Generator(np.random.Philox(key=[seed, 1]))
    one, other = (int(number) for number in rng.permutation(parts)[:2])
    return Sample(tiles_of, [one], whole=False), Sample(tiles_of, [other], whole=False)


def _parts(scene: Scene, integrator: Any, given: dict[str, Any]) -> int:
    """Into how many parts of enough tiles a frame can be cut."""
    # An empty part costs next to nothing and tells the size of tiles
    empty = render_part(scene, integrator, (1 << 19, 1 << 20), **given).parameters
    width, height = typing.cast("tuple[int, int]", given["size"])
    count = len(tiles.tile_boxes((width, height), int(empty["tile_edge_px"]), 0, 1))
    return min(MOST_PARTS, count // ENOUGH_TILES)


def _pieces(part: tiles.Part) -> list[Piece]:
    """The picture of each tile, and the layers of its light groups."""
    names = ["color", *part.frame.counters["groups"]]
    return [{n: cut[n].astype(np.float64) for n in names if n in cut} for cut in part.cuts]


def _difference(a: Piece, b: Piece, name: str) -> float:
    return float(np.abs(a[name] - b[name]).sum())
