"""Renders frames whose environment light is estimated with visibility maps."""

from __future__ import annotations

import time
from typing import Any

from viscache import _core
from viscache.scene import Scene
from viscache.settings.checks import require
from viscache.settings.rays import Rays
from viscache.settings.vismaps import VisMaps
from viscache.vismap.cache import VisibilityMapCache


def render_with_maps(
    scene: Scene,
    geometry: Scene,
    rays: Rays,
    caster: _core.RayCaster,
    view: _core.Camera,
    core: _core.IntegratorSettings,
    frame: _core.FrameSettings,
    visibility: VisMaps,
    source: _core.OracleSource,
    *,
    replace: bool,
    progress: Any,
) -> dict[str, Any]:
    """Implements `viscache.render` with `VisMaps`; `geometry` is the scene before env= changed it.

    `source` makes the oracles that trace the rays. Adds the counters "records", "records_inserted"
    and "records_rays" and the timing "records_s". ValueError if the scene has no environment, or
    the cache is of another scene.
    """
    kinds = {light["kind"] for light in scene.lights}
    fits = bool(kinds & {"constant", "environment"})
    require(fits, "scene must have an environment light for visibility maps", "none")
    cache = visibility.cache
    if cache is None:
        cache = VisibilityMapCache(geometry, visibility.map_settings(), rays=rays)
    if not isinstance(cache, VisibilityMapCache):
        raise ValueError(f"cache must be a VisibilityMapCache, got {cache!r}")
    fits = cache.settings.criterion == "visibility"
    require(fits, 'the cache\'s criterion must be "visibility"', cache.settings.criterion)
    of_scene = cache.scene is geometry or cache.scene.content_hash in (
        geometry.content_hash,
        scene.content_hash,
    )
    require(of_scene, "cache must be of the scene", "one of another scene")

    start, before, records = time.perf_counter(), cache.rays, len(cache)
    size = (frame.width, frame.height)
    if visibility.updates:
        cache.update(view, size=size, threads=frame.threads)
    inserted, traced = len(cache) - records, cache.rays - before
    points, _, _ = cache._pixels(view, *size, (0.5, 0.5), frame.threads)
    records_s = time.perf_counter() - start
    with cache._lock:
        maps = _core.cache_maps(
            visibility.estimate(),
            cache._core,
            frame,
            points.d_max,
            points.footprint,
            replace=replace,
            count_misses=visibility.count_misses,
            cache_frame=cache.frame,
        )
        result: dict[str, Any] = _core.render_frame(
            scene._core, caster, view, core, frame, source, maps=maps, progress=progress
        )
    result["counters"].update(records=len(cache), records_inserted=inserted, records_rays=traced)
    result["timings"]["records_s"] = records_s
    return result
