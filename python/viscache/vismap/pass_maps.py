"""Visibility maps that passes of a picture refine."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.array_digests import arrays_digest
from viscache.scene import Scene
from viscache.settings.rays import Rays
from viscache.settings.vismaps import VisMaps
from viscache.vismap.cache import VisibilityMapCache

#: Steps of the sample positions of updates: the sequence R2 of Roberts.
STEP = (0.7548776662466927, 0.5698402909980532)


class PassMaps:
    """The records of a picture that gets better pass by pass, in a copy of the cache that is given.

    Before each pass, pixels get the records that they need at another position. With
    `count_misses`, records that rays of a pass contradicted are removed after it. A pass does not
    change the records that it uses, so it is as unbiased as a frame. An interrupted pass leaves the
    records as they were. `counters` and `seconds` are those of the latest update.
    """

    def __init__(self, scene: Scene, visibility: VisMaps, rays: Rays | str | None) -> None:
        given = visibility.cache
        settings = visibility.map_settings() if given is None else given.settings
        self._visibility = visibility
        self.counters = {"records_inserted": 0, "records_rays": 0}
        self.seconds = 0.0
        self.cache = VisibilityMapCache(scene, settings, rays=rays)
        if isinstance(given, VisibilityMapCache):
            self._restore(_state_of(given))

    @contextmanager
    def for_pass(
        self,
        number: int,
        *,
        camera: str | int | _core.Camera | None,
        size: tuple[int, int] | None,
        threads: int | None,
    ) -> Iterator[VisMaps]:
        """The setting of one pass."""
        before = self._state()
        try:
            start, rays, records = time.perf_counter(), self.cache.rays, len(self.cache)
            x, y = ((0.5 + number * step) % 1 for step in STEP)
            self.cache.update(camera, size=size, at=(x, y), threads=threads)
            self.counters = {
                "records_inserted": len(self.cache) - records,
                "records_rays": self.cache.rays - rays,
            }
            self.seconds = time.perf_counter() - start
            yield replace(self._visibility, cache=self.cache, update=False)
            if self._visibility.count_misses:
                self.cache.end_frame()
        except BaseException:
            self._restore(before)
            raise

    def _state(self) -> dict[str, npt.NDArray[Any]]:
        return _state_of(self.cache)

    def _restore(self, state: dict[str, npt.NDArray[Any]]) -> None:
        cache = VisibilityMapCache(self.cache.scene, self.cache.settings, rays=self.cache.rays_by)
        records = dict(state)
        frame, started, rays = (int(v) for v in records.pop("counts"))
        cache.frame, cache.started, cache.rays = frame, bool(started), rays
        thresholds = records.pop("thresholds")
        cache.thresholds = (float(thresholds[0]), float(thresholds[1]))
        cache._core.set_thresholds(*cache.thresholds)
        if cache.started:
            cache._core.add_records(**records)
        self.cache = cache


def _state_of(cache: VisibilityMapCache) -> dict[str, npt.NDArray[Any]]:
    with cache._lock:
        return {
            **cache._core.records(),
            "counts": np.array([cache.frame, cache.started, cache.rays], np.int64),
            "thresholds": np.array(cache.thresholds),
        }


def records_digest(cache: Any) -> str:
    """A digest of settings, and of what estimates read of the records."""
    state = _state_of(cache)
    read = ("positions", "normals", "bits", "ambient", "nearest_hit", "thresholds")
    return arrays_digest(repr(cache.settings).encode(), {name: state[name] for name in read})
