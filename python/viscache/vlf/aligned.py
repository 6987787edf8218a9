"""Aligned rays: what points see along shared directions."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache._core.vlf import embree_rows
from viscache.base.array_output import ArrayOutput
from viscache.base.progress import Progress, progress_bar
from viscache.scene import Scene
from viscache.scenes import sources
from viscache.settings.checks import checked_points, checked_threads, require
from viscache.settings.rays import Vlf
from viscache.settings.spelling import spelled
from viscache.vlf.directions import checked_directions
from viscache.vlf.field import VisibilityField

__all__ = ["AlignedRows", "Engine", "aligned_occlusion", "embree_rows", "trace_aligned"]

Engine: TypeAlias = Literal["auto", "batch", "embree", "field"]
#: Seconds to build one reference; a triangle has at least one per direction.
BUILD_REFERENCE_S = 75e-9
#: The field must be cheaper by this factor, since its prediction is accurate to a factor of 1.6.
FIELD_MARGIN = 0.6
#: Upper bound of Embree's time per ray, point by point, in all measured scenes.
MOST_EMBREE_NS = 600.0


@dataclass(frozen=True, kw_only=True, slots=True)
class AlignedRows(ArrayOutput):
    """Visibility of N points along l axes; as an array, the bits."""

    bits: npt.NDArray[np.uint64]
    """(N, ⌈l/64⌉): bit k % 64 of word k // 64 is 1 if nothing blocks the point's ray along axis k,
    on the side of its normal; padding bits are 0."""
    n_directions: int
    engine: Literal["batch", "embree", "field"]
    """The engine that traced the rays."""
    reason: str
    """Why it was chosen."""
    seconds: float
    """Wall time."""

    @property
    def n_rays(self) -> int:
        """Number of rays: one per point and axis."""
        return len(self.bits) * self.n_directions

    def _array(self) -> npt.NDArray[np.uint64]:
        return self.bits


@spelled
def aligned_occlusion(
    scene: Scene | str | os.PathLike[str],
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    n_directions: int = 513,
    t_max: float = np.inf,
    engine: Engine = "auto",
    *,
    threads: int | None = None,
    progress: Progress = False,
) -> npt.NDArray[np.uint64]:
    """Bit rows (N, ⌈l/64⌉) of visibility along shared axes: `trace_aligned(…).bits`.

    Examples
    --------
    >>> import numpy as np
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> at = vc.correlation.surface_points(scene, 100)
    >>> vc.aligned_occlusion(scene, at.positions, at.normals).shape
    (100, 9)
    """
    return trace_aligned(
        scene,
        points,
        normals,
        n_directions,
        t_max=t_max,
        engine=engine,
        threads=threads,
        progress=progress,
    ).bits


@spelled
def trace_aligned(
    scene: Scene | str | os.PathLike[str],
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    n_directions: int = 513,
    *,
    t_max: float = np.inf,
    engine: Engine = "auto",
    field: VisibilityField | None = None,
    threads: int | None = None,
    progress: Progress = False,
) -> AlignedRows:
    """Trace the rays of ambient occlusion (VLF Sec. 7): one along each axis, above the surface.

    Parameters
    ----------
    scene : Scene, path or str
    points : (N, 3) float
        Points on surfaces; rays start 8 units in the last place away (visibility/query.h).
    normals : (N, 3) float
        Unit normals on the visible side. If an axis is perpendicular to the normal, the ray runs
        along the axis.
    n_directions : int
        l of `vlf.directions`: 1, 3, 9, 33, 129, 513, 2049 or 8193.
    t_max : float > 0
        Length of the rays in scene units.
    engine : {"auto", "batch", "embree", "field"}
        "batch": for each axis, all triangles stream past all points. "embree": packets of 16 rays.
        "field": lookup in a visibility field, one tile per ray, axis by axis. "auto": the engine of
        lowest predicted cost, which depends on the scene, the points, the given field and the
        instruction set, but not on timing; `AlignedRows.reason` gives the reason. All are
        watertight. They may differ for rays within rounding error of an edge, and along triangles
        seen exactly edge-on, which the batch never hits.
    field : VisibilityField, optional
        A field of the same scene and directions, not snapped. Without one, "field" builds that of
        `Vlf(n_directions=n_directions)`, and "auto" includes its build time.
    threads : int >= 1, optional
        All cores by default; the bits do not depend on it.
    progress : bool or callable
        True shows a progress bar; a callable is called with (done, total).

    Raises
    ------
    ValueError
        An argument is out of range; for batch and field also points farther away than 1e9 times the
        scene's size.
    MemoryError
        The field does not fit its budget.
    KeyboardInterrupt
        Within half a second of Ctrl-C.
    """
    scene = sources.opened(scene)
    known = engine in get_args(Engine)
    require(known, 'engine must be "auto", "batch", "embree" or "field"', engine)
    frames = _core.vlf.direction_frames(checked_directions(n_directions))
    points, normals = checked_points(points, "points"), checked_points(normals, "normals")
    start, n_threads = time.perf_counter(), checked_threads(threads)
    _check_field(field, scene, n_directions)
    order = _core.vlf.point_order(points)
    asked = _Asked(scene, points, normals, frames, t_max, order, n_threads)
    chosen, reason = (engine, "asked for") if engine != "auto" else _choose(asked, field)
    with progress_bar(progress, unit="direction") as report:
        options: dict[str, Any] = {"t_max": t_max, "threads": n_threads, "progress": report}
        if chosen == "batch":
            options["order"] = order
            bits, _ = scene.aligned_batch().rows(scene._core, points, normals, frames, **options)
        elif chosen == "field":
            settings = Vlf(n_directions=n_directions)
            core = field._core if field else scene.caster(settings, threads=threads)
            bits = _core.vlf.field_rows(core, points, normals, frames, **options)
        else:
            options["order"] = order
            bits = embree_rows(scene.caster(), points, normals, frames, **options)
    return AlignedRows(
        bits=bits,
        n_directions=len(frames),
        engine=chosen,
        reason=reason,
        seconds=time.perf_counter() - start,
    )


class _Asked(NamedTuple):
    scene: Scene
    points: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    frames: npt.NDArray[np.float32]
    t_max: float
    order: npt.NDArray[np.uint32]
    threads: int


def _check_field(field: VisibilityField | None, scene: Scene, n_directions: int) -> None:
    if field is None:
        return
    require(isinstance(field, VisibilityField), "field must be a VisibilityField", field)
    same = field.scene is scene and field.n_directions == n_directions
    require(
        same and not field.settings.snap,
        f"field must be of the scene, of {n_directions} directions and not snapped",
        field,
    )


def _choose(
    asked: _Asked, field: VisibilityField | None
) -> tuple[Literal["batch", "embree", "field"], str]:
    scene, n_points = asked.scene, len(asked.points)
    size = f"{scene.triangles} triangles, {n_points} points"
    if _core.vlf.is_hopeless(scene._core, n_points, asked.t_max):
        return "embree", f"too few points for so many triangles: {size}"
    is_batch, batch_ns, embree_ns = scene.aligned_batch().choose(
        scene._core,
        asked.points,
        asked.normals,
        asked.frames,
        t_max=asked.t_max,
        order=asked.order,
        threads=asked.threads,
    )
    best = FIELD_MARGIN * min(batch_ns if is_batch else embree_ns, MOST_EMBREE_NS)
    field_ns, why = _predict_field(asked, field, best)
    costs = f"batch {batch_ns:.0f}, Embree {embree_ns:.0f}, field {why}"
    reason = f"predicted ns per ray: {costs} ({size})"
    if field_ns < best:
        return "field", reason
    return "batch" if is_batch else "embree", reason


def _predict_field(asked: _Asked, field: VisibilityField | None, best: float) -> tuple[float, str]:
    """Nanoseconds per ray, including a share of the build, and an explanation; inf: never."""
    scene, n_rays = asked.scene, len(asked.points) * len(asked.frames)
    if field is not None:
        cost = _core.vlf.predict_field_rows(scene._core, field._core.settings)
        return cost["ray_ns"], f"{cost['ray_ns']:.0f} ({cost['tests']:.1f} tests, built already)"
    # Lower bound for any field: one tile per ray, and each triangle in one list per direction
    share = 1e9 / max(n_rays, 1)
    least_s = BUILD_REFERENCE_S * scene.triangles * len(asked.frames)
    least = _core.vlf.FIELD_RAY_NS + least_s * share
    if least >= best:
        return np.inf, f"over {least:.0f}"
    settings = Vlf(n_directions=len(asked.frames))
    cost = _core.vlf.predict_field_rows(scene._core, settings.core())
    total = cost["ray_ns"] + cost["build_s"] * share
    parts = f"{total:.0f} ({cost['tests']:.1f} tests, {cost['build_s']:.1f} s to build"
    if cost["bytes"] > settings.max_bytes:
        return np.inf, f"{parts}, but over {cost['bytes'] / 1e6:.0f} MB)"
    return total, f"{parts})"
