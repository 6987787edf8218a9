"""C_E from an error target: pilots with the quantized cache, checked on pixels they did not see.

The error of one picture grows with C_E along a curve that is no single power, so a
few pilots are joined by straight lines in log C_E, log rel_l1, and the line that crosses the target
is looked at again. Tiles do not know of each other, so some of a large frame's tiles (a 16th, at
least 24) have the frame's own error; of a small frame whole frames of other seeds serve.
"""

from __future__ import annotations

import html
import math
import os
import typing
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import sources, tiles
from viscache.render import render_part
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.settings import by_name
from viscache.settings.checks import is_whole, require
from viscache.settings.integrators import AmbientOcclusion, Direct, Whitted
from viscache.settings.not_given import NotGiven
from viscache.settings.spelling import spelled
from viscache.settings.visibility import Aqvc, Exact

__all__ = ["Pilot", "Tuned", "tune"]

#: Where pilots begin, and the ends of what is looked at.
FIRST_C_E = (4.0, 16.0)
LOWEST_C_E, HIGHEST_C_E = 0.25, 128.0
#: A pilot this near to the target is near enough.
NEAR = 0.04
MOST_PILOTS = 8
#: A frame of twice so many tiles is sampled by its tiles: so many for pilots and others to check,
#: or a 16th of them.
ENOUGH_TILES, MOST_PARTS = 24, 16
#: Whole frames that check a small one.
CHECK_FRAMES = 4
#: The error that is reached may be off by this factor.
TOLERANCE = 1.3
#: C_L is halved so often at most, at a C_E so small that light cells alone err.
MOST_HALVINGS, FINE_C_E = 6, 1.0
#: Groups of samples that each pixel has of its own: light cells bound their error, not C_E.
OWN_SAMPLES = {
    "area": "n_area, n_brdf", "environment": "n_environment, n_brdf", "ambient": "n_samples",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Pilot:
    """What one C_E gave on the pilots' pixels."""

    c_e: float
    rel_l1: float
    ray_reduction: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Tuned:
    """What `tune` found.

    Attributes
    ----------
    c_e : float
        The C_E to use; `visibility` has it.
    rel_l1 : float
        Its error on pixels that no pilot saw.
    interval : (low, high)
        95 % confidence interval of the error of such pixels (jackknife over tiles or frames).
    pilots : tuple of Pilot
        What was tried, by C_E.
    samples : int
        Tiles or frames behind the interval.
    groups : dict of str to float
        What each light group's layer is off by on the same pixels, over the light of the whole
        picture; where errors do not cancel they add up to `rel_l1`.
    """

    target: float
    c_e: float
    visibility: Aqvc
    rel_l1: float
    interval: tuple[float, float]
    ray_reduction: float
    pilots: tuple[Pilot, ...]
    samples: int
    groups: dict[str, float]

    @property
    def reached(self) -> bool:
        """Whether the error on unseen pixels is within 30 % of the target, or below it."""
        return self.rel_l1 <= self.target * TOLERANCE

    @property
    def message(self) -> str:
        """Why the target is not reached and which light group limits it; empty where it is."""
        if self.reached:
            return ""
        near = min(self.pilots, key=lambda p: abs(p.c_e - self.c_e))
        if near.rel_l1 <= self.target * TOLERANCE:
            low, high = self.interval
            text = (
                f"rel_l1 {self.target:.3g} is not confirmed: pilots had {near.rel_l1:.3g} at C_E ="
                f" {self.c_e:.3g}, pixels that they did not see have {self.rel_l1:.3g}"
                f" [{low:.3g}, {high:.3g}]."
            )
        else:
            finest = self.pilots[0]
            text = (
                f"No C_E reaches rel_l1 {self.target:.3g}: at {finest.c_e:.3g}, the smallest that"
                f" was tried, it is {finest.rel_l1:.3g}."
            )
        if not self.groups:
            return text
        worst = max(self.groups, key=self.groups.__getitem__)
        text += f" The group {worst!r} limits it, off by {self.groups[worst]:.3g}"
        rest = sorted((g for g in self.groups if g != worst), key=lambda g: -self.groups[g])
        text += "".join(f", {g} by {self.groups[g]:.3g}" for g in rest) + "."
        if worst in OWN_SAMPLES:
            text += (
                " Its samples are each pixel's own: the size of their light cells bounds their"
                f" error, not C_E. A smaller c_l makes the cells smaller, and so do more samples"
                f" ({OWN_SAMPLES[worst]}); vc.Exact() has no error."
            )
        return text

    def as_dict(self) -> dict[str, Any]:
        """What `viscache tune --json` prints."""
        return {
            "target": self.target, "c_e": self.c_e, "c_l": self.visibility.resolved()["c_l"],
            "rel_l1": self.rel_l1,
            "interval": list(self.interval), "reached": self.reached,
            "ray_reduction": self.ray_reduction, "samples": self.samples,
            "groups": self.groups, "message": self.message,
            "pilots": [{"c_e": p.c_e, "rel_l1": p.rel_l1, "ray_reduction": p.ray_reduction}
                       for p in self.pilots],
        }  # fmt: skip

    @property
    def _light_cells(self) -> str:
        return "" if self.visibility.c_l is None else f" c_l={self.visibility.c_l:.3g},"

    def __repr__(self) -> str:
        low, high = self.interval
        return (
            f"Tuned(c_e={self.c_e:.3g},{self._light_cells} rel_l1={self.rel_l1:.3g}"
            f" [{low:.3g}, {high:.3g}], target={self.target:.3g},"
            f" ray_reduction={self.ray_reduction:.3g})"
        )

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{p.c_e:.3g}</td><td>{p.rel_l1:.3g}</td><td>{p.ray_reduction:.3g}</td></tr>"
            for p in self.pilots
        )
        head = "<tr><th>C_E [px]</th><th>rel_l1</th><th>queries per ray</th></tr>"
        said = f"<p>{html.escape(self.message)}</p>" if self.message else ""
        return f"<table><caption>{html.escape(repr(self))}</caption>{head}{rows}</table>{said}"


