"""Ambient occlusion from the records of a cache (paper: Section 6.1)."""

from __future__ import annotations

import time
from dataclasses import asdict, replace

import numpy as np

from viscache import _core
from viscache.cameras import find_camera
from viscache.checks import checked_threads, is_whole, require
from viscache.frame import Frame
from viscache.provenance import provenance
from viscache.scene import Scene
from viscache.vismap.cache import VisibilityMapCache, checked_size
from viscache.vismap.settings import MapSettings

__all__ = ["cached_ambient_occlusion"]


def cached_ambient_occlusion(
    scene: Scene,
    *,
    cache: VisibilityMapCache | None = None,
    settings: MapSettings | None = None,
    camera: str | int | _core.Camera | None = None,
    size: tuple[int, int] | None = None,
    spp: int = 1,
    width: float = 1 / 3,
    weighted: bool = False,
    threads: int | None = None,
) -> Frame:
    """The visible share of the hemisphere, interpolated between records.

    Every record holds the share it sees (Eq. 12, divided by π); a pixel takes the mean of the m
    nearest records under a Gaussian. Free of noise and not unbiased: compare with
    `viscache.AmbientOcclusion`.

    Parameters
    ----------
    scene : Scene
    cache : VisibilityMapCache, optional
        A cache of the scene with criterion "ambient", which grows where the image needs it; a new
        one by default.
    settings : MapSettings, optional
        Of the new cache; its criterion becomes "ambient".
    camera, size, threads
        As in `viscache.render`.
    spp : int >= 1, a square number
        Places per pixel: a regular grid.
    width : float > 0
        Standard deviation of the Gaussian, in d_max.
    weighted : bool
        Multiply the Gaussian with the weight w_g·ŵ of the records.

    Returns
    -------
    Frame
        Layers "color" (H, W, 1), 0 where nothing is seen, and "coverage" (H, W, 1), the share of
        places with a surface. Counters "records", "inserted", "rays" traced for records, "points"
        shaded, "rays_per_point", "unserved" points without a record in reach (black), and
        "jump_p99": 99th percentile of the Gaussian at the farthest of m records, by which the
        image may jump where the m nearest change.

    Raises
    ------
    ValueError
        A parameter out of range, or a cache of another scene or criterion.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> frame = vc.cached_ambient_occlusion(scene, size=(32, 20))
    >>> frame.image.shape, frame.counters["unserved"]
    ((20, 32, 1), 0)
    """
    require(isinstance(scene, Scene), "scene must be a Scene", scene)
    require(cache is None or settings is None, "settings must be left out with a cache", settings)
    if cache is None:
        cache = VisibilityMapCache(scene, replace(settings or MapSettings(), criterion="ambient"))
    ambient = cache.settings.criterion == "ambient"
    require(ambient, 'the cache\'s criterion must be "ambient"', cache.settings.criterion)
    require(cache.scene.content_hash == scene.content_hash, "cache must be of the scene",
            "one of another scene")  # fmt: skip
    grid = round(spp**0.5) if is_whole(spp) and spp >= 1 else 0
    require(grid > 0 and grid * grid == spp, "spp must be a square number >= 1", spp)
    view = find_camera(scene, camera)
    columns, rows = checked_size(size or (view.width, view.height))
    cores = checked_threads(threads)

    start, cpu = time.perf_counter(), time.process_time()
    before = cache.rays, len(cache)
    places = [((i + 0.5) / grid, (j + 0.5) / grid) for j in range(grid) for i in range(grid)]
    for at in places:
        cache.update(view, size=(columns, rows), at=at, threads=threads)
    total = np.zeros(columns * rows)
    seen = np.zeros(columns * rows)
    unserved, jumps = 0, []
    for at in places:
        points, _, _ = cache._pixels(view, columns, rows, at, cores)
        value, records, jump = cache._core.shade_ambient(points, width, weighted, cores)
        there = points.d_max > 0
        total += value
        seen += there
        unserved += int((there & (records == 0)).sum())
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
            "records": len(cache), "inserted": len(cache) - before[1], "rays": rays,
            "points": points_shaded, "rays_per_point": rays / max(points_shaded, 1),
            "unserved": unserved, "jump_p99": jump_p99,
        },
        timings={"total_s": time.perf_counter() - start, "cpu_s": time.process_time() - cpu},
        parameters={
            "scene": scene.spec or scene.name, "scene_hash": scene.content_hash,
            "settings": asdict(cache.settings), "size": [columns, rows], "spp": spp,
            "camera": view.name, "width": width, "weighted": weighted,
        },
        provenance=provenance(threads),
    )  # fmt: skip
