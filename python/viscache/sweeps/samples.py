"""Pixels on which `tune` measures errors: tiles of the frame, or frames of other eye samples."""

from __future__ import annotations

import math
import typing
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.metrics import flip_map
from viscache.settings.checks import require
from viscache.settings.visibility import Exact
from viscache.shot import tiles
from viscache.shot.render import render_part
from viscache.shot.shot import BareShot

#: Visibility and use, as `render` takes them.
Setting: TypeAlias = tuple[Any, Any]
Piece: TypeAlias = dict[str, npt.NDArray[np.float64]]
#: Errors that are quotients of sums over pixels, or means of them.
ErrorMetric: TypeAlias = Literal["rel_l1_reflected", "rel_l1", "flip"]
METRICS: tuple[ErrorMetric, ...] = typing.get_args(ErrorMetric)

EXACT: Setting = (Exact(), None)
#: Pilots see this many tiles, or a 16th of the frame, and as many others check the result. A frame
#: of fewer tiles is halved, and one of less than `LEAST_TILES` is sampled by a frame of other eye
#: samples.
ENOUGH_TILES, MOST_PARTS, LEAST_TILES = 24, 16, 8
#: The pilots' eye samples begin this many frames later. Blocks of 512 are independent.
OTHER_SAMPLES = 512
#: Whole frames are cut into about this many blocks, whose edges are in this range.
BLOCKS, BLOCK_PX = 16, (16, 64)


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """The errors of one setting, and what a whole frame of it costs.

    `interval` is the 95 % interval of the metric that was asked for; `seconds` are of the CPU,
    `wall_s` of the clock.
    """

    errors: dict[ErrorMetric, float]
    interval: tuple[float, float]
    ray_reduction: float
    groups: dict[str, float]
    seconds: float
    wall_s: float


class Sample:
    """Pieces of an exact picture, and errors of other settings on them.

    `render` takes a setting and gives tiles, which are the given share of the frame's pixels, and
    are cut into blocks of the edge `block_px` if there is one. "flip" looks at a whole frame.
    """

    def __init__(
        self,
        render: Callable[[Setting], tiles.Part],
        metric: ErrorMetric,
        *,
        share: float,
        block_px: int | None = None,
    ) -> None:
        self._render, self._metric = render, metric
        self._share, self._block_px = share, block_px
        part = render(EXACT)
        self._exact = self._pieces(part)
        self._picture = _picture(part) if metric == "flip" else None
        #: Seconds of the CPU and of the clock of an exact frame.
        self.seconds_exact = self._seconds(part, "cpu_s")
        self.wall_exact_s = self._seconds(part, "total_s")
        lights = [_total(self._exact, name) for name in _LAYERS.values()]
        require(min(lights) > 0, "the picture must have light on surfaces", "none")
        self._light = _total(self._exact, _LAYERS.get(metric, "surfaces"))

    @property
    def count(self) -> int:
        """Number of samples behind an interval."""
        if self._picture is None:
            return len(self._exact)
        return len(self._blocks(self._picture))

    @property
    def groups(self) -> set[str]:
        """Light groups of the frame."""
        return set(self._exact[0]) - set(_LAYERS.values())

    def measured(self, setting: Setting) -> Measured:
        """The errors of a setting."""
        part = self._render(setting)
        pairs = list(zip(self._pieces(part), self._exact, strict=True))
        errors: dict[ErrorMetric, float] = {
            metric: sum(_difference(a, b, name) for a, b in pairs) / _total(self._exact, name)
            for metric, name in _LAYERS.items()
        }
        if self._picture is None:
            name = _LAYERS[self._metric]
            wrong = [_difference(a, b, name) for a, b in pairs]
            under = [float(b[name].sum()) for _, b in pairs]
        else:
            found = flip_map(_picture(part), self._picture)
            require(found is not None, "the picture must have light for flip", "none")
            blocks = self._blocks(found[0].astype(np.float64))  # type: ignore[index]
            wrong, under = [float(b.sum()) for b in blocks], [float(b.size) for b in blocks]
        error, interval = ratio(wrong, under)
        errors[self._metric] = error
        groups = {
            group: sum(_difference(a, b, group) for a, b in pairs) / self._light
            for group in sorted(self.groups & set(pairs[0][0]))
        }
        rays, queries = (part.frame.counters[n] for n in ("rays", "queries"))
        return Measured(
            errors=errors,
            interval=interval,
            ray_reduction=queries / rays if rays else math.inf,
            groups=groups,
            seconds=self._seconds(part, "cpu_s"),
            wall_s=self._seconds(part, "total_s"),
        )

    def _seconds(self, part: tiles.Part, clock: Literal["cpu_s", "total_s"]) -> float:
        """Seconds of a whole frame. Lights are traced once for every part."""
        timings = part.frame.timings
        threads = part.frame.provenance["threads"] if clock == "cpu_s" else 1
        once = min(timings[clock], timings["lights_s"] * threads)
        return float(once + (timings[clock] - once) / self._share)

    def _blocks(self, picture: npt.NDArray[np.float64]) -> list[npt.NDArray[np.float64]]:
        edge = _block_px((picture.shape[1], picture.shape[0]))
        return [b["x"] for b in _blocks({"x": picture, "color": picture}, edge)]

    def _pieces(self, part: tiles.Part) -> list[Piece]:
        """The picture of each tile or block, its light on surfaces, and its light groups."""
        names = ["color", *part.frame.counters["groups"]]
        found: list[Piece] = []
        for cut in part.cuts:
            piece = {n: cut[n].astype(np.float64) for n in names if n in cut}
            piece["surfaces"] = piece["color"] - cut["emitted"]
            found += [piece] if self._block_px is None else _blocks(piece, self._block_px)
        return found


