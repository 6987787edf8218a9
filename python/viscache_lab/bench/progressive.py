"""`viscache bench progressive`: error times time of passes, exact, plain, corrected and picked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.bench.errors import Run, differences, energy_z, persistent_z, take_turns
from viscache_lab.bench.never_slower import CASES as CANNOT_WIN
from viscache_lab.bench.never_slower import QUICK as CANNOT_WIN_QUICK
from viscache_lab.bench.never_slower import never_slower
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import student_t

#: The cache of plain passes, for all scenes, and of corrected ones: the default.
PLAIN, CORRECTED = vc.Aqvc(c_e=10), vc.Aqvc()
#: Picks of each eye point, of the rival without a cache.
PICKS = 16
#: Limit of the energy's t value; it has 15 degrees of freedom.
LIMIT_Z = 4.0
#: Limits over many passes: of the energy's |z|, and of the persistent squared error in its
#: standard errors.
LIMIT_MANY, LIMIT_BIAS = 3.0, 3.0
#: Passes of the two references, which are independent of each other and of the methods.
FIRST_OF_REFERENCES = (1024, 2048)


@dataclass(frozen=True)
class Case:
    """A scene, and goals for corrected passes: nMSE and relMSE over packets, shafts and picks."""

    name: str
    scene: str
    packets: tuple[float, float] | None = None
    exact: tuple[float, float] | None = None
    picks: tuple[float, float] | None = None
    size: tuple[int, int] = (192, 192)
    n_vpls: int = 1024
    passes: int = 16
    reference: int = 16
    many: int = 64
    """Passes of a smaller picture that tell a bias."""
    many_size: tuple[int, int] = (48, 48)


CASES = (
    Case("room", "room?triangles=200000", (7, 5), (2.5, 2), (1.3, 1.3)),
    Case("apartment", "apartment?triangles=300000", (7, 5), (2.5, 2), (1.3, 1.3)),
    Case("conference", "conference", (7, 5), (2.5, 2), (1.3, 1.3)),
    Case("sponza", "sponza-dabrovic/scene.xml", (6, 6)),
    Case("living-room", "living-room/scene.xml", (4, 1.3)),
)
QUICK = (
    Case(
        "room", "room?triangles=3000", size=(48, 32), n_vpls=128, passes=6, reference=12, many=16,
        many_size=(32, 32),
    ),
)  # fmt: skip


@BENCHES.add("progressive", "error times time of passes: exact, plain and corrected")
def progressive(trial: Trial) -> None:
    """MSE·time of passes, against a picture of other eye samples; bias over many; time at worst."""
    for case, scene in trial.scenes(QUICK if trial.quick else CASES):
        measure(trial, case, scene)
        bias(trial, case, scene)
    never_slower(trial, CANNOT_WIN_QUICK if trial.quick else CANNOT_WIN)
    trial.notes.append(
        "Passes take turns. Errors against two references: exact passes of other eye samples and"
        " the same lights. Their noise cancels. A ratio is MSE·CPU time of the second way over that"
        " of the first: above 1 the first is better. 'plain' keeps the cache's error, so its ratio"
        " falls with more passes. 'many passes': of a smaller picture, beside exact passes of the"
        " same samples."
    )


def measure(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """Let the methods take turns pass by pass."""
    light = vc.Whitted(n_vpls=case.n_vpls)

    def picture(visibility: Any, use: Any = None, first: int = 0, pick: int = 0) -> vc.Progressive:
        return vc.Progressive(
            scene,
            replace(light, pick=pick),
            visibility=visibility,
            use=use,
            first_pass=first,
            size=case.size,
        )

    picks = f"{PICKS} picks"
    runs = {
        "packets": Run(picture(vc.Exact(engine="packets"))),
        "exact": Run(picture(vc.Exact())),
        "plain": Run(picture(PLAIN, "replace")),
        "corrected": Run(picture(CORRECTED, "correct")),
        picks: Run(picture(vc.Exact(), pick=PICKS)),
    }
    take_turns(list(runs.values()), case.passes)
    references = [picture(vc.Exact(), first=n).passes(case.reference) for n in FIRST_OF_REFERENCES]
    errors = {name: errors_of(run.picture, references) for name, run in runs.items()}
    base = runs["packets"]
    compared: list[tuple[str, str, tuple[float, float] | None]]
    compared = [(name, "packets", None) for name in ("exact", "plain", picks)]
    compared += [("corrected", other, goals) for other, goals in _goals(case).items()]
    for name, other, goals in compared:
        run, against = runs[name], runs[other]
        for i, metric in enumerate(("nMSE", "relMSE")):
            gain = gain_over(errors[other][i], against.cpu_s, errors[name][i], run.cpu_s)
            trial.figure(
                f"{case.name}: {name} vs {other}, {metric}·time",
                errors[name][i],
                metric,
                baseline=errors[other][i],
                ratios=[gain],
                goal=goals[i] if goals else None,
                cpu_s=run.cpu_s,
                other_cpu_s=against.cpu_s,
                passes=case.passes,
            )
    same = float(np.abs(base.picture.frame.image - runs["exact"].picture.frame.image).max())
    trial.check(f"{case.name}: exact passes differ from those of packets", same, 0)
    found = np.array(runs["corrected"].energies) / np.array(base.energies) - 1
    what = f"{case.name}: |t| of the energy of corrected passes"
    trial.check(what, abs(student_t(found)), LIMIT_Z)


def _goals(case: Case) -> dict[str, tuple[float, float] | None]:
    """Goals of corrected passes by rival."""
    return {"packets": case.packets, "exact": case.exact, f"{PICKS} picks": case.picks}


def bias(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """What many corrected passes have that exact ones of the same samples have not."""
    caches = {"correct": CORRECTED, "replace": PLAIN}
    light = vc.Whitted(n_vpls=case.n_vpls)
    both, mean = differences(scene, light, caches, case.many_size, case.many)
    found, plain = both["correct"], both["replace"]
    what = f"{case.name}: {case.many} corrected passes"
    trial.check(f"{what}, |z| of the energy", abs(energy_z(found)), LIMIT_MANY)
    squared, z = persistent_z(found, mean)
    trial.check(f"{what}, persistent squared error in standard errors", z, LIMIT_BIAS)
    of_plain, z_plain = persistent_z(plain, mean)
    trial.at_most(
        f"{case.name}: many passes, noise of the corrections of one pass",
        float(np.square(found).mean() / mean**2),
        "nMSE",
        None,
        persistent=squared,
        plain=of_plain,
        plain_z=z_plain,
        plain_energy_z=energy_z(plain),
        passes=case.many,
    )


def gain_over(error: float, cpu_s: float, other_error: float, other_cpu_s: float) -> float:
    """Error·time of the first over that of the other: above 1 the other is better."""
    return (error * cpu_s) / (other_error * other_cpu_s)


def errors_of(picture: vc.Progressive, references: list[vc.Frame]) -> tuple[float, float]:
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
