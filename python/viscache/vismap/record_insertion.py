"""Inserting records: the points of pixels or of clouds, the start-up, and the rays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.progress import Progress, progress_bar
from viscache.scene import Scene
from viscache.settings.checks import is_number, require
from viscache.settings.maps import MapSettings
from viscache.settings.rays import Caster, Rays
from viscache.vismap.points import Cloud, Rows, make_cloud

Camera: TypeAlias = _core.Camera
CachePoints: TypeAlias = _core.vismap.CachePoints
MapCache: TypeAlias = _core.vismap.MapCache

#: Of a start-up that was not needed.
NOTHING = {"inserted": 0, "duplicates": 0, "rays": 0}


class RecordInsertion:
    """How a cache gets its records. `VisibilityMapCache` has the attributes and the lock."""

    scene: Scene
    settings: MapSettings
    rays_by: Rays
    frame: int
    started: bool
    rays: int
    thresholds: tuple[float, float]
    _core: MapCache

    def _caster(self) -> Caster:
        return self.scene.caster(self.rays_by)

    def _cloud(
        self,
        positions: npt.ArrayLike,
        normals: npt.ArrayLike,
        d_max: npt.ArrayLike | None,
        footprint: npt.ArrayLike | None,
    ) -> Cloud:
        reach, extent = self.settings.d_max, 2 * self.scene._core.radius
        return make_cloud(positions, normals, d_max, footprint, reach=reach, extent=extent)

    def asking_points(
        self, camera: Camera, size: tuple[int, int]
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Positions (N, 3), normals (N, 3) and d_max (N,) of what pixel centres see, for `lookup`.

        Row by row; d_max is 0 where a pixel sees no surface.
        """
        found, _, _ = self._pixels(camera, *size, (0.5, 0.5), 0)
        return found.positions, found.normals, found.d_max

    def _pixels(
        self, view: Camera, width: int, height: int, at: tuple[float, float], threads: int
    ) -> tuple[CachePoints, int, int]:
        pair = isinstance(at, Sequence | np.ndarray) and len(at) == 2
        inside = pair and all(is_number(v) and 0 <= v < 1 for v in at)
        require(inside, "at must be two numbers in [0, 1)", at)
        rules = _core.vismap.PixelRules(self.settings.d_max)
        return _core.vismap.pixel_points(
            self.scene._core, self._caster(), view, width, height, at, rules, threads
        )

    def _insert(
        self, points: CachePoints, threads: int, progress: Progress = False, unit: str = "pixel"
    ) -> dict[str, int]:
        with progress_bar(progress, unit=unit) as report:
            found = self._core.insert(
                self.scene._core,
                self._caster(),
                points,
                frame=self.frame,
                threads=threads,
                progress=report,
            )
        self.rays += found["rays"]
        return found

    def _start(self, view: Camera, width: int, height: int, threads: int) -> dict[str, int]:
        """Creates the start-up records of an image if they do not exist yet."""
        if self.started:
            return NOTHING
        points, _, _ = _core.vismap.startup_points(
            self.scene._core,
            self._caster(),
            view,
            width,
            height,
            self.settings.n_startup,
            self.settings.seed,
            _core.vismap.PixelRules(self.settings.d_max),
        )
        return self._bootstrap(points, threads)

    def _start_at(self, points: Cloud, order: Rows, threads: int) -> dict[str, int]:
        """Creates start-up records at some of the points if the thresholds depend on them."""
        if self.started or self.settings.preset != "auto" or not len(points):
            return NOTHING
        step = -(-len(points) // self.settings.n_startup)
        return self._bootstrap(points.take(order[::step]), threads)

    def _bootstrap(self, points: CachePoints, threads: int) -> dict[str, int]:
        before = len(self._core)
        found = self._core.bootstrap(self.scene._core, self._caster(), points, self.frame, threads)
        self.started = True
        self.rays += found["rays"]
        self.thresholds = self.settings.thresholds(found)
        self._core.set_thresholds(*self.thresholds)
        return {
            "inserted": len(self._core) - before,
            "duplicates": found["duplicates"],
            "rays": found["rays"],
        }
