"""Stacks of frames of independent seeds, by Mitsuba 3 and by viscache."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from render.ztest import ROUNDING, compare
from viscache.testing.student import blocks

SIZE = (48, 32)
Images = npt.NDArray[np.float64]


def theirs(
    mi: Any,
    scene: Any,
    *,
    depth: int = 2,
    spp: int = 16,
    seeds: int = 64,
    first: int = 100,
    **kwargs: Any,
) -> Images:
    """Mitsuba's `path`; a `max_depth` of 2 is direct light."""
    path = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 1000})
    shots = [
        np.array(mi.render(scene, integrator=path, spp=spp, seed=first + i, **kwargs))
        for i in range(seeds)
    ]
    return np.stack(shots).astype(np.float64)[..., :3]


def ours(
    scene: vc.Scene,
    integrator: Any = None,
    *,
    spp: int = 16,
    seeds: int = 48,
    size: tuple[int, int] = SIZE,
) -> Images:
    """Frames of seeds 0, 1, …"""
    integrator = integrator or vc.Direct()
    frames = [vc.render(scene, integrator, size=size, spp=spp, seed=i) for i in range(seeds)]
    assert all(f.counters["non_finite"] == 0 for f in frames)
    return np.stack([f.image for f in frames]).astype(np.float64)


def assert_same(a: Images, b: Images, tolerance: float = ROUNDING, *, edge: int = 1) -> None:
    """The z-test passes, and 1 % less energy makes it fail.

    Its smallest cells are edge × edge pixels. A single pixel may see some light so seldom that all
    frames of one side miss it: then they have no variance, and noise looks like a difference.
    """
    a, b = blocks(a, edge), blocks(b, edge)
    found = compare(a, b, edge=8 // edge, tolerance=tolerance)
    assert found.same, found
    assert not compare(0.99 * a, b, edge=8 // edge, tolerance=tolerance).same, (
        "the test has no power to see 1 % of the energy"
    )


def area_layers(
    scene: vc.Scene,
    integrator: Any,
    *,
    spp: int = 4,
    seeds: int = 6,
    size: tuple[int, int] = (24, 16),
    first: int = 0,
) -> Images:
    """Light of area lights alone, without what is seen directly."""
    frames = [
        vc.render(scene, integrator, size=size, spp=spp, seed=first + i) for i in range(seeds)
    ]
    assert all(f.counters["non_finite"] == 0 for f in frames)
    return np.stack([f.layers["area"] for f in frames]).astype(np.float64)
