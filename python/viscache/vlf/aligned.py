"""Aligned rays: what points see along directions they all share."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.checks import checked_points, checked_threads, require
from viscache.progress import progress_bar
from viscache.scene import Scene
from viscache.vlf.directions import checked_directions

__all__ = ["AlignedRows", "Engine", "aligned_occlusion", "trace_aligned"]

Engine: TypeAlias = Literal["auto", "batch", "embree"]
Progress: TypeAlias = bool | Callable[[int, int], None]


@dataclass(frozen=True, kw_only=True, slots=True)
class AlignedRows:
    """What N points see along l axes."""

    bits: npt.NDArray[np.uint64]
    """(N, ⌈l/64⌉): bit k % 64 of word k // 64 is 1 if nothing blocks the point's ray along axis k,
    on the side of its normal; padding bits are 0."""
    n_directions: int
    engine: Literal["batch", "embree"]
    """What traced the rays."""
    reason: str
    """Why it was chosen."""
    seconds: float
    """Wall time."""

    @property
    def n_rays(self) -> int:
        """One per point and axis."""
        return len(self.bits) * self.n_directions


def aligned_occlusion(
    scene: Scene,
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    n_directions: int = 513,
    t_max: float = np.inf,
    engine: Engine = "auto",
    *,
    threads: int | None = None,
    progress: Progress = False,
) -> npt.NDArray[np.uint64]:
    """Bit rows (N, ⌈l/64⌉) of what points see along shared axes: `trace_aligned(…).bits`.

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
        scene, points, normals, n_directions,
        t_max=t_max, engine=engine, threads=threads, progress=progress,
    ).bits  # fmt: skip


def trace_aligned(
    scene: Scene,
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    n_directions: int = 513,
    *,
    t_max: float = np.inf,
    engine: Engine = "auto",
    threads: int | None = None,
    progress: Progress = False,
) -> AlignedRows:
    """Ambient occlusion's rays of the paper's Sec. 7: one along each axis, above the surface.

    Parameters
    ----------
    scene : Scene
    points : (N, 3) float
        On surfaces; rays start 8 units in the last place off them (visibility/query.h).
    normals : (N, 3) float
        Unit, on the side that looks. Of an axis at right angles to the normal, the ray runs along
        it.
    n_directions : int
        l of `vlf.directions`: 1, 3, 9, 33, 129, 513, 2049 or 8193.
    t_max : float > 0
        How far the points look, in scene units.
    engine : {"auto", "batch", "embree"}
        "batch": per axis, all triangles stream past all points. "embree": packets of 16 rays.
        "auto": the one of less predicted cost, which depends on scene, points and the
        instruction set, not on time; `AlignedRows.reason` says why. Both are watertight; they may
        differ for rays within rounding of an edge, and along triangles seen exactly edge-on,
        which the batch never hits.
    threads : int >= 1, optional
        All cores by default; the bits do not depend on it.
    progress : bool or callable
        True shows a bar; a callable gets (done, total).

    Raises
    ------
    ValueError
        An argument out of range; for the batch also points 1e9 times the scene's size away.
    KeyboardInterrupt
        Within half a second of Ctrl-C.
    """
    require(isinstance(scene, Scene), "scene must be a Scene", scene)
    known = engine in ("auto", "batch", "embree")
    require(known, 'engine must be "auto", "batch" or "embree"', engine)
    frames = _core.vlf.direction_frames(checked_directions(n_directions))
    points, normals = checked_points(points, "points"), checked_points(normals, "normals")
    start, n_threads = time.perf_counter(), checked_threads(threads)
    chosen, reason = _choose(scene, engine, points, normals, frames, t_max, n_threads)
    with progress_bar(progress, unit="direction") as report:
        if chosen == "batch":
            bits, _ = scene.aligned_batch().rows(
                scene._core, points, normals, frames,
                t_max=t_max, threads=n_threads, progress=report,
            )  # fmt: skip
        else:
            bits = _core.vlf.embree_rows(
                scene.caster(), points, normals, frames,
                t_max=t_max, threads=n_threads, progress=report,
            )  # fmt: skip
    return AlignedRows(
        bits=bits,
        n_directions=len(frames),
        engine=chosen,
        reason=reason,
        seconds=time.perf_counter() - start,
    )


def _choose(
    scene: Scene,
    engine: Engine,
    points: npt.NDArray[np.float32],
    normals: npt.NDArray[np.float32],
    frames: npt.NDArray[np.float32],
    t_max: float,
    threads: int,
) -> tuple[Literal["batch", "embree"], str]:
    if engine != "auto":
        return engine, "asked for"
    size = f"{scene.triangles} triangles, {len(points)} points"
    if _core.vlf.is_hopeless(scene.triangles, len(points)):
        return "embree", f"too few points for so many triangles: {size}"
    is_batch, batch_ns, embree_ns = scene.aligned_batch().choose(
        scene._core, points, normals, frames, t_max=t_max, threads=threads
    )
    reason = f"predicted ns per ray: batch {batch_ns:.0f}, Embree {embree_ns:.0f} ({size})"
    return "batch" if is_batch else "embree", reason