@spelled
def tune(
    scene: Scene | str | os.PathLike[str],
    integrator: Any,
    *,
    rel_l1: float = 0.01,
    visibility: Aqvc | str | None = None,
    size: tuple[int, int] | None = None,
    spp: int = 1,
    seed: int = 0,
    threads: int | None = None,
    camera: Any = None,
    env: Any = None,
) -> Tuned:
    """The C_E at which the quantized cache has a wanted error against exact visibility.

    Where pixels sample a sky, area lights or their ambient light each for themselves, C_L too: it
    is halved until the error that no C_E lowers is at most half of what is wanted.

    Parameters
    ----------
    scene : Scene, path or str
    integrator : Direct, Whitted or AmbientOcclusion
        Or its name. Its directions not shared.
    rel_l1 : float
        The error that is wanted, relative L1 of the colour layer; in (0, 1).
    visibility : Aqvc, optional
        The other parameters; a C_E per light group in it stays, and its `c_l` if it is given.
    size, spp, seed, threads, camera, env
        Of the frame that will be rendered, as `viscache.render` takes them; the size is the
        camera's own by default.

    Returns
    -------
    Tuned
        `reached` says whether pixels that no pilot saw confirm it. Where even the largest C_E has
        less error than wanted, or the smallest more, that C_E is returned: `message` says so, and
        which light group limits.

    Raises
    ------
    ValueError
        A parameter out of range, or a picture without light.

    Examples
    --------
    >>> import viscache as vc
    >>> found = vc.tune(vc.scenes.room(triangles=2000), vc.Direct(), rel_l1=0.02, size=(64, 40))
    >>> found.reached
    True
    """
    number = isinstance(rel_l1, (int, float)) and not isinstance(rel_l1, bool)
    require(number and 0 < rel_l1 < 1, "rel_l1 must lie in (0, 1)", rel_l1)
    integrator = by_name.setting("integrator", integrator)
    require(isinstance(integrator, Direct | Whitted | AmbientOcclusion),
            "integrator must be vc.Direct(...), vc.Whitted(...) or vc.AmbientOcclusion(...)",
            integrator)  # fmt: skip
    base: Aqvc = by_name.setting("visibility", visibility, "aqvc")
    require(isinstance(base, Aqvc), "visibility must be vc.Aqvc(...)", visibility)
    require(is_whole(seed) and 0 <= seed < 1 << 62, "seed must be in [0, 2^62)", seed)
    lit = sources.opened(scene)
    lit = lit if env is None else lit.with_environment(env, threads=threads)
    pixels = frame_size(size, find_camera(lit, camera))
    given = {"size": pixels, "spp": spp, "threads": threads, "camera": camera}
    pilot, check = _samples(lit, integrator, given, int(seed))
    if not pilot.groups.isdisjoint(OWN_SAMPLES):
        base = with_light_cells(lambda tried: pilot.measured(tried)[3], base, float(rel_l1))
    pilots = search(lambda c_e: pilot.error(replace(base, c_e=c_e)), float(rel_l1))
    best = min(pilots, key=lambda p: abs(math.log(max(p.rel_l1, 1e-12) / rel_l1)))
    chosen = replace(base, c_e=best.c_e)
    found, interval, reduction, groups = check.measured(chosen)
    return Tuned(
        target=float(rel_l1), c_e=best.c_e, visibility=chosen, rel_l1=found, interval=interval,
        ray_reduction=reduction, samples=check.count,
        pilots=tuple(sorted(pilots, key=lambda p: p.c_e)), groups=groups,
    )  # fmt: skip


