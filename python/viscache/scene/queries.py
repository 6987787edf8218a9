"""Queries of a ray caster with arrays of rays and segments, broadcast as in NumPy."""

from __future__ import annotations

import typing
from collections.abc import Callable
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.progress import progress_bar
from viscache.settings.checks import checked_floats, checked_points, checked_threads, require
from viscache.settings.chosen_rays import check_rays
from viscache.settings.rays import Caster, is_robust

MatrixEngine: TypeAlias = Literal["auto", "packets", "shafts"]
Floats: TypeAlias = npt.NDArray[np.float32]


class Intersection(NamedTuple):
    """Nearest hits of N rays, where N is the shape of the rays.

    Attributes
    ----------
    t : (N,) float32
        Distance in units of the direction's length; inf for a miss. Only Embree's robust rays hit a
        surface through their origin, at 0, so start rays off the surface.
    triangle : (N,) int64
        Index over the triangles of all meshes in order (instances share theirs); -1 for a miss. The
        sphere lights follow in their order, each traced as 2208 triangles.
    barycentrics : (N, 2) float32
        Weights of the triangle's vertices 1 and 2; NaN for a miss.
    instance : (N,) int64
        Index of the instance; -1 for a miss or a mesh that is not instanced.
    """

    t: npt.NDArray[np.float32]
    triangle: npt.NDArray[np.int64]
    barycentrics: npt.NDArray[np.float32]
    instance: npt.NDArray[np.int64]


def visible(
    caster: Caster, x: npt.ArrayLike, y: npt.ArrayLike, threads: int | None
) -> npt.NDArray[np.bool_]:
    """See `Scene.visible`."""
    (from_, to), shape = together(x=x, y=y)
    return caster.visible(from_, to, checked_threads(threads)).reshape(shape)


def occluded(
    caster: Any,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    t_max: float | npt.ArrayLike,
    threads: int | None,
) -> npt.NDArray[np.bool_]:
    """See `Scene.occluded`."""
    if np.ndim(t_max) == 0:
        rays, shape = together(origins=origins, directions=directions)
        ends = t_max
    else:
        ends = checked_floats(t_max, "t_max")
        rays, shape = together(ends.shape, origins=origins, directions=directions)
        ends = np.broadcast_to(ends, shape).reshape(-1)
    found: npt.NDArray[np.bool_] = caster.occluded(*rays, ends, checked_threads(threads))
    return found.reshape(shape)


def matrix(
    scene: Any,
    points: npt.ArrayLike,
    targets: npt.ArrayLike,
    rays: Any,
    engine: MatrixEngine,
    threads: int | None,
    progress: Any,
) -> npt.NDArray[np.uint64]:
    """See `Scene.visible_matrix`."""
    known = engine in typing.get_args(MatrixEngine)
    require(known, 'engine must be "auto", "packets" or "shafts"', engine)
    rays = check_rays(rays)
    robust = is_robust(rays)
    require(engine != "shafts" or robust, 'rays must be vc.Embree() with engine="shafts"', rays)
    caster = scene.caster(rays, threads=threads)
    if engine == "packets" or not robust:
        return visible_matrix(caster, points, targets, threads, progress)
    choose = engine == "auto"
    return shaft_matrix(scene.shafts(), caster, points, targets, threads, progress, choose=choose)[
        0
    ]


def intersect(
    caster: Caster, origins: npt.ArrayLike, directions: npt.ArrayLike, threads: int | None
) -> Intersection:
    """See `Scene.intersect`."""
    return Intersection(*hits(caster, origins, directions, threads))


def hits(
    caster: Any, origins: npt.ArrayLike, directions: npt.ArrayLike, threads: int | None
) -> list[npt.NDArray[Any]]:
    """A caster's arrays of nearest hits, in the shape of the rays."""
    rays, shape = together(origins=origins, directions=directions)
    found = caster.intersect(*rays, checked_threads(threads))
    return [part.reshape(*shape, *part.shape[1:]) for part in found]


def visible_matrix(
    caster: Caster,
    points: npt.ArrayLike,
    targets: npt.ArrayLike,
    threads: int | None,
    progress: bool | Callable[[int, int], None],
) -> npt.NDArray[np.uint64]:
    """See `Scene.visible_matrix`; by packets of rays."""
    ends = checked_points(points, "points"), checked_points(targets, "targets")
    with progress_bar(progress, unit="tile") as report:
        return caster.visible_matrix(*ends, checked_threads(threads), report)


def shaft_matrix(
    shafts: _core.ShaftScene,
    caster: Caster,
    points: npt.ArrayLike,
    targets: npt.ArrayLike,
    threads: int | None,
    progress: bool | Callable[[int, int], None],
    *,
    choose: bool,
) -> tuple[npt.NDArray[np.uint64], dict[str, Any]]:
    """The same bits by shafts, and what shafts did; `choose`: only where they pay."""
    ends = checked_points(points, "points"), checked_points(targets, "targets")
    with progress_bar(progress, unit="tile") as report:
        return _core.shaft_matrix(
            shafts, caster, *ends, choose=choose, threads=checked_threads(threads), progress=report
        )


def together(
    *more: tuple[int, ...], **given: npt.ArrayLike
) -> tuple[list[Floats], tuple[int, ...]]:
    """Vectors (..., 3) as rows (N, 3) of one length, and the shape (...) that they broadcast to.

    `more` has further shapes that broadcast with them. Rows of float32 are views where strides can
    express them, also with gaps between rows, or one row for all. ValueError names arrays without
    vectors, and shapes that do not broadcast.
    """
    arrays = {name: checked_points(value, name, order="K") for name, value in given.items()}
    for name, array in arrays.items():
        vectors = array.ndim >= 1 and array.shape[-1] == 3
        require(vectors, f"{name} must have shape (..., 3)", array.shape)
    try:
        shape = np.broadcast_shapes(*(array.shape[:-1] for array in arrays.values()), *more)
    except ValueError:
        shapes = [array.shape for array in arrays.values()] + list(more)
        names = " and ".join([*arrays, *["t_max"] * len(more)])
        told = " and ".join(str(s) for s in shapes)
        raise ValueError(f"{names} must have shapes that broadcast, got {told}") from None
    rows = [np.broadcast_to(array, (*shape, 3)).reshape(-1, 3) for array in arrays.values()]
    return rows, shape
