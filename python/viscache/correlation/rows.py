"""Points on surfaces, and one row of visibility bits for each point."""

from __future__ import annotations

import os
import time
import typing
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.array_output import ArrayOutput
from viscache.base.progress import Progress, progress_bar
from viscache.correlation.directions import DirectionSet as DirectionSet
from viscache.scene import Scene
from viscache.scene.cameras import find_camera
from viscache.scenes import sources
from viscache.settings.checks import checked_points, checked_threads, is_whole, require
from viscache.settings.rays import Embree, Vlf
from viscache.settings.spelling import spelled

Floats: TypeAlias = npt.NDArray[np.float32]
RowEngine: TypeAlias = Literal["embree", "batch", "field", "auto"]

N_GROUPS = 16


@dataclass(frozen=True, kw_only=True, slots=True)
class SurfacePoints:
    """N points on the surfaces of a scene, sorted by group, in random order within a group."""

    positions: Floats
    """(N, 3), in scene units."""
    normals: Floats
    """(N, 3), unit geometric normals; visibility is that of their hemispheres."""
    theta_normals: Floats
    """(N, 3), unit normals between which the angle θ is measured."""
    group: npt.NDArray[np.int32]
    """(N,) in [0, 16): compact spatial groups whose sizes differ by at most one."""
    stratum: npt.NDArray[np.uint32]
    """(N,), unique: pixel y·width + x of the camera's image, or index along the surfaces."""
    width: int
    """Columns of the camera's image; for area-uniform points the number of strata."""
    height: int
    """Rows of the camera's image; 1 for area-uniform points."""
    n_bad_normals: int
    """Strata skipped because their triangle is degenerate."""
    n_misses: int
    """Strata skipped because there is no surface, or a hole cut by an alpha mask."""


@dataclass(frozen=True, kw_only=True, slots=True)
class VisibilityRows(ArrayOutput):
    """What N points see of a set of T directions, or of T points; as an array, the bits."""

    bits: npt.NDArray[np.uint64]
    """(N, W), W a multiple of 8: bit k % 64 of word k // 64 is 1 if direction k is free; the
    lower hemisphere and the padding are 0."""
    n_directions: int
    """T."""
    n_rays: int
    """Number of queries: the directions, or points, above the tangent planes."""
    seconds: float
    """Wall time."""
    engine: Literal["embree", "batch", "field", "shafts"]
    """The engine that answered them."""
    reason: str
    """Why it was chosen."""

    def _array(self) -> npt.NDArray[np.uint64]:
        return self.bits


@spelled
def surface_points(
    scene: Scene | str | os.PathLike[str],
    n_points: int,
    *,
    points: Literal["camera", "area"] = "camera",
    camera: str | int | _core.Camera | None = None,
    seed: int = 0,
    normals: Literal["geometric", "shading"] = "geometric",
    threads: int | None = None,
) -> SurfacePoints:
    """Distribute points over the surfaces of a scene.

    Geometry alone defines a surface: mirrors and glass are included; holes of alpha masks and the
    spheres of sphere lights are not.

    Parameters
    ----------
    scene : Scene, path or str
    n_points : int in [16, 2^26]
    points : {"camera", "area"}
        Primary hits of a camera, one at a random position in each pixel of an image that is just
        fine enough; or points uniform over the area of all placed triangles.
    camera : str, int or Camera, optional
        As in `viscache.render`. Normals face the camera; those of "area" follow the winding of the
        triangles.
    seed : int >= 0
        The same seed gives the same points for any number of threads.
    normals : {"geometric", "shading"}
        Normals for the angle θ; visibility always uses the geometric normals.
    threads : int, optional
        All cores by default.

    Returns
    -------
    SurfacePoints

    Raises
    ------
    ValueError
        A parameter is out of range, or surfaces fill less than 1/1024 of the camera's image.

    Examples
    --------
    >>> import viscache as vc
    >>> found = vc.correlation.surface_points(vc.scenes.cube_on_plane(), 100)
    >>> found.positions.shape, int(found.group.max())
    ((100, 3), 15)
    """
    scene = sources.opened(scene)
    fits = is_whole(n_points) and N_GROUPS <= n_points <= 1 << 26
    require(fits, f"n_points must be a whole number in [{N_GROUPS}, 2^26]", n_points)
    require(is_whole(seed) and 0 <= seed < 1 << 64, "seed must be in [0, 2^64)", seed)
    require(points in ("camera", "area"), 'points must be "camera" or "area"', points)
    known = normals in ("geometric", "shading")
    require(known, 'normals must be "geometric" or "shading"', normals)
    if points == "camera":
        view = find_camera(scene, camera)
        found = _core.correlation.camera_points(
            scene._core, scene.caster(), view, n_points, seed, checked_threads(threads)
        )
    else:
        require(camera is None, 'camera must be left out with points="area"', camera)
        found = _core.correlation.area_points(scene._core, n_points, seed)
    return SurfacePoints(
        positions=found["position"],
        normals=found["normal"],
        theta_normals=found["shading_normal" if normals == "shading" else "normal"],
        group=found["group"],
        stratum=found["stratum"],
        width=found["width"],
        height=found["height"],
        n_bad_normals=found["bad_normals"],
        n_misses=found["misses"],
    )


