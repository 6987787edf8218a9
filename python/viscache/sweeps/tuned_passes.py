"""How many passes, exact, corrected or of picked lights, have a wanted error or fit into a time.

Two pictures of each way, whose eye samples are independent, tell its error after each pass: their
difference over √2. A power of the number of passes goes on from there. Two more pictures of the way
that is chosen check it.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base.progress import Progress, step_bar
from viscache.frame.emitted_light import light_on_surfaces
from viscache.passes.progressive import Progressive
from viscache.settings.checks import require
from viscache.settings.visibility import Exact
from viscache.shot.exact_cost import SHARED_LIGHTS
from viscache.shot.shot import BareShot
from viscache.sweeps.samples import ratio
from viscache.sweeps.tuned import Pilot, Tuned

#: Passes of each pilot picture.
PILOT = 6
#: First passes of the pilots' and the check's two pictures; the picture itself begins at 0.
PILOTS, CHECKS = (1 << 20, 3 << 19), (1 << 21, 3 << 20)
MOST_PASSES = 1 << 16
#: The error falls as this power of the number of passes, at least and at most: independent samples,
#: and well-spread ones of smooth pictures.
POWER = (0.5, 1.0)
BLOCKS = 4
#: Numbers of picks of each eye point that are tried.
PICKS = (16, 64)
#: Cost of a picked ray, and of a contribution without a ray, in exact rays of whole rows
#: (docs/performance/picks.md).
PICKED_RAY, CONTRIBUTION = 1.7, 0.02

Light = npt.NDArray[np.float64]


def tuned_passes(
    shot: BareShot, cache: Any, target: float, by_time: bool, progress: Progress
) -> Tuned:
    """Whichever passes reach the target for less, or have the least error.

    Exact ones, those of the corrected cache, or exact ones with picked lights.
    """
    integrator = shot.setting("integrator")
    picked = () if integrator_picks(integrator) else PICKS
    with step_bar(progress, (6 + 2 * len(picked)) * PILOT, unit="pass") as step:

        def pair(way: BareShot, firsts: tuple[int, int]) -> _Pair:
            return _Pair([Progressive(**way.arguments, first_pass=n) for n in firsts], step)

        exact = shot.with_(visibility=Exact(), use=None)
        known = {"exact": exact, "corrected": shot.with_(visibility=cache, use="correct")}
        for n in picked:
            known[f"{n} picks"] = exact.with_(integrator=replace(integrator, pick=n))
        ways = {name: pair(way, PILOTS) for name, way in known.items()}
        for name in list(ways)[2:]:
            ways[name].chosen_among = ways["exact"].queries
        needed = {name: _needed(way, target, by_time) for name, way in ways.items()}

        def price(name: str) -> float:
            way, n = ways[name], needed[name]
            return way.error_at(n) if by_time else way.work(n)

        chosen = min(ways, key=price)
        way, n, found = ways[chosen], needed[chosen], known[chosen]
        check = pair(found, CHECKS)
    scale = (PILOT / n) ** way.power
    error, interval = check.last
    return Tuned(
        target=target,
        parameter="passes",
        value=n,
        passes=n,
        visibility=found.visibility,
        use=found.use,
        integrator=found.integrator,
        also=_also(found, integrator),
        rel_l1=error * scale,
        rel_l1_reflected=error * scale,
        interval=(interval[0] * scale, interval[1] * scale),
        ray_reduction=check.reduction,
        pilots=tuple(
            Pilot(
                needed[name],
                w.error_at(needed[name]),
                w.reduction,
                "passes",
                _also(known[name], integrator),
                w.wall(needed[name]),
            )
            for name, w in ways.items()
        ),
        samples=BLOCKS**2,
        groups={},
        seconds=check.cpu(n),
        seconds_exact=ways["exact"].cpu(needed["exact"]),
        wall_s=check.wall(n),
        wanted="seconds" if by_time else "error",
    )


def _also(way: BareShot, given: Any) -> dict[str, float]:
    """The picks, if they are not those that were given."""
    chosen = way.setting("integrator")
    return {} if chosen == given else {"pick": chosen.pick}


def integrator_picks(integrator: Any) -> bool:
    """Whether the integrator has a number of picks already, or cannot pick."""
    return bool(getattr(integrator, "pick", 1))


@dataclass
class _Clock:
    """Seconds of the first pass and of a later one."""

    first: float
    later: float

    def __call__(self, n: int) -> float:
        return self.first + (n - 1) * self.later


class _Pair:
    """Two pictures with independent eye samples, pass by pass."""

    def __init__(self, pictures: list[Progressive], step: Any) -> None:
        errors, wall, cpu, rays = [], [], [], []
        self.queries = 0.0
        self.chosen_among = 0.0  # connections among which picks were made
        for i in range(PILOT):
            frames, clocks = [], (time.perf_counter(), time.process_time())
            for picture in pictures:
                frames.append(picture.passes(1))
                step()
            wall.append((time.perf_counter() - clocks[0]) / 2)
            cpu.append((time.process_time() - clocks[1]) / 2)
            counted = [frame.counters for frame in frames]
            rays.append(sum(float(c["rays"]) for c in counted))
            self.queries = sum(float(c["queries"]) for c in counted)
            lights = [np.asarray(light_on_surfaces(f), np.float64) for f in frames]
            require(all(light.sum() > 0 for light in lights), "the picture must have light", "none")
            if i == 0 or i == PILOT - 1:
                errors.append(_error(lights[0], lights[1]))
        self.last = errors[-1]
        fallen = math.log(max(errors[0][0], 1e-12) / max(errors[-1][0], 1e-12)) / math.log(PILOT)
        self.power = min(POWER[1], max(POWER[0], fallen))
        self.wall, self.cpu = (_Clock(s[0], float(np.median(s[1:]))) for s in (wall, cpu))
        self.rays = _Clock(rays[0], (rays[-1] - rays[0]) / (PILOT - 1))
        self.exact = isinstance(pictures[0].visibility, Exact)

    @property
    def reduction(self) -> float:
        """Queries per ray of all pilot passes."""
        return self.queries / max(1.0, self.rays(PILOT))

    def error_at(self, n: int) -> float:
        """The error after n passes."""
        return float(self.last[0] * (PILOT / n) ** self.power)

    def work(self, n: int) -> float:
        """The cost of n passes in exact queries, by counted rays: the same on every machine."""
        of_pass = self.queries / PILOT
        if self.chosen_among:
            return n / PILOT * (PICKED_RAY * self.queries + CONTRIBUTION * self.chosen_among)
        if self.exact:
            return n * of_pass
        return SHARED_LIGHTS.of(self.rays(n) / (n * of_pass)) * n * of_pass


def _needed(way: _Pair, target: float, by_time: bool) -> int:
    if by_time:
        more = (target - way.wall.first) / max(way.wall.later, 1e-9)
        return int(min(MOST_PASSES, max(1, 1 + math.floor(more))))
    factor = (way.last[0] / target) ** (1 / way.power)
    return int(min(MOST_PASSES, max(1, math.ceil(PILOT * factor - 1e-9))))


def _error(one: Light, other: Light) -> tuple[float, tuple[float, float]]:
    """The relative L1 of either picture, from their difference, with its interval over blocks."""
    away, light = np.abs(one - other) / math.sqrt(2), (one + other) / 2
    sums = (
        [
            float(b.sum())
            for row in np.array_split(x, BLOCKS)
            for b in np.array_split(row, BLOCKS, 1)
        ]
        for x in (away, light)
    )
    return ratio(*sums)