def _picture(part: tiles.Part) -> npt.NDArray[np.float64]:
    """All light of a whole frame."""
    width, height = part.size
    made = np.zeros((height, width, 3))
    for (x0, y0, x1, y1), piece in zip(part.boxes, part.cuts, strict=True):
        made[y0:y1, x0:x1] = piece["color"]
    return made


#: The picture of a piece that a metric compares.
_LAYERS: dict[ErrorMetric, str] = {"rel_l1_reflected": "surfaces", "rel_l1": "color"}


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
    shot: BareShot, *, in_parts: bool, metric: ErrorMetric
) -> tuple[Callable[[], Sample], Callable[[], Sample]]:
    """What the pilots see, and what checks the result: functions that render the exact pictures.

    Tiles are independent of each other, so some tiles of a large frame have the frame's own error.
    If the settings cannot render parts of a frame, two frames of the same lights and different eye
    samples serve, as they do for FLIP, which looks at the surroundings of pixels. The shot must
    have a size.
    """

    def rendered(setting: Setting, first: int, part: tuple[int, int]) -> tiles.Part:
        visibility, use = setting
        wanted = shot.with_(visibility=visibility, use=use)
        return tiles.cut(render_part(wanted, part, first_sample=first), *part)

    def sampled(first: int, number: int) -> Callable[[], Sample]:
        return lambda: Sample(
            lambda setting: rendered(setting, first, (number, parts)),
            metric,
            share=_share(size, edge, number, parts),
            block_px=None if parts > 1 else _block_px(size),
        )

    # An empty part costs next to nothing and tells the size of tiles
    size = typing.cast("tuple[int, int]", shot.size)
    empty = render_part(shot.with_(visibility=Exact(), use=None), (1 << 19, 1 << 20))
    edge = int(empty.parameters["tile_edge_px"])
    in_parts = in_parts and metric != "flip"
    parts = _parts(len(tiles.tile_boxes(size, edge, 0, 1))) if in_parts else 1
    if parts < 2:
        return sampled(OTHER_SAMPLES * shot.spp, 0), sampled(0, 0)
    rng = np.random.Generator(np.random.Philox(key=[shot.seed, 1]))
    one, other = (int(number) for number in rng.permutation(parts)[:2])
    return sampled(0, one), sampled(0, other)


def _parts(count: int) -> int:
    """Into how many parts a frame of so many tiles is cut."""
    return max(min(MOST_PARTS, count // ENOUGH_TILES), 2 if count >= LEAST_TILES else 1)


def _share(size: tuple[int, int], edge: int, number: int, parts: int) -> float:
    boxes = tiles.tile_boxes(size, edge, number, parts)
    return sum((x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in boxes) / (size[0] * size[1])


def _block_px(size: tuple[int, int]) -> int:
    least, most = BLOCK_PX
    return min(most, max(least, int(math.sqrt(size[0] * size[1] / BLOCKS))))


def _blocks(piece: Piece, edge: int) -> list[Piece]:
    height, width = piece["color"].shape[:2]
    return [
        {name: pixels[y : y + edge, x : x + edge] for name, pixels in piece.items()}
        for y in range(0, height, edge)
        for x in range(0, width, edge)
    ]


def _total(pieces: Sequence[Piece], name: str) -> float:
    return sum(float(piece[name].sum()) for piece in pieces)


def _difference(a: Piece, b: Piece, name: str) -> float:
    return float(np.abs(a[name] - b[name]).sum())
