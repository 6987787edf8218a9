"""Rows of visibility bits whose columns are points instead of directions."""

from __future__ import annotations

import os
import time
import typing
from typing import Literal, TypeAlias

import numpy.typing as npt

from viscache import _core
from viscache.base.progress import Progress, progress_bar
from viscache.correlation.rows import SurfacePoints, VisibilityRows
from viscache.oracles.points import FarEnds
from viscache.oracles.sources import shafts_for
from viscache.scene import Scene
from viscache.scenes import sources
from viscache.settings.checks import checked_points, checked_threads, require
from viscache.settings.rays import Embree
from viscache.settings.source_context import SourceContext
from viscache.settings.spelling import spelled
from viscache.settings.visibility import Exact

PointEngine: TypeAlias = Literal["auto", "packets", "shafts"]


@spelled
def point_rows(
    scene: Scene | str | os.PathLike[str],
    points: SurfacePoints,
    targets: FarEnds | npt.ArrayLike,
    *,
    engine: PointEngine = "auto",
    threads: int | None = None,
    progress: Progress = False,
) -> VisibilityRows:
    """Trace which targets each point sees, one bit per target.

    As `visibility_rows`, with points in the place of directions: lamps, probes or points of other
    surfaces. A target below the tangent plane of a point is 0 by definition and costs no ray.

    Parameters
    ----------
    scene : Scene, path or str
    points : SurfacePoints
    targets : FarEnds or (M, 3) float
        `FarEnds.points` (free points, also an array) or `FarEnds.surfaces`.
    engine : {"auto", "packets", "shafts"}
        As in `Exact`. The bits do not depend on it.
    threads : int >= 1, optional
        All cores by default; the bits do not depend on it.
    progress : bool or callable
        True shows a progress bar; a callable is called with (done, total) points.

    Returns
    -------
    VisibilityRows
        `n_directions` is the number of targets. `engine` is "shafts" if they answered any queries.

    Raises
    ------
    ValueError
        A parameter is out of range, or targets are directions.
    KeyboardInterrupt
        Within half a second of Ctrl-C.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> points = vc.correlation.surface_points(scene, 100)
    >>> rows = vc.correlation.point_rows(scene, points, [(0, 3, 0), (2, 0.5, 0)])
    >>> rows.bits.shape, rows.n_directions
    ((100, 8), 2)
    """
    scene = sources.opened(scene)
    known = engine in typing.get_args(PointEngine)
    require(known, 'engine must be "auto", "packets" or "shafts"', engine)
    if not isinstance(targets, FarEnds):
        targets = FarEnds.points(checked_points(targets, "targets"))
    fits = targets.kind in ("points", "surfaces")
    require(fits, "targets must be points or surfaces", targets.kind)
    start, n_threads = time.perf_counter(), checked_threads(threads)
    exact = Exact(engine=engine)
    context = SourceContext(
        scene=scene._core,
        caster=scene.caster(threads=threads),
        shafts=shafts_for(scene, exact, Embree()),
    )
    places = checked_points(points.positions, "positions")
    normals = checked_points(points.normals, "normals")
    with progress_bar(progress, unit="point") as report:
        bits, n_rays, work = _core.correlation.point_rows(
            scene._core,
            exact.source(context),
            places,
            normals,
            targets._arrays(),
            threads=n_threads,
            progress=report,
        )
    shafts = work.get("shaft_queries", 0)
    return VisibilityRows(
        bits=bits,
        n_directions=len(targets),
        n_rays=n_rays,
        seconds=time.perf_counter() - start,
        engine="shafts" if shafts else "embree",
        reason=_reason(engine, shafts, n_rays, work),
    )


def _reason(engine: PointEngine, shafts: int, queries: int, work: dict[str, typing.Any]) -> str:
    if "no_shafts" in work:
        return str(work["no_shafts"])
    if engine != "auto":
        return "asked for"
    return f"shafts answered {shafts / max(1, queries):.0%} of {queries} queries"
