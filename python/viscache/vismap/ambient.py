"""Ambient occlusion from the records of a cache (VisMap Sec. 6.1)."""

from __future__ import annotations

import os
import time
from dataclasses import asdict, replace

import numpy as np

from viscache import _core
from viscache.base.provenance import provenance
from viscache.frame import Frame
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.scenes import sources
from viscache.settings.checks import checked_threads, is_whole, require
from viscache.settings.maps import MapSettings, map_settings
from viscache.settings.spelling import spelled
from viscache.vismap.cache import VisibilityMapCache
from viscache.vismap.records import checked_size

#: Closely spaced records with a small reach: only nearby geometry matters for ambient occlusion.
AMBIENT = MapSettings(criterion="ambient", w_min=0.1, d_max=0.025)


@spelled
def cached_ambient_occlusion(
    scene: Scene | str | os.PathLike[str],
    *,
    cache: VisibilityMapCache | None = None,
    settings: MapSettings | str | None = None,
    camera: str | int | _core.Camera | None = None,
    size: tuple[int, int] | None = None,
    spp: int = 1,
    seed: int = 0,
    width: float = 1 / 6,
    weighted: bool = False,
    threads: int | None = None,
) -> Frame:
    """Ambient visibility, the visible fraction of the hemisphere, interpolated between records.

    Every record stores its visible fraction (Eq. 12, divided by π). A pixel takes the Gaussian mean
    of the m nearest records. The result has no noise, but it is biased; the unbiased
    reference is `viscache.AmbientOcclusion(max_distance=None)`.

    Parameters
    ----------
    scene : Scene, path or str
    cache : VisibilityMapCache, optional
        A cache of the scene with criterion "ambient". Records are added to it where the image needs
        them. By default a new cache.
    settings : MapSettings, optional
        Settings of the new cache, or the name of a preset; `viscache.vismap.ambient.AMBIENT` by
        default. The criterion is set to "ambient".
    camera, size, threads
        As in `viscache.render`.
    spp, seed : int
        The samples are at the same positions as in `viscache.render` with these values, so that its
        image with `AmbientOcclusion` shows the same points. The first sample of every pixel inserts
        records by the criterion; the others only where no record is in reach.
    width : float > 0
        Standard deviation of the Gaussian as a fraction of d_max.
    weighted : bool
        Multiply the Gaussian by the weight w_g·ŵ of the records.

    Returns
    -------
    Frame
        Layers "color" (H, W, 1), 0 where there is no surface, and "coverage" (H, W, 1), the
        fraction of samples with a surface. Counters: "records", "inserted", "rays" traced for
        records, "points" shaded, "rays_per_point", "without_record" (points without a record in
        reach, which are black), and "jump_p99", the 99th percentile of the Gaussian at the farthest
        of m records. This bounds the discontinuity of the image where the set of nearest records
        changes.

    Raises
    ------
    ValueError
        A parameter is out of range, or the cache is of another scene or criterion.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> frame = vc.cached_ambient_occlusion(scene, size=(32, 20))
    >>> frame.image.shape, frame.counters["without_record"]
    ((20, 32, 1), 0)
    """
    scene = sources.opened(scene)
    require(cache is None or settings is None, "settings must be left out with a cache", settings)
    if cache is None:
        chosen = map_settings(settings or AMBIENT)
        cache = VisibilityMapCache(scene, replace(chosen, criterion="ambient"))
    ambient = cache.settings.criterion == "ambient"
    require(ambient, 'the cache\'s criterion must be "ambient"', cache.settings.criterion)
    fits = cache.scene.content_hash == scene.content_hash
    require(fits, "cache must be of the scene", "one of another scene")
    require(is_whole(spp) and 1 <= spp <= 1 << 20, "spp must be in [1, 2^20]", spp)
    require(is_whole(seed) and 0 <= seed < 1 << 64, "seed must be in [0, 2^64)", seed)
    view = find_camera(scene, camera)
    columns, rows = checked_size(frame_size(size, view))
    cores = checked_threads(threads)

    start, cpu = time.perf_counter(), time.process_time()
    before = cache.rays, len(cache)
    parts = (scene._core, scene.caster(cache.rays_by), view, columns, rows, seed)
    rules = _core.vismap.PixelRules(cache.settings.d_max)
    total, seen = np.zeros(columns * rows), np.zeros(columns * rows)
    without_record, jumps = 0, []
    with cache._lock:
        cache._start(view, columns, rows, cores)
        for sample in range(spp):
            points, _, _ = _core.vismap.sample_points(*parts, sample, rules, cores)
            if sample == 0:
                cache._insert(points, cores)
            there = points.d_max > 0
            value, records, jump = cache._core.shade_ambient(points, width, weighted, cores)
            alone = np.flatnonzero(there & (records == 0))
            if len(alone):
                some = points.take(alone)
                cache._insert(some, cores)
                value[alone], records[alone], jump[alone] = cache._core.shade_ambient(
                    some, width, weighted, cores
                )
            total += value
            seen += there
            without_record += int((there & (records == 0)).sum())
            jumps.append(jump[there])
    rays, points_shaded = cache.rays - before[0], int(seen.sum())
    jump_p99 = float(np.quantile(np.concatenate(jumps), 0.99)) if points_shaded else 0.0
    image = (total / np.maximum(seen, 1)).astype(np.float32)
    return Frame(
        layers={
            "color": image.reshape(rows, columns, 1),
            "coverage": (seen / spp).astype(np.float32).reshape(rows, columns, 1),
        },
        counters={
            "records": len(cache),
            "inserted": len(cache) - before[1],
            "rays": rays,
            "points": points_shaded,
            "rays_per_point": rays / max(points_shaded, 1),
            "without_record": without_record,
            "jump_p99": jump_p99,
        },
        timings={"total_s": time.perf_counter() - start, "cpu_s": time.process_time() - cpu},
        parameters={
            "scene": scene.spec or scene.name,
            "scene_hash": scene.content_hash,
            "settings": asdict(cache.settings),
            "size": [columns, rows],
            "spp": spp,
            "seed": seed,
            "camera": view.name,
            "width": width,
            "weighted": weighted,
        },
        provenance=provenance(threads),
    )
