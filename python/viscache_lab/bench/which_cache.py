"""`viscache bench which-cache`: which way wins where, by error times time of passes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.bench.errors import Run, take_turns
from viscache_lab.bench.progressive import FIRST_OF_REFERENCES
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import figure, student_t

Array = npt.NDArray[np.float64]

#: Limit of |t| of the energy against exact passes; it has 7 degrees of freedom.
LIMIT_T = 6.0
#: Floor of the relative error, as a share of the picture's mean.
DARK = 0.05
#: Edge of the blocks of pixels that a bootstrap draws.
BLOCK = 16
BOOTSTRAP = 400
#: Edge of the Python oracle's cells, as a share of the scene's diagonal.
EDGE = 1 / 64


@dataclass(frozen=True)
class Case:
    """A picture, of many shared lights or of an environment."""

    name: str
    scene: str
    sky: bool = False
    size: tuple[int, int] = (128, 128)
    n_vpls: int = 1024
    n_environment: int = 16
    passes: int = 8


CASES = (
    Case("room", "room?triangles=200000"),
    Case("apartment", "apartment?triangles=300000"),
    Case("conference", "conference"),
    Case("church", "church"),
    Case("classroom_like", "classroom_like"),
    Case("garage", "garage"),
    Case("living-room", "living-room/scene.xml"),
    Case("sponza", "sponza-dabrovic/scene.xml"),
    Case("classroom", "classroom/scene.xml"),
    Case("window_room", "window_room", sky=True),
    Case("garage", "garage", sky=True),
    Case("mushrooms", "mushrooms", sky=True),
    Case("living-room", "living-room/scene.xml", sky=True),
    Case("classroom", "classroom/scene.xml", sky=True),
)
QUICK = (
    Case("room", "room?triangles=3000", size=(48, 32), n_vpls=64, passes=4),
    Case("window_room", "window_room", sky=True, size=(48, 32), n_environment=4, passes=4),
)


@BENCHES.add("which-cache", "which way wins where: error times time of passes over 14 pictures")
def which_cache(trial: Trial) -> None:
    """MSE·time of exact passes over that of every other way, scene by scene."""
    for case, scene in trial.scenes(QUICK if trial.quick else CASES):
        measure(trial, case, scene)
    trial.notes.append(
        "A ratio is MSE·CPU time of vc.Exact() over that of the way, with the 95 % interval of a"
        " bootstrap over blocks of pixels; gain_rel has squared errors relative to each pixel."
        " Light that the camera sees directly is left out. Two references of exact passes: their"
        " noise cancels. Ways take turns pass by pass."
    )


@dataclass(frozen=True)
class Cells:
    """An oracle as users write it: one eye point asks for all in a cell of space."""

    edge: float

    def block(self, eyes: Any, lamps: Any, wanted: Any) -> Any:
        """The answers of the first eye point of each cell and facing."""
        facing = np.argmax(np.abs(eyes.normals), axis=1)
        key = np.column_stack([np.floor(eyes.positions / self.edge), facing])
        _, first, cell = np.unique(key, axis=0, return_index=True, return_inverse=True)
        asked = np.zeros((len(first), len(lamps)), dtype=bool)
        np.logical_or.at(asked, cell.ravel(), wanted)
        return eyes[first].trace(lamps, asked)[cell.ravel()]


def ways(case: Case, edge: float = 1.0) -> dict[str, tuple[Any, Any, Any]]:
    """(integrator, visibility, use) of each way; the first is the baseline.

    `edge` is that of the cells of the oracle in Python.
    """
    voxels = {
        "nee++, roulette": (vc.NeePlusPlus(), "replace"),
        "nee++, corrected": (vc.NeePlusPlus(), "correct"),
    }
    if case.sky:
        light: Any = vc.Direct(n_environment=case.n_environment, n_brdf=0)
        return {
            "exact": (light, vc.Exact(), None),
            "product sampling": (replace(light, environment="product"), vc.Exact(), None),
            "maps": (light, vc.VisMaps(), "correct"),
            **{name: (light, *way) for name, way in voxels.items()},
        }
    many = vc.Whitted(n_vpls=case.n_vpls)
    return {
        "exact": (many, vc.Exact(), None),
        "aqvc, corrected": (many, vc.Aqvc(), "correct"),
        "16 picks": (replace(many, pick=16), vc.Exact(), None),
        "64 picks, corrected": (replace(many, pick=64), vc.Aqvc(), "correct"),
        "oracle in Python": (many, Cells(edge), vc.Correct(share=0.1)),
        **{name: (many, *way) for name, way in voxels.items()},
    }


def measure(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """Let the ways take turns pass by pass."""
    runs: dict[str, Run] = {}
    baseline = ways(case)["exact"][0]
    vc.Progressive(scene, baseline, visibility="exact", size=case.size).passes(
        1
    )  # builds the trees
    low, high = scene.bounds
    edge = EDGE * float(np.linalg.norm(np.subtract(high, low)))
    for name, (light, visibility, use) in ways(case, edge).items():
        made = vc.Progressive(scene, light, visibility=visibility, use=use, size=case.size)
        runs[name] = Run(made)
    take_turns(list(runs.values()), case.passes)
    light = ways(case)["exact"][0]
    if case.sky:  # the noise of plain samples of a sky through a window is too large
        light = replace(light, environment="product", n_environment=2 * case.n_environment)
    references = [
        reflected(vc.Progressive(scene, light, visibility="exact", size=case.size, first_pass=n),
                  case.passes)
        for n in FIRST_OF_REFERENCES
    ]  # fmt: skip
    squares = {name: squared(reflected(run.picture), references) for name, run in runs.items()}
    base = runs["exact"]
    label = f"{case.name}, sky" if case.sky else case.name
    for name, run in runs.items():
        if name == "exact":
            continue
        what = f"{label}: {name} vs exact"
        seconds = (base.cpu_s, run.cpu_s)
        trial.figures.append(
            gain_figure(what, squares["exact"], squares[name], seconds, case.passes)
        )
        found = np.array(run.energies) / np.array(base.energies) - 1
        trial.check(f"{label}: {name}, |t| of the energy", abs(student_t(found)), LIMIT_T)


def gain_figure(
    what: str,
    exact: tuple[Array, Array],
    ours: tuple[Array, Array],
    seconds: tuple[float, float],
    passes: int,
) -> dict[str, Any]:
    """Squared error · CPU seconds of exact passes over that of ours, with intervals."""
    faster = seconds[0] / seconds[1]
    gains = [intervals(exact[i], ours[i]) for i in range(2)]
    return figure(
        what,
        float(ours[0].mean()),
        "nMSE",
        baseline=float(exact[0].mean()),
        ratios=sorted(faster * g for g in gains[0]),
        gain_rel=faster * gains[1][1],
        rel_low=faster * gains[1][0],
        rel_high=faster * gains[1][2],
        cpu_s=seconds[1],
        exact_cpu_s=seconds[0],
        passes=passes,
    )


def reflected(picture: vc.Progressive, passes: int = 0) -> Array:
    """Light on surfaces, after some more passes."""
    frame = picture.passes(passes)
    return np.asarray(frame.image, np.float64) - frame.layers["emitted"]


def squared(image: Array, references: list[Array]) -> tuple[Array, Array]:
    """Squared errors by block of pixels, of the mean and relative to each pixel.

    A square is the product of the differences to two independent references, whose noise is not in
    its expectation.
    """
    first, second = references
    squares, truth = (image - first) * (image - second), (first + second) / 2
    mean = truth.mean()
    return blocks(squares / mean**2), blocks(squares / (truth**2 + (DARK * mean) ** 2))


def blocks(pixels: Array) -> Array:
    """Means of BLOCK × BLOCK pixels in a row."""
    h, w = (n // BLOCK * BLOCK for n in pixels.shape[:2])
    cut = pixels[:h, :w].reshape(h // BLOCK, BLOCK, w // BLOCK, BLOCK, -1)
    return np.asarray(cut.mean(axis=(1, 3, 4)).ravel())


def intervals(exact: Array, ours: Array) -> tuple[float, float, float]:
    """(low, value, high) of the quotient of the means."""
    chosen = np.random.default_rng(0).integers(0, len(ours), (BOOTSTRAP, len(ours)))
    value = float(exact.mean() / ours.mean())
    drawn = exact[chosen].mean(axis=1) / ours[chosen].mean(axis=1)
    low, high = np.quantile(drawn, [0.025, 0.975])
    return min(float(low), value), value, max(float(high), value)
