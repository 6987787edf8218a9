"""Correlation of visibility (visibility-map paper, Section 4): a scene, or any rows of bits."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from viscache.base.array_digests import content_key
from viscache.base.progress import Progress, progress_bar
from viscache.base.provenance import VERSION
from viscache.correlation import pairs as _pairs
from viscache.correlation import rows as _rows
from viscache.correlation.arguments import (
    MeasureKeywords,
    MeasureSettings,
    PairKeywords,
    PairSettings,
    checked_rows,
    checked_words,
    digest,
)
from viscache.correlation.dataset import to_dataset
from viscache.correlation.local_means import add_local_means
from viscache.correlation.reach import closed_reach
from viscache.correlation.run import Run
from viscache.correlation.tasks import Points, RowsTask, trace, trace_in_worker, write_points
from viscache.correlation.work import BATCH_ROWS_PER_BLOCK
from viscache.correlation.work_store import Arrays
from viscache.scene.cameras import find_camera
from viscache.scenes import sources
from viscache.settings.checks import require
from viscache.settings.spelling import keywords_of, spelled

if TYPE_CHECKING:
    import xarray
    from typing_extensions import Unpack


@spelled
@keywords_of(MeasureSettings)
def measure(
    scene: Any,
    *,
    directory: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
    progress: Progress = False,
    **settings: Unpack[MeasureKeywords],
) -> xarray.Dataset:
    """Correlation of visibility between points of a scene, over distance d and angle θ.

    Parameters
    ----------
    scene : Scene, path or str
        A string is a file or a built-in name (`room?triangles=200000`).
    n_points : int >= 16
        Number of points on surfaces. 195,000 points with all pairs give the 1.9·10¹⁰ estimates of
        the paper.
    map_size : int
        Edge of the map of directions; 96 as in the paper (96×96).
    pairs : "all" or int
        All pairs, or about this many in random tiles. In the second case all near pairs are counted
        in a separate exhaustive pass, and no bin mixes the two passes (`d_near`).
    points : "camera" or "area", optional
        Points seen by a camera, or points uniform over all surfaces. By default the camera if there
        is one.
    camera : str, int or Camera, optional
        As in `viscache.render`.
    seed : int >= 0
        The same seed gives the same bytes for any number of threads and any executor.
    d_edges : int or (D + 1,) float
        Edges in scene units, or a number of even bins over [0, d_max], the last one without end.
    theta_edges_deg : int or (T + 1,) float
        Edges in degrees, or a number of even bins over 180°.
    d_max : float > 0, optional
        End of evenly spaced bins. By default the 99th percentile of the pair distances of a pilot
        sample.
    slice_d, slice_theta_deg : float
        Limits of the slices: pairs with d < slice_d over θ, and pairs with θ < slice_theta_deg over
        d.
    directions : "centres", "jittered" or "lloyd"
        Position of a direction in its cell of the map.
    domain : "sphere", "joint" or "union"
        Directions over which ρ is taken: all (as in the paper), those above both tangent planes, or
        those above at least one.
    normals : "geometric" or "shading"
        Normals for the angle θ. The hemisphere of a point is always that of the geometric normal.
    undefined : "skip" or "one_if_both"
        How to count a pair if a point sees nothing: skip the pair, or take ρ = 1 if both points see
        nothing.
    min_bits : int >= 1
        A row with fewer visible directions has no ρ.
    t_max : float > 0 or "auto"
        Length of the rays: farther occluders are ignored (local visibility). inf: visibility of the
        sky. "auto": inf, but in a closed scene, whose points see no sky, the median free path of a
        pilot's rays. The attribute `t_max` has the number, and `t_max_by` who chose it: "caller",
        "open scene" or "closed scene".
    engine : {"embree", "batch", "field", "auto"}
        Engine that traces the rows, as in `visibility_rows`. The attribute "batch_rays" is the
        number of rays that the batch traced.
    directory : path, optional
        Folder for finished blocks. An interrupted run resumes from it and repeats nothing.
    executor : concurrent.futures.Executor, optional
        Computes the blocks; this process merges them. Its workers must have access to the folder of
        the store (a temporary one by default). They open the scene themselves, so `scene` must be a
        file or a built-in name. Use `threads=1` if the workers share a machine.
    threads : int, optional
        Threads per block; all cores by default.
    progress : bool or callable
        True shows a progress bar; a callable is called with (done, total) blocks.

    Returns
    -------
    xarray.Dataset
        See `viscache.correlation.dataset.to_dataset`.

    Raises
    ------
    ValueError
        A parameter is out of range; the message says what must hold.
    SceneError
        The scene's file is missing or malformed.
    KeyboardInterrupt
        Ctrl-C was pressed; finished blocks are kept in the store.

    Examples
    --------
    >>> import viscache as vc
    >>> ds = vc.correlation.measure("cube_on_plane", n_points=200, map_size=16, seed=1)
    >>> dict(ds["mean"].sizes)
    {'d': 128, 'theta': 180}
    """
    opened = sources.opened(scene)
    s = MeasureSettings(**settings)
    where = s.points or ("camera" if opened.cameras or s.camera is not None else "area")
    chosen = _rows.DirectionSet(map_size=s.map_size, kind=s.directions, seed=s.seed)
    found = _rows.surface_points(
        opened,
        s.n_points,
        points=where,
        camera=s.camera,
        seed=s.seed,
        normals=s.normals,
        threads=s.threads,
    )
    t_max, t_max_by = _reach(opened, found, s)
    geometry = Points(positions=found.positions, normals=found.theta_normals, group=found.group)
    described: dict[str, Any] = {
        "viscache": VERSION,
        "scene": opened.content_hash,
        "t_max": t_max,
        "directions": [s.map_size, s.directions, s.seed],
        "points": digest(found.positions, found.normals, found.theta_normals),
    }
    key = content_key(described if s.engine == "embree" else described | {"engine": s.engine})

    def make(first: int, last: int) -> RowsTask:
        return RowsTask(
            first=first,
            last=last,
            folder=run.folder,
            scene=scene,
            threads=s.threads,
            t_max=t_max,
            scene_hash=opened.content_hash,
            directions=chosen,
            engine=s.engine,
        )

    def here(task: RowsTask) -> Arrays:
        return trace(task, opened, found.positions, found.normals)

    with _run(
        s,
        (directory, executor, progress),
        key=key,
        points=geometry,
        normals=found.normals,
        n_directions=len(chosen.directions),
        directions=chosen,
        rows_per_block=BATCH_ROWS_PER_BLOCK if s.engine in ("auto", "batch") else None,
    ) as run:
        run.trace_rows(make, here if executor is None else trace_in_worker)
        dataset = to_dataset(run.count_pairs(), run.bins)
        add_local_means(dataset, run, s.seed, s.threads)
        _add_points(dataset, found)
        run.report_mended(dataset)
    return dataset.assign_attrs(
        {
            "scene": (scene if isinstance(scene, str) else opened.spec) or opened.name,
            "scene_hash": opened.content_hash,
            "map_size": s.map_size,
            "directions": s.directions,
            "points": where,
            "normals": s.normals,
            "t_max": t_max,
            "t_max_by": t_max_by,
            "camera": find_camera(opened, s.camera).name if where == "camera" else "",
            "domain": s.domain,
            "undefined": s.undefined,
            "min_bits": s.min_bits,
            "seed": s.seed,
            "n_points": len(found.positions),
            "n_rays": run.n_rays,
            "rows_s": run.rows_s,
            "engine": s.engine,
            "batch_rays": run.batch_rays,
        }
    )


def _reach(scene: Any, found: _rows.SurfacePoints, s: MeasureSettings) -> tuple[float, str]:
    """The length of the rays and who chose it."""
    if s.t_max != "auto":
        return float(s.t_max), "caller"
    chosen = closed_reach(scene, found.positions, found.normals, s.threads)
    return chosen, "closed scene" if np.isfinite(chosen) else "open scene"


@contextmanager
def _run(
    s: PairSettings,
    work: tuple[str | os.PathLike[str] | None, Executor | None, Progress],
    *,
    key: str,
    points: Points,
    normals: npt.NDArray[np.float32],
    n_directions: int,
    directions: _rows.DirectionSet | None = None,
    rows_per_block: int | None = None,
) -> Iterator[Run]:
    """The blocks of a measurement; `work` is (directory, executor, progress)."""
    directory, executor, progress = work
    bins = s.bins(points.positions)
    options = s.pair_options(points, bins, n_directions, directions)
    with _folder(directory, executor) as folder, progress_bar(progress, unit="block") as report:
        run = Run(
            key,
            points,
            bins,
            options,
            n_pairs=s.sampled(len(points.group)),
            seed=s.seed,
            folder=folder,
            executor=executor,
            threads=s.threads,
            report=report,
            rows_per_block=rows_per_block,
        )
        if run.folder is not None:
            write_points(run.folder, points, normals)
        yield run


@spelled
@keywords_of(PairSettings, "domain")
def correlate(
    bits: npt.ArrayLike,
    positions: npt.ArrayLike,
    normals: npt.ArrayLike,
    *,
    n_directions: int | None = None,
    group: npt.ArrayLike | None = None,
    directory: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
    progress: Progress = False,
    **settings: Unpack[PairKeywords],
) -> xarray.Dataset:
    """Correlation of any rows of bits, over distance d and angle θ of their points.

    Parameters
    ----------
    bits : (N, W) uint64
        Row i belongs to point i. Bit k is bit k % 64 of word k // 64. Bits from n_directions on
        must be 0.
    positions, normals : (N, 3) float
        Positions in scene units; unit normals.
    n_directions : int, optional
        64·W by default.
    group : (N,) int, optional
        Groups 0, 1, … that the jackknife leaves out one by one; 16 spatial groups by default. If
        pairs are sampled, the points of a group must be in random order.
    pairs, seed, d_edges, theta_edges_deg, d_max, slice_d, slice_theta_deg, undefined, min_bits
        As `measure` takes them.
    directory, executor, threads, progress
        As `measure` takes them.

    Returns
    -------
    xarray.Dataset
        As from `measure`, without points and spatial means.

    Raises
    ------
    ValueError
        Shapes do not match, or a parameter is out of range.

    Examples
    --------
    >>> import numpy as np, viscache as vc
    >>> rng = np.random.default_rng(0)
    >>> bits = rng.integers(0, 1 << 63, (50, 8), dtype=np.uint64)
    >>> up = np.tile([0.0, 0.0, 1.0], (50, 1))
    >>> ds = vc.correlation.correlate(bits, rng.random((50, 3)), up, d_edges=[0, 1, 2])
    >>> int(ds["n"].sum())
    1225
    """
    s = PairSettings(**settings)
    rows, count, geometry = checked_rows(bits, n_directions, positions, normals, group)
    rows_digest = digest(rows, geometry.positions, geometry.normals, geometry.group)
    key = content_key({"viscache": VERSION, "rows": rows_digest})
    with _run(
        s,
        (directory, executor, progress),
        key=key,
        points=geometry,
        normals=geometry.normals,
        n_directions=count,
    ) as run:
        run.set_rows(rows)
        dataset = to_dataset(run.count_pairs(), run.bins)
        run.report_mended(dataset)
    return dataset.assign_attrs(
        undefined=s.undefined,
        min_bits=s.min_bits,
        seed=s.seed,
        n_points=len(rows),
        n_directions=count,
    )


def phi(
    bits_a: npt.ArrayLike, bits_b: npt.ArrayLike, n_directions: int | None = None
) -> npt.NDArray[np.float32]:
    """ρ of every row of one matrix with every row of another; for small problems.

    Parameters
    ----------
    bits_a, bits_b : (NA, W), (NB, W) uint64
    n_directions : int, optional
        64·W by default.

    Returns
    -------
    (NA, NB) float32
        NaN if a row is all 0 or all 1.
    """
    a, count = checked_words(bits_a, "bits_a", n_directions)
    b, _ = checked_words(bits_b, "bits_b", count)
    require(a.shape[1] == b.shape[1], "bits_b must have as many words as bits_a", b.shape)
    return _pairs.phi(a, b, count)


@contextmanager
def _folder(
    directory: str | os.PathLike[str] | None, executor: Executor | None
) -> Iterator[Path | None]:
    """Folder for blocks: the store, a temporary folder for workers, or None."""
    if directory is not None or executor is None:
        yield None if directory is None else Path(directory)
        return
    with tempfile.TemporaryDirectory(prefix="viscache-") as folder:
        yield Path(folder)


def _add_points(dataset: xarray.Dataset, found: Any) -> None:
    """Adds the points and their position in the camera's image."""
    dataset["position"] = (("point", "axis"), found.positions, {"units": "scene units"})
    dataset["normal"] = (("point", "axis"), found.theta_normals, {"units": "1"})
    dataset["group"] = ("point", found.group, {"long_name": "block of space of the jackknife"})
    dataset["stratum"] = ("point", found.stratum, {"long_name": "pixel, row by row"})
    dataset.attrs |= {"width": found.width, "height": found.height}
