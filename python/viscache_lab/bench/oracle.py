"""`viscache bench oracle`: array queries and oracles written in Python, against frames."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import turns

#: Arrays may cost 10 % more than a frame's own queries; a Python oracle, 10 % of a frame.
GOAL = 0.9


class Traced:
    """An oracle written in Python that traces every requested ray."""

    def block(
        self, eyes: vc.EyePoints, lamps: vc.FarEnds, wanted: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.bool_]:
        """All of them."""
        return eyes.trace(lamps, wanted)


@BENCHES.add(
    "oracle",
    "caches asked with arrays, and oracles written in Python, beside frames",
    cases=("room?triangles=200000",),
    quick_cases=("room?triangles=20000",),
)
def oracle(trial: Trial, _: str, scene: vc.Scene) -> None:
    """A million points × 256 lights from NumPy; a frame through Python."""
    arrays(scene, trial)
    in_python(scene, trial)


def arrays(scene: vc.Scene, trial: Trial) -> None:
    """The renderer's eye points and virtual lights: queried by it, and as arrays."""
    size, light = ((96, 96), 64) if trial.quick else ((1000, 1000), 256)
    conn = vc.connections(scene, vc.Whitted(n_vpls=light), size=size)
    ends, wanted = conn.groups["vpl"], conn.wanted("vpl")
    # Without the renderer's tiles: points in another order
    shuffled = np.random.default_rng(1).permutation(len(conn.eyes))
    back = np.argsort(shuffled)
    eyes = vc.EyePoints(
        conn.eyes.positions[shuffled],
        conn.eyes.normals[shuffled],
        np.asarray(conn.eyes.density)[shuffled],
    )
    for name, visibility in {"exact": vc.Exact(), "aqvc": vc.Aqvc(c_e=10)}.items():
        ask = conn.oracle(visibility)
        runs = {
            "renderer": partial(ask.block, conn.eyes, ends, wanted),
            "arrays": partial(ask.block, eyes, ends, wanted[shuffled]),
        }
        samples, found = turns(runs, trial.repeats(3), warm_up=False)
        trial.ratio(
            f"{name} {len(eyes)} points x {len(ends)} lights arrays vs renderer's tiles",
            samples["arrays"],
            samples["renderer"],
            goal=GOAL,
            work=found["renderer"].counters["queries"],
        )
        differ = np.bitwise_count(found["arrays"].bits[back] ^ found["renderer"].bits).sum()
        share = float(differ) / max(1, found["renderer"].counters["queries"])
        limit = 0.0 if name == "exact" else 0.05
        trial.check(f"{name}: other answers than the renderer's tiles", share, limit)


def in_python(scene: vc.Scene, trial: Trial) -> None:
    """A whole exact frame, traced by the core and through an oracle written in Python."""
    size, n_vpls = ((96, 64), 64) if trial.quick else ((640, 400), 1024)
    ways: dict[str, Any] = {"core": vc.Exact(engine="packets"), "python": Traced()}
    whole = partial(vc.render, scene, vc.Whitted(n_vpls=n_vpls), size=size)
    runs = {name: partial(whole, visibility=way) for name, way in ways.items()}
    samples, frames = turns(runs, trial.repeats(3))
    trial.ratio(
        f"{size[0]}x{size[1]} {n_vpls} VPLs frame in Python vs exact",
        samples["python"],
        samples["core"],
        goal=GOAL,
    )
    same = frames["python"].sha256 == frames["core"].sha256
    trial.check("frame in Python: other bytes than exact", float(not same), 0)
