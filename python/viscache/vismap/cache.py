"""The records of a scene: inserted where a camera looks, looked up anywhere."""

from __future__ import annotations

import os

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.progress import Progress
from viscache.base.sharing import Turn, Uncopied
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.scenes import sources
from viscache.settings.checks import checked_points, checked_threads, require
from viscache.settings.chosen_rays import check_rays
from viscache.settings.maps import MapSettings, map_settings
from viscache.settings.rays import Rays
from viscache.settings.spelling import spelled
from viscache.vismap import cache_file
from viscache.vismap.points import insert_tiles, pixel_order
from viscache.vismap.record_insertion import RecordInsertion
from viscache.vismap.records import (
    Floats,
    Lookup,
    Records,
    UpdateReport,
    blended_bits,
    cells_of,
    checked_size,
)


@spelled
class VisibilityMapCache(Uncopied, RecordInsertion):
    """Visibility-map records of a scene (VisMap Sec. 5).

    Parameters
    ----------
    scene : Scene, path or str
    settings : MapSettings, optional
        Or the name of a preset.
    rays : Embree, Bsp or Vlf, optional
        Ray caster for the rays of records; Embree by default.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> cache = vc.VisibilityMapCache(scene, vc.MapSettings(n_startup=100))
    >>> report = cache.update(size=(64, 40))
    >>> len(cache) == report.inserted, report.startup <= 100
    (True, True)
    """

    _instead = "use save and load"

    def __init__(
        self,
        scene: Scene | str | os.PathLike[str],
        settings: MapSettings | str | None = None,
        *,
        rays: Rays | str | None = None,
    ) -> None:
        settings = map_settings(settings)
        self.scene = sources.opened(scene)
        self.settings = settings
        self.rays_by = check_rays(rays)
        self._core = _core.vismap.MapCache(settings.core())
        self._lock = Turn("the cache", again=True)
        #: Number of the current frame; `end_frame` increments it.
        self.frame = 0
        #: True once the start-up records exist.
        self.started = False
        #: Rays traced for all records so far, including removed ones.
        self.rays = 0
        #: (w_min, delta_max) in use; for preset "auto" they are known after the start-up.
        self.thresholds = settings.thresholds()
        self._core.set_thresholds(*self.thresholds)

    def __len__(self) -> int:
        return len(self._core)

    @property
    def nbytes(self) -> int:
        """Bytes of the records as counted in the paper: map, hierarchy and 36 bytes of metadata."""
        return len(self) * _core.vismap.record_nbytes(self.settings.m)

    @property
    def extra_nbytes(self) -> int:
        """Bytes of dilated maps and ambient values, which the paper does not have."""
        return len(self) * self._core.extra_bytes_per_record

    @property
    def directions(self) -> Floats:
        """(4^m, 3) ray directions of the cells, in Z order."""
        return self._core.pattern

    def records(self) -> Records:
        """Copies of all records."""
        with self._lock:
            return Records(**self._core.records())

    # Making records

    def update(
        self,
        camera: str | int | _core.Camera | None = None,
        *,
        size: tuple[int, int] | None = None,
        scene: Scene | str | os.PathLike[str] | None = None,
        at: tuple[float, float] = (0.5, 0.5),
        threads: int | None = None,
        progress: Progress = False,
    ) -> UpdateReport:
        """Insert records where the pixels of an image need them.

        The first update creates the start-up records first.

        Parameters
        ----------
        camera : str, int or Camera, optional
            As `viscache.render` takes it.
        size : (width, height), optional
            In pixels; the size of the camera by default.
        scene : Scene, optional
            The changed scene in an animation. Old records are not changed; comparison with exact
            rays finds the wrong ones.
        at : (x, y) in [0, 1)
            The sample position in every pixel.
        threads : int >= 1, optional
            All cores by default.
        progress : bool or callable
            True shows a progress bar; a callable is called with (done, total) pixels of a pass.

        Raises
        ------
        ValueError
            A parameter is out of range.
        KeyboardInterrupt
            Within half a second of Ctrl-C; finished records are kept.
        """
        if scene is not None:
            self.scene = sources.opened(scene)
        view = find_camera(self.scene, camera)
        width, height = checked_size(frame_size(size, view))
        cores = checked_threads(threads)
        with self._lock:
            startup = self._start(view, width, height, cores)
            points, misses, bad_normals = self._pixels(view, width, height, at, cores)
            ordered = points
            if self.settings.order != "scanline":
                ordered = points.take(pixel_order(self.settings.order, width, height))
            found = self._insert(ordered, cores, progress)
            self._core.mark_used(points, self.frame, cores)
        return UpdateReport.of(self.frame, startup, found, width * height, misses, bad_normals)

    def insert(
        self,
        positions: npt.ArrayLike,
        normals: npt.ArrayLike,
        d_max: npt.ArrayLike | None = None,
        footprint: npt.ArrayLike | None = None,
        *,
        threads: int | None = None,
        progress: Progress = False,
    ) -> UpdateReport:
        """Insert records where points of any source need them.

        A point gets a record if no existing record serves it, by the same test as the pixels of
        `update`. Start-up records are not created, except with preset "auto" before the first
        update: they are inserted at `n_startup` of the points and determine the thresholds.

        Any number of points is taken: they are visited along a Morton curve, 2^20 at a time. The
        order in which they are given matters only for points that lie very close together.

        Parameters
        ----------
        positions, normals : (N, 3) float
            Unit normals, on the visible side.
        d_max : float or (N,) float, >= 0, optional
            Search radius for records in scene units; 0: the point is ignored. By default
            `settings.d_max` · √N · `footprint`, at most a tenth of the scene's diagonal: the points
            count as the pixels of a square image.
        footprint : float or (N,) float, >= 0, optional
            Distance between neighbouring points in scene units, the size of a "pixel" for
            `settings.r_min_px`; 0: unknown. By default 1 / √density, with the density from the
            distance of the 8th nearest neighbour.
        threads : int >= 1, optional
            All cores by default. The records do not depend on it, except with mode "locked".
        progress : bool or callable
            True shows a progress bar; a callable is called with (done, total) points of a pass.

        Returns
        -------
        UpdateReport
            Of points instead of pixels; `misses` counts the ignored ones.

        Raises
        ------
        ValueError
            Shapes do not match, positions are not finite, normals are not unit vectors, or another
            value is out of range. The cache stays as it was.
        KeyboardInterrupt
            Within half a second of Ctrl-C while records are inserted; finished records are kept.
            The search for neighbours before that is not interrupted.

        Examples
        --------
        >>> import viscache as vc
        >>> scene = vc.scenes.cube_on_plane()
        >>> points = vc.correlation.surface_points(scene, 500, points="area")
        >>> cache = vc.VisibilityMapCache(scene)
        >>> report = cache.insert(points.positions, points.normals)
        >>> 0 < report.inserted == len(cache) < 500
        True
        >>> found = cache.lookup(points.positions, points.normals)
        >>> bool((found.candidates > 0).all())
        True
        """
        points = self._cloud(positions, normals, d_max, footprint)
        cores = checked_threads(threads)
        with self._lock:
            order = points.order()
            startup = self._start_at(points, order, cores)
            found = insert_tiles(
                points,
                order,
                lambda tile: self._insert(tile, cores, progress, "point"),
                lambda: len(self),
                repeat_passes=self.settings.repeat_passes,
            )
            for tile in points.tiles(order):
                self._core.mark_used(tile, self.frame, cores)
        return UpdateReport.of(self.frame, startup, found, len(points), found["unusable"], 0)

    # Asking

    def lookup(
        self,
        positions: npt.ArrayLike,
        normals: npt.ArrayLike,
        d_max: npt.ArrayLike | None = None,
        *,
        threads: int | None = None,
    ) -> Lookup:
        """Look up the records that are used at points on surfaces.

        Parameters
        ----------
        positions, normals : (N, 3) float
            Unit normals, on the visible side.
        d_max : float or (N,) float, >= 0, optional
            Search radius for records in scene units; 0: the point is ignored. By default as
            `insert` chooses it for these points.
        threads : int, optional
            All cores by default.

        Returns
        -------
        Lookup

        Raises
        ------
        ValueError
            Shapes do not match, positions are not finite, or normals are not unit vectors.
        """
        points = self._cloud(positions, normals, d_max, None if d_max is None else 0.0)
        cores = checked_threads(threads)
        with self._lock:
            found = self._core.select(points.take(slice(None)), cores)
        return Lookup(
            ids=found["ids"],
            beta=found["beta"],
            candidates=found["candidates"],
            weight=found["tested"],
            difference=found["difference"],
        )

    def visibility(self, lookup: Lookup, directions: npt.ArrayLike) -> npt.NDArray[np.float32]:
        """Ṽ of looked-up points in K directions: (N, K), in [0, 1]; 0 without an approximation.

        Parameters
        ----------
        lookup : Lookup
        directions : (K, 3) float
            Unit vectors in world space.
        """
        cells = self.cells(directions)
        require(cells.ndim == 1, "directions must have shape (K, 3)", (*cells.shape, 3))
        said = blended_bits(
            self.records().bits, lookup.ids, np.broadcast_to(cells, (len(lookup.ids), len(cells)))
        )
        return np.asarray(np.einsum("nik,ni->nk", said, lookup.beta, dtype=np.float32))

    def cells(self, directions: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Cells of the map for unit directions (..., 3): Z-order indices (...)."""
        given = checked_points(directions, "directions")
        fits = given.ndim >= 1 and given.shape[-1] == 3
        require(fits, "directions must have shape (..., 3)", given.shape)
        return cells_of(given, self.settings.m)

    # Over the frames of an animation

    def compare(
        self, lookup: Lookup, directions: npt.ArrayLike, visible: npt.ArrayLike
    ) -> tuple[int, int]:
        """Compare the blended records with exact rays and count their errors.

        Parameters
        ----------
        lookup : Lookup
            A lookup of N points, made after the last insertion or removal.
        directions : (N, K, 3) float
            Unit directions of exact rays.
        visible : (N, K) bool
            Results of the exact rays.

        Returns
        -------
        (rays, misses)
            Totals of this call over all records.
        """
        seen = np.asarray(visible, dtype=bool)
        cells = self.cells(directions)
        expected = (len(lookup.ids), cells.shape[-1] if cells.ndim else 0)
        require(cells.shape == expected, "directions must have shape (N, K, 3)", (*cells.shape, 3))
        require(seen.shape == expected, f"visible must have shape {expected}", seen.shape)
        with self._lock:
            said = blended_bits(self.records().bits, lookup.ids, cells)
            wrong = said != seen[:, None, :]
            speaks = lookup.beta > 0
            ids = lookup.ids[speaks]
            fits = bool((ids < len(self)).all())
            require(fits, "lookup must be of the records now there", "others")
            rays = np.bincount(ids, minlength=len(self)) * expected[1]
            misses = np.bincount(ids, wrong.sum(axis=2)[speaks], minlength=len(self))
            used = (rays > 0).astype(np.uint8)
            self._core.tally(rays.astype(np.uint32), misses.astype(np.uint32), used, self.frame)
        return int(rays.sum()), int(misses.sum())

    def end_frame(self) -> dict[str, int]:
        """Remove wrong and unused records by the rules of the settings, and start the next frame.

        Returns
        -------
        dict
            "wrong" and "unused": numbers of removed records; "rays" and "misses": totals before.
        """
        with self._lock:
            found = self._core.remove(self.frame)
            self.frame += 1
        return {name: int(value) for name, value in found.items()}

    def reset_errors(self) -> None:
        """Reset the counts of rays and misses, as after a change of the geometry."""
        with self._lock:
            self._core.reset_tallies()

    # Files

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the cache to a file that `load` accepts for the same scene.

        The file is written atomically.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        with self._lock:
            state = cache_file.State(
                scene_hash=self.scene.content_hash,
                settings=self.settings.parameters(),
                directions=self.directions,
                frame=self.frame,
                started=self.started,
                rays=self.rays,
                thresholds=self.thresholds,
                records=self._core.records(),
            )
        cache_file.write(path, state)

    @classmethod
    def load(
        cls, path: str | os.PathLike[str], scene: Scene | str | os.PathLike[str]
    ) -> VisibilityMapCache:
        """Load a cache from a file.

        Parameters
        ----------
        path : path
        scene : Scene, path or str
            The scene of the cache.

        Raises
        ------
        ValueError
            The file is not a cache, is damaged, has another version, or is of another scene; the
            message says which.
        OSError
            The file cannot be read.
        """
        scene = sources.opened(scene)
        state = cache_file.read(path, scene.content_hash)
        try:
            cache = cls(scene, MapSettings(**state.settings))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{path}: the cache must have the settings of one: {error}") from error
        fit = np.array_equal(cache.directions, state.directions)
        require(fit, f"{path}: the directions must be those of the settings", "others")
        cache.frame, cache.started, cache.rays = state.frame, state.started, state.rays
        cache.thresholds = state.thresholds
        try:
            cache._core.set_thresholds(*state.thresholds)
            cache._core.add_records(**state.records)
        except (TypeError, ValueError) as error:
            told = str(error).partition("\n")[0]
            raise ValueError(f"{path}: the cache must have the records of one: {told}") from error
        return cache

    def __repr__(self) -> str:
        edge = 1 << self.settings.m
        return (
            f"<viscache.VisibilityMapCache: {len(self):,} records of {edge}×{edge}, "
            f"{self.nbytes:,} bytes>"
        )