def spatial_groups(positions: npt.ArrayLike) -> npt.NDArray[np.int32]:
    """Spatial groups in [0, 16) of points (N, 3), as in `surface_points`."""
    return _core.correlation.spatial_groups(checked_points(positions, "positions"))


@spelled
def visibility_rows(
    scene: Scene | str | os.PathLike[str],
    points: SurfacePoints,
    directions: DirectionSet,
    *,
    t_max: float = np.inf,
    engine: RowEngine = "embree",
    threads: int | None = None,
    progress: Progress = False,
) -> VisibilityRows:
    """Trace the visibility function V(x, ω) of points, one bit per direction.

    Parameters
    ----------
    scene : Scene, path or str
    points : SurfacePoints
    directions : DirectionSet
    t_max : float > 0
        Length of the rays in scene units.
    engine : {"embree", "batch", "field", "auto"}
        "batch": direction by direction, opposite ones together, all triangles stream past all
        points (VLF Sec. 7). This pays off if there are at least about as many points as triangles.
        "field": single rays through `Vlf()`. "auto": batch or Embree, by predicted cost, which
        depends on the scene, the points and the instruction set, but not on timing. All are exact;
        they may differ for rays within rounding error of an edge.
    threads : int >= 1, optional
        All cores by default; the bits do not depend on it.
    progress : bool or callable
        True shows a progress bar; a callable is called with (done, total) points.

    Raises
    ------
    ValueError
        A parameter is out of range; for the batch also points farther away than 1e9 times the
        scene's size.
    MemoryError
        The field does not fit the budget of `Vlf()`.
    KeyboardInterrupt
        Within half a second of Ctrl-C.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> points = vc.correlation.surface_points(scene, 100)
    >>> rows = vc.correlation.visibility_rows(scene, points, vc.correlation.DirectionSet())
    >>> rows.bits.shape, rows.n_rays
    ((100, 144), 460800)
    """
    return trace_rows(
        scene,
        points.positions,
        points.normals,
        directions,
        t_max=t_max,
        engine=engine,
        threads=threads,
        progress=progress,
    )


def trace_rows(
    scene: Scene | str | os.PathLike[str],
    positions: npt.ArrayLike,
    normals: npt.ArrayLike,
    directions: DirectionSet,
    *,
    t_max: float = np.inf,
    engine: RowEngine = "embree",
    threads: int | None = None,
    progress: Progress = False,
) -> VisibilityRows:
    """`visibility_rows` for any points (N, 3) on surfaces with unit normals (N, 3)."""
    scene = sources.opened(scene)
    require(isinstance(directions, DirectionSet), "directions must be a DirectionSet", directions)
    known = engine in typing.get_args(RowEngine)
    require(known, 'engine must be "embree", "batch", "field" or "auto"', engine)
    start, n_threads = time.perf_counter(), checked_threads(threads)
    points = checked_points(positions, "positions"), checked_points(normals, "normals")
    asked = (*points, directions.directions)
    with progress_bar(progress, unit="point") as report:
        more: _More = {"t_max": t_max, "threads": n_threads, "progress": report}
        hopeless = engine == "auto" and _core.vlf.is_hopeless(scene._core, len(points[0]), t_max)
        if engine in ("embree", "field") or hopeless:
            caster = scene.caster(Vlf() if engine == "field" else Embree(), threads=threads)
            bits, n_rays = _core.correlation.visibility_rows(scene._core, caster, *asked, **more)
            by: Literal["embree", "batch", "field"] = "field" if engine == "field" else "embree"
            costs = (0.0, 0.0)
        else:
            bits, n_rays, is_batch, batch_ns, embree_ns = _core.correlation.aligned_rows(
                scene._core,
                scene.aligned_batch(),
                scene.caster(),
                *asked,
                choose=engine == "auto",
                **more,
            )
            by, costs = "batch" if is_batch else "embree", (batch_ns, embree_ns)
    return VisibilityRows(
        bits=bits,
        n_directions=len(directions.directions),
        n_rays=n_rays,
        seconds=time.perf_counter() - start,
        engine=by,
        reason="asked for" if engine != "auto" else _reason(scene, len(points[0]), *costs),
    )


class _More(typing.TypedDict):
    t_max: float
    threads: int
    progress: Callable[[int, int], None] | None


def _reason(scene: Scene, n_points: int, batch_ns: float, embree_ns: float) -> str:
    size = f"{scene.triangles} triangles, {n_points} points"
    if embree_ns == 0:
        return f"too few points for so many triangles, or too far away: {size}"
    return f"predicted ns per ray: batch {batch_ns:.0f}, Embree {embree_ns:.0f} ({size})"
