"""Stacks of frames of independent seeds, by Mitsuba 3 and by viscache."""

import numpy as np
import numpy.typing as npt

import viscache as vc
from render.ztest import ROUNDING, compare
from viscache.testing.student import blocks

SIZE = (48, 32)
Images = npt.NDArray[np.float64]


def theirs(
    mi, scene, *, depth: int = 2, spp: int = 16, seeds: int = 64, first: int = 100, **kwargs
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
    integrator=None,
    *,
    spp: int = 16,
    seeds: int = 48,
    size: tuple[int, int] = SIZE,
    first: int = 0,
    layer: str = "color",
) -> Images:
    """Frames of seeds `first`, `first` + 1, …, or one layer of them; 0 where it is not there."""
    given = {"size": size, "spp": spp}
    lights = integrator or vc.Direct()
    frames = [vc.render(scene, lights, seed=first + i, **given) for i in range(seeds)]
    assert all(f.counters["non_finite"] == 0 for f in frames)
    dark = np.zeros_like(frames[0].image)
    return np.stack([f.layers.get(layer, dark) for f in frames]).astype(np.float64)


def assert_same(
    a: Images, b: Images, tolerance: float = ROUNDING, *, edge: int = 1, power: float = 0.01
) -> None:
    """The z-test passes, and a hundredth less energy (`power`) makes it fail.

    Its smallest cells are edge × edge pixels. A single pixel may see some light so seldom that all
    frames of one side miss it: then they have no variance, and noise looks like a difference.
    """
    a, b = blocks(a, edge), blocks(b, edge)
    found = compare(a, b, edge=8 // edge, tolerance=tolerance)
    assert found.same, found
    less = compare((1 - power) * a, b, edge=8 // edge, tolerance=tolerance)
    assert not less.same, f"the test has no power to see {power:.0%} of the energy"


def area_layers(scene: vc.Scene, integrator, **options) -> Images:
    """Light of area lights alone, without what is seen directly."""
    given = {"spp": 4, "seeds": 6, "size": (24, 16)} | options
    return ours(scene, integrator, layer="area", **given)
