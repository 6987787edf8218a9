"""`viscache bench which-cache`: which way wins where, by error times time of passes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import viscache as vc
from viscache.passes.over_time import gain
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import student_t

#: Limit of |t| of the energy against exact passes; it has 7 degrees of freedom.
LIMIT_T = 6.0
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


def ways(case: Case, edge: float = 1.0) -> tuple[Any, dict[str, dict[str, Any]]]:
    """The integrator of the references, and the ways, the baseline first; edge of `Cells`."""
    exact = {"visibility": vc.Exact()}
    voxels = {
        "nee++, roulette": {"visibility": vc.NeePlusPlus(), "use": "replace"},
        "nee++, corrected": {"visibility": vc.NeePlusPlus(), "use": "correct"},
    }
    if case.sky:
        light: Any = vc.Direct(n_environment=case.n_environment, n_brdf=0)
        product = replace(light, environment="product")
        own = {
            "exact": exact,
            "product sampling": {**exact, "integrator": product},
            "maps": {"visibility": vc.VisMaps(), "use": "correct"},
        } | voxels
        # The noise of plain samples of a sky through a window is too large
        fine = replace(product, n_environment=2 * case.n_environment)
        return fine, {name: {"integrator": light, **way} for name, way in own.items()}
    many = vc.Whitted(n_vpls=case.n_vpls)
    corrected = {"visibility": vc.Aqvc(), "use": "correct"}
    return many, {
        "exact": exact,
        "aqvc, corrected": corrected,
        "16 picks": {**exact, "integrator": replace(many, pick=16)},
        "64 picks, corrected": {**corrected, "integrator": replace(many, pick=64)},
        "oracle in Python": {"visibility": Cells(edge), "use": vc.Correct(share=0.1)},
        **voxels,
    }


@BENCHES.add(
    "which-cache",
    "which way wins where: error times time of passes over 14 pictures",
    cases=CASES,
    quick_cases=QUICK,
    note="A ratio is MSE·CPU time of vc.Exact() over that of the way, with the interval that the"
    " 95 % ones of both errors, over blocks of the picture, give; gain_rel has squared errors"
    " relative to each pixel. Light that the camera sees directly is left out. Two references of"
    " exact passes: their noise cancels. Ways take turns pass by pass.",
)
def which_cache(trial: Trial, case: Case, scene: vc.Scene) -> None:
    """MSE·time of exact passes over that of every other way, scene by scene."""
    edge = EDGE * float(np.linalg.norm(np.ptp(scene.bounds, axis=0)))
    light, settings = ways(case, edge)
    vc.Progressive(
        scene, settings["exact"].get("integrator", light), visibility="exact", size=case.size
    ).passes(1)  # builds the trees
    ds = vc.passes_over_time(scene, light, settings, passes=case.passes, size=case.size)
    label = f"{case.name}, sky" if case.sky else case.name
    for name in list(settings)[1:]:
        gain_figure(trial, f"{label}: {name} vs exact", ds, name)
        exact, ours = (1 + ds["energy"].sel(setting=n) for n in ("exact", name))
        trial.check(
            f"{label}: {name}, |t| of the energy", abs(student_t(ours / exact - 1)), LIMIT_T
        )


def gain_figure(trial: Trial, what: str, ds: Any, name: str) -> None:
    """Squared error · CPU seconds of exact passes over that of a way, with its interval."""
    last = ds.drop_dims("row").isel({"pass": -1})
    exact, ours = ({k: float(v) for k, v in last.sel(setting=n).items()} for n in ("exact", name))
    ratio = gain(ds, name)
    widths = [(e["nmse_high"] - e["nmse"]) / e["nmse"] for e in (exact, ours)]
    spread = math.exp(math.hypot(*widths))
    trial.figure(
        what,
        ours["nmse"],
        "nMSE",
        baseline=exact["nmse"],
        ratios=[ratio / spread, ratio, ratio * spread],
        gain_rel=gain(ds, name, error="rel_mse"),
        cpu_s=ours["cpu_s"],
        exact_cpu_s=exact["cpu_s"],
        passes=ds.sizes["pass"],
    )
