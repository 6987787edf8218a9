"""`viscache bench progressive`: error times time of passes, exact, plain and corrected."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.bench.aligned import opened
from viscache.bench.common import Outcome, figure
from viscache.frame import Frame
from viscache.progressive import Progressive
from viscache.scene import Scene
from viscache.settings.integrators import Whitted
from viscache.settings.visibility import Aqvc, Exact

__all__ = ["progressive"]

#: C_E of the cache, for all scenes.
C_E = 10
#: Limit of the energy's t value; it has 15 degrees of freedom.
LIMIT_Z = 4.0
#: Passes of the two references, which are independent of each other and of the methods.
FIRST_OF_REFERENCES = (1024, 2048)


@dataclass(frozen=True)
class Case:
    """A scene, and the goals for corrected passes over exact ones by packets: nMSE, relMSE."""

    name: str
    scene: str
    goal: float | None = None
    rel_goal: float | None = None
    size: tuple[int, int] = (192, 192)
    n_vpls: int = 1024
    passes: int = 16
    reference: int = 16


CASES = (
    Case("room", "room?triangles=200000", 7, 5),
    Case("apartment", "apartment?triangles=300000", 7, 5),
    Case("conference", "conference", 7, 5),
    Case("sponza", "sponza-dabrovic/scene.xml", 6, 6),
    Case("living-room", "living-room/scene.xml", 4, 1.3),
)
QUICK = (Case("room", "room?triangles=3000", size=(48, 32), n_vpls=128, passes=6, reference=12),)


@dataclass
class Run:
    """A method: its picture, CPU seconds and the energy of each pass."""

    picture: Progressive
    cpu_s: float = 0.0
    energies: list[float] = field(default_factory=list)

    def add_pass(self) -> None:
        before = sum(self.energies)
        start = time.process_time()
        frame = self.picture.passes(1)
        self.cpu_s += time.process_time() - start
        total = float(frame.image.sum(dtype=np.float64)) * self.picture.n_passes
        self.energies.append(total - before)


def progressive(quick: bool = False) -> Outcome:
    """MSE·time of exact passes over that of others, against a picture of other eye samples."""
    outcome = Outcome()
    for case in QUICK if quick else CASES:
        scene = opened(case.scene)
        if scene is None:
            outcome.skip(case.name, "VISCACHE_SCENES has no such file")
        else:
            measure(outcome, case, scene)
    outcome.notes.append(
        "Passes take turns. Errors against two references: exact passes of other eye samples and"
        " the same lights. Their noise cancels. A ratio is MSE·CPU time of packets over that of the"
        " method: above 1 it is better. 'plain' keeps the cache's error, so its ratio falls with"
        " more passes."
    )
    return outcome


def measure(outcome: Outcome, case: Case, scene: Scene) -> None:
    """Let the methods take turns pass by pass."""
    light = Whitted(n_vpls=case.n_vpls)

    def picture(visibility: Any, use: Any = None, first: int = 0) -> Progressive:
        return Progressive(
            scene, light, visibility=visibility, use=use, first_pass=first, size=case.size
        )

    runs = {
        "packets": Run(picture(Exact(engine="packets"))),
        "exact": Run(picture(Exact())),
        "plain": Run(picture(Aqvc(c_e=C_E), "replace")),
        "corrected": Run(picture(Aqvc(c_e=C_E), "correct")),
    }
    for i in range(case.passes):
        for run in list(runs.values()) if i % 2 == 0 else list(runs.values())[::-1]:
            run.add_pass()
    references = [picture(Exact(), first=n).passes(case.reference) for n in FIRST_OF_REFERENCES]
    errors = {name: errors_of(run.picture, references) for name, run in runs.items()}
    base = runs["packets"]
    for name, run in runs.items():
        if name == "packets":
            continue
        for i, (metric, goal) in enumerate((("nMSE", case.goal), ("relMSE", case.rel_goal))):
            gain = gain_over(errors["packets"][i], base.cpu_s, errors[name][i], run.cpu_s)
            outcome.figures.append(
                figure(
                    f"{case.name}: {name} vs packets, {metric}·time",
                    errors[name][i],
                    metric,
                    baseline=errors["packets"][i],
                    ratios=[gain],
                    goal=goal if name == "corrected" else None,
                    cpu_s=run.cpu_s,
                    packets_cpu_s=base.cpu_s,
                    passes=case.passes,
                )
            )
    same = float(np.abs(base.picture.frame.image - runs["exact"].picture.frame.image).max())
    outcome.check(f"{case.name}: exact passes differ from those of packets", same, 0)
    found = np.array(runs["corrected"].energies) / np.array(base.energies) - 1
    z = abs(found.mean()) / (found.std(ddof=1) / math.sqrt(len(found)))
    outcome.check(f"{case.name}: |t| of the energy of corrected passes", float(z), LIMIT_Z)


def gain_over(error: float, cpu_s: float, other_error: float, other_cpu_s: float) -> float:
    """Error·time of the first over that of the other: above 1 the other is better."""
    return (error * cpu_s) / (other_error * other_cpu_s)


def errors_of(picture: Progressive, references: list[Frame]) -> tuple[float, float]:
    """NMSE and relMSE, by the product of the differences to two independent references.

    Their noise is in neither expectation.
    """
    a = picture.frame.image.astype(np.float64)
    first, second = (r.image.astype(np.float64) for r in references)
    squares: npt.NDArray[np.float64] = (a - first) * (a - second)
    truth = (first + second) / 2
    mean = truth.mean()
    return (
        float(squares.mean() / mean**2),
        float((squares / (truth**2 + (0.05 * mean) ** 2)).mean()),
    )