def with_light_cells(groups: Callable[[Aqvc], dict[str, float]], base: Aqvc, target: float) -> Aqvc:
    """C_L at which samples of each pixel's own leave C_E half of the target; `base` if it has one.

    `groups` tells what each light group is off by.
    """
    tried = base
    for halvings in range(MOST_HALVINGS + 1 if isinstance(base.c_l, NotGiven) else 0):
        tried = replace(base, c_l=0.5**halvings) if halvings else base
        off = groups(replace(tried, c_e=FINE_C_E))
        if sum(value for name, value in off.items() if name in OWN_SAMPLES) <= target / 2:
            break
    return tried


def search(error: Callable[[float], Pilot], target: float) -> list[Pilot]:
    """Pilots towards the C_E whose error is the target; the last one is the nearest or nearly."""
    tried = [error(c_e) for c_e in FIRST_C_E]
    while len(tried) < MOST_PILOTS:
        if any(abs(p.rel_l1 / target - 1) <= NEAR for p in tried):
            break
        below = [p for p in tried if p.rel_l1 <= target]
        above = [p for p in tried if p.rel_l1 > target]
        known = {p.c_e for p in tried}
        if not above:
            c_e = min(HIGHEST_C_E, 2.5 * max(known))
        elif not below:
            c_e = max(LOWEST_C_E, min(known) / 2.5)
        else:
            low = max(below, key=lambda p: p.c_e)
            high = min((p for p in above if p.c_e > low.c_e), key=lambda p: p.c_e, default=None)
            c_e = low.c_e if high is None else _crossing(low, high, target)
        if any(abs(c_e / k - 1) < 1e-3 for k in known):
            break
        tried.append(error(c_e))
    return tried


def _crossing(low: Pilot, high: Pilot, target: float) -> float:
    """Where the line through two pilots, in logarithms, has the target."""
    a, b = (math.log(max(p.rel_l1, target * 1e-3)) for p in (low, high))
    share = (math.log(target) - a) / (b - a) if b > a else 0.5
    share = min(0.95, max(0.05, share))
    return float(low.c_e * (high.c_e / low.c_e) ** share)


