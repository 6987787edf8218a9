"""Small scenes with occlusion, and caches of them."""

from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc

Array = npt.NDArray[Any]
SIZE = (48, 32)


def clutter_arrays(seed: int = 0, n: int = 60) -> tuple[Array, Array]:
    """Triangles of all directions above a ground of one hundred squares."""
    r = np.random.default_rng(seed)
    t = np.linspace(-1, 1, 11)
    x, z = np.meshgrid(t, t)
    ground = np.stack([x.ravel(), 0 * x.ravel(), z.ravel()], 1)
    a = (np.arange(10)[:, None] * 11 + np.arange(10)).ravel()
    quads = np.stack([a, a + 11, a + 12, a, a + 12, a + 1], 1).reshape(-1, 3)
    middles = r.uniform((-0.9, 0.05, -0.9), (0.9, 0.6, 0.9), (n, 1, 3))
    leaves = middles + r.normal(0, 0.25, (n, 3, 3))
    vertices = np.concatenate([ground, leaves.reshape(-1, 3)])
    return vertices, np.concatenate([quads, len(ground) + np.arange(3 * n).reshape(-1, 3)])


def clutter(seed: int = 0, n: int = 60, scale: float = 1.0, shift: float = 0.0) -> vc.Scene:
    """The same, scaled, then moved along all axes."""
    vertices, triangles = clutter_arrays(seed, n)
    return vc.Scene.from_arrays(
        (vertices.astype(np.float32) * np.float32(scale) + np.float32(shift)), triangles
    )


def view(scale: float = 1.0, shift: float = 0.0):
    """A camera above the clutter."""
    place = tuple(np.array([1.25, 1.5, 1.75]) * scale + shift)
    target = tuple(np.array([0.0, 0.25, 0.0]) * scale + shift)
    return vc.look_at(place, target, fov_deg=36)


def made(scene: vc.Scene | None = None, size: tuple[int, int] = SIZE, camera=None, **settings):
    """A cache after one update, and the report."""
    settings = {"n_startup": 60, "d_max": 0.25} | settings
    cache = vc.VisibilityMapCache(scene or clutter(), vc.MapSettings(**settings))
    return cache, cache.update(camera or view(), size=size)


def pixels(cache: vc.VisibilityMapCache, size: tuple[int, int] = SIZE, camera=None):
    """The core's points of the image."""
    return cache._pixels(camera or view(), *size, (0.5, 0.5), 1)[0]


def same(a: vc.VisibilityMapCache, b: vc.VisibilityMapCache) -> bool:
    """Whether all arrays of two caches are equal."""
    x, y = a.records(), b.records()
    return all(
        np.array_equal(getattr(x, name), getattr(y, name)) for name in type(x).__dataclass_fields__
    )
