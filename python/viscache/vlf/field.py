"""The visibility field as an object: built once, then used to trace rays."""

from __future__ import annotations

import os
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.progress import Progress, progress_bar
from viscache.scene import Intersection, Scene, queries
from viscache.scenes import sources
from viscache.settings import by_name
from viscache.settings.checks import checked_threads, require
from viscache.settings.chosen_rays import vlf_settings
from viscache.settings.rays import Vlf
from viscache.settings.spelling import spelled


@spelled
class VisibilityField:
    """Lists of triangles along beams in fixed directions; rays are traced by lookup (VLF-RT).

    For each of `n_directions` axes the scene is projected onto `n_tiles` × `n_tiles` tiles. Each
    tile lists the triangles that overlap it, divided along its depth. A ray takes the axis nearest
    to its direction and tests the triangles listed by the few tiles that it crosses (Mortensen,
    Khanna, Yu, Slater 2007). Answers are exact: those of the triangle kernel, for any parameters.

    Parameters
    ----------
    scene : Scene, path or str
    n_directions : int or "auto", optional
        l: 1, 3, 9, 33, 129, 513, 2049 or 8193.
    n_tiles : int in [1, 4096] or "auto", optional
        n: tiles along an edge of a subfield.
    bsp_depth : int in [0, 12] or "auto", optional
        Maximum number of halvings of a tile's depth.
    max_bytes : int, optional
        Memory budget. A field that would exceed it is refused before it is built; "auto" parameters
        are chosen to fit.
    settings : Vlf, optional
        All parameters at once, or "vlf"; `Vlf()` by default. The four parameters above are short
        for its fields. They are refused if they contradict the settings.
    threads : int, optional
        Threads of the build; all cores by default. The field is the same for any number.
    progress : bool or callable
        True shows a progress bar; a callable is called with (done, total).

    Raises
    ------
    MemoryError
        The field would need more than `max_bytes`; the message gives the predicted bytes and the
        largest parameters that fit.
    ValueError
        A parameter is out of range, or contradicts `settings`.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> field = vc.VisibilityField(scene, n_directions=33, n_tiles=16)
    >>> field.intersect([[0.0, 5.0, 0.0]], [[0.0, -1.0, 0.0]]).t.shape
    (1,)
    """

    def __init__(
        self,
        scene: Scene | str | os.PathLike[str],
        n_directions: int | Literal["auto"] | None = None,
        n_tiles: int | Literal["auto"] | None = None,
        bsp_depth: int | Literal["auto"] | None = None,
        *,
        max_bytes: int | None = None,
        settings: Vlf | str | None = None,
        threads: int | None = None,
        progress: Progress = False,
    ) -> None:
        self.scene = sources.opened(scene)
        short = {
            "n_directions": n_directions,
            "n_tiles": n_tiles,
            "bsp_depth": bsp_depth,
            "max_bytes": max_bytes,
        }
        given = {name: value for name, value in short.items() if value is not None}
        chosen = vlf_settings(settings)
        for name, value in given.items() if settings is not None else ():
            said = getattr(chosen, name)
            require(
                value == said,
                f"{name} must be left out beside settings, or be their {said!r}",
                value,
            )
        #: The settings as given.
        self.settings: Vlf = by_name.replaced(chosen, given, "settings")
        with progress_bar(progress) as report:
            self._core = _core.vlf.VisibilityField(
                self.scene._core,
                self.settings.core(),
                threads=checked_threads(threads),
                progress=report,
            )

    @property
    def n_directions(self) -> int:
        """l, as built."""
        return int(self._core.settings.n_directions)

    @property
    def n_tiles(self) -> int:
        """n, as built."""
        return int(self._core.settings.n_tiles)

    @property
    def bsp_depth(self) -> int:
        """Maximum number of halvings of a tile's depth, as built."""
        return int(self._core.settings.bsp_depth)

    @property
    def stats(self) -> dict[str, int]:
        """Statistics of the field.

        triangles, degenerate (without area, left out), subfields, tiles, empty_tiles, leaves,
        references (entries of all lists), bytes. For a lazy field these count the existing
        subfields; built and evicted count all since the field was made.
        """
        return self._core.stats

    @classmethod
    def memory_estimate(
        cls,
        scene: Scene | str | os.PathLike[str],
        settings: Vlf | str | None = None,
        *,
        threads: int | None = None,
    ) -> int:
        """Predict the bytes of a field with these settings, within a few per cent.

        Builds eight of its subfields, one at a time.
        """
        core = vlf_settings(settings).core()
        return _core.vlf.predicted_bytes(
            sources.opened(scene)._core, core, checked_threads(threads)
        )

    def tile_entries(self, direction: int) -> npt.NDArray[np.int64]:
        """Number of entries in each tile of one axis: an image of the scene along it.

        Parameters
        ----------
        direction : int in [0, l)
            The axis, as in `viscache.vlf.directions`.

        Returns
        -------
        (n, n) int64
            Rows along v, columns along u of `viscache.vlf.direction_frames`. A triangle in several
            leaves of a tile counts once in each. A lazy field builds the axis first.
        """
        lists = self._core.subfield(direction)
        ends = lists["first_id"][lists["first_leaf"]].astype(np.int64)
        return np.asarray(np.diff(ends).reshape(self.n_tiles, self.n_tiles))

    def intersect(
        self, origins: npt.ArrayLike, directions: npt.ArrayLike, *, threads: int | None = None
    ) -> Intersection:
        """Nearest hits of (..., 3) rays; as `Scene.intersect`."""
        return queries.intersect(self._core, origins, directions, threads)

    def occluded(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        t_max: float | npt.ArrayLike = np.inf,
        *,
        threads: int | None = None,
    ) -> npt.NDArray[np.bool_]:
        """Does a ray hit anything in (0, t_max)? As `Scene.occluded`."""
        return queries.occluded(self._core, origins, directions, t_max, threads)

    def visible(
        self, x: npt.ArrayLike, y: npt.ArrayLike, *, threads: int | None = None
    ) -> npt.NDArray[np.bool_]:
        """Does x see y? As `Scene.visible`."""
        return queries.visible(self._core, x, y, threads)

    def visible_matrix(
        self,
        points: npt.ArrayLike,
        targets: npt.ArrayLike,
        *,
        threads: int | None = None,
        progress: Progress = False,
    ) -> npt.NDArray[np.uint64]:
        """Every point against every target, as bits. As `Scene.visible_matrix`."""
        return queries.visible_matrix(self._core, points, targets, threads, progress)

    def __repr__(self) -> str:
        s: dict[str, Any] = self.stats
        return (
            f"<viscache.VisibilityField l={self.n_directions} n={self.n_tiles} "
            f"depth={self.bsp_depth}: {s['triangles']:,} triangles, {s['bytes'] / 1e6:,.1f} MB>"
        )