class _Sample:
    """Exact pieces of pictures, and the cache's error on them."""

    def __init__(self, render: Callable[[Any, int], tiles.Part], runs: Sequence[int]) -> None:
        self._render, self._runs = render, runs
        self._exact = [_pieces(render(Exact(), run)) for run in runs]
        self.whole = len(runs) > 1  # a run is one sample, else each of its tiles
        self._light = sum(float(p["color"].sum()) for run in self._exact for p in run)
        require(self._light > 0, "the picture must have light", "none")

    @property
    def count(self) -> int:
        """Samples that an interval is made of."""
        return len(self._runs) if self.whole else len(self._exact[0])

    @property
    def groups(self) -> set[str]:
        """Light groups of the frame."""
        return set(self._exact[0][0]) - {"color"}

    def error(self, visibility: Aqvc) -> Pilot:
        found, _, reduction, _ = self.measured(visibility)
        return Pilot(visibility.c_e, found, reduction)

    def measured(
        self, visibility: Aqvc
    ) -> tuple[float, tuple[float, float], float, dict[str, float]]:
        """rel_l1, its 95 % interval, queries per ray, what each group is off by."""
        wrong, light, queries, rays = [], [], 0, 0
        groups: dict[str, float] = {}
        for run, exact in zip(self._runs, self._exact, strict=True):
            part = self._render(visibility, run)
            queries += part.frame.counters["queries"]
            rays += part.frame.counters["rays"]
            pieces = list(zip(_pieces(part), exact, strict=True))
            wrong.append([_off(a, b, "color") for a, b in pieces])
            light.append([float(b["color"].sum()) for _, b in pieces])
            for name in [n for n in pieces[0][1] if n != "color"]:
                off = sum(_off(a, b, name) for a, b in pieces)
                groups[name] = groups.get(name, 0.0) + off / self._light
        join = (lambda rows: [sum(r) for r in rows]) if self.whole else (lambda rows: rows[0])
        found, interval = ratio(join(wrong), join(light))
        return found, interval, queries / rays if rays else math.inf, groups


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


Piece: TypeAlias = dict[str, npt.NDArray[np.float64]]


def _pieces(part: tiles.Part) -> list[Piece]:
    """Of each tile the picture, and the layers of its light groups."""
    names = ["color", *part.frame.counters["groups"]]
    return [{n: cut[n].astype(np.float64) for n in names if n in cut} for cut in part.cuts]


def _off(a: Piece, b: Piece, name: str) -> float:
    return float(np.abs(a[name] - b[name]).sum())


def _samples(
    scene: Scene, integrator: Any, given: dict[str, Any], seed: int
) -> tuple[_Sample, _Sample]:
    """What the pilots see and what checks them: tiles of the frame, or frames of other seeds."""

    def tiles_of(visibility: Any, number: int) -> tiles.Part:
        part = (number, parts)
        made = render_part(scene, integrator, part, visibility=visibility, seed=seed, **given)
        return tiles.cut(made, *part)

    def frame_of(visibility: Any, other: int) -> tiles.Part:
        made = render_part(scene, integrator, (0, 1), visibility=visibility, seed=other, **given)
        return tiles.cut(made, 0, 1)

    # A part that is empty costs next to nothing, and says how large tiles are
    edge = render_part(scene, integrator, (1 << 19, 1 << 20), seed=seed, **given).parameters
    width, height = typing.cast("tuple[int, int]", given["size"])
    count = len(tiles.tile_boxes((width, height), int(edge["tile_edge_px"]), 0, 1))
    parts = min(MOST_PARTS, count // ENOUGH_TILES)
    if parts < 2:
        checks = [seed + 2 + i for i in range(CHECK_FRAMES)]
        return _Sample(frame_of, [seed + 1]), _Sample(frame_of, checks)
    rng = np.random.Generator(np.random.Philox(key=[seed, 1]))
    one, other = rng.permutation(parts)[:2]
    return _Sample(tiles_of, [int(one)]), _Sample(tiles_of, [int(other)])
