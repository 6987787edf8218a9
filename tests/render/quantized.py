"""Frames with the quantized cache and with a ray per query, for the tests beside this file."""

from functools import cache

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.settings.by_name import replaced
from viscache_lab.extremes.moved import description_of
from viscache_lab.extremes.scenes import lit_box

__all__ = ["description_of", "lit_box"]

Image = npt.NDArray[np.float32]

SIZE = (80, 50)
#: Every way of answering the groups of shared lights.
FORMS = {
    "waves": {"form": "waves"},
    "pairs-table": {"form": "pairs", "storage": "table", "table_bytes": 64 << 20},
    "pairs-exact": {"form": "pairs", "storage": "exact"},
}
#: Light that is the same for all pixels.
SHARED = vc.Whitted(n_vpls=24, n_area=0, n_environment=0, n_brdf=0)


def rel_l1(image: Image, reference: Image) -> float:
    """Σ|a − b| / Σb."""
    a, b = np.asarray(image, np.float64), np.asarray(reference, np.float64)
    return float(np.abs(a - b).sum() / b.sum())


def energy(image: Image, reference: Image) -> float:
    """Σ(a − b) / Σb."""
    a, b = np.asarray(image, np.float64), np.asarray(reference, np.float64)
    return float((a - b).sum() / b.sum())


def render(scene: vc.Scene, integrator=None, *, size: tuple[int, int] = SIZE, **aqvc) -> vc.Frame:
    """A frame with these parameters of `Aqvc` and of its `paper`; every light group is cached.

    `spp`, `seed`, `threads`, `camera` go to `vc.render`.
    """
    passed = {n: aqvc.pop(n) for n in ("spp", "seed", "threads", "camera") if n in aqvc}
    visibility = replaced(vc.Aqvc(exact_groups=()), aqvc, "visibility")
    return vc.render(scene, integrator or SHARED, visibility=visibility, size=size, **passed)


@cache
def exact(scene: vc.Scene, integrator=SHARED, size: tuple[int, int] = SIZE, **passed) -> vc.Frame:
    """The same frame with a ray per query; made once."""
    return vc.render(scene, integrator, visibility=vc.Exact(), size=size, **passed)


@cache
def scene(name: str, **parameters) -> vc.Scene:
    """A built-in scene; made once."""
    return getattr(vc.scenes, name)(**parameters)
