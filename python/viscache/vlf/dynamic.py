"""Objects that are added, removed and moved in a visibility field."""

from __future__ import annotations

import os
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.progress import Progress, progress_bar
from viscache.base.sharing import Turn, Uncopied
from viscache.scene import Scene, queries
from viscache.scenes import sources
from viscache.settings.checks import (
    checked_floats,
    checked_points,
    checked_threads,
    is_whole,
    require,
)
from viscache.settings.chosen_rays import vlf_settings
from viscache.settings.rays import Vlf
from viscache.settings.spelling import spelled


class DynamicHits(NamedTuple):
    """Nearest hits of N rays.

    Attributes
    ----------
    t : (N,) float32
        Distance in units of the direction's length; inf for a miss.
    object : (N,) int64
        The hit object; -1 for the scene, -2 for a miss.
    triangle : (N,) int64
        Index of the triangle in the object, or in the scene as in `Intersection`; -1 for a miss.
    barycentrics : (N, 2) float32
        Weights of the triangle's vertices 1 and 2; NaN for a miss.
    """

    t: npt.NDArray[np.float32]
    object: npt.NDArray[np.int64]
    triangle: npt.NDArray[np.int64]
    barycentrics: npt.NDArray[np.float32]


@spelled
class DynamicField(Uncopied):
    """A visibility field over a scene and over objects that are inserted, moved and deleted.

    To move an object, every direction removes it from the tiles it touches and inserts it at its
    new place (Mortensen, Khanna, Yu, Slater 2007, Sec. 8). The cost is that of rasterizing the
    object and does not depend on the scene. Answers are those of a field built from scratch. A
    dynamic field only traces rays; it cannot be used for rendering frames.

    Parameters
    ----------
    scene : Scene, path or str
    settings : Vlf, optional
        `head_room` is the space available to objects: the radius of the field's ball relative to
        the scene's bounding sphere. Lazy or snapped fields are not supported. Default: a head room
        of 1.25 and default values otherwise.
    mode : {"overlay", "in_place"}
        "overlay": an object has its own lists over the tiles that it touches. "in_place" (as in the
        paper): its triangles are inserted into the lists of the scene.
    threads : int, optional
        Threads of the build; all cores by default.
    progress : bool or callable

    Raises
    ------
    MemoryError
        The field of the scene would need more than `settings.max_bytes`.
    ValueError
        A parameter out of range.

    Examples
    --------
    >>> import numpy as np
    >>> import viscache as vc
    >>> field = vc.vlf.DynamicField(
    ...     vc.scenes.cube_on_plane(), vc.Vlf(n_directions=33, n_tiles=16, head_room=2.0)
    ... )
    >>> one = field.insert([[0, 2, 0], [1, 2, 0], [0, 2, 1]], [[0, 1, 2]])
    >>> up = field.intersect([[0.1, 1.8, 0.1]], [[0.0, 1.0, 0.0]])
    >>> int(up.object[0]) == one, round(float(up.t[0]), 6)
    (True, 0.2)
    """

    def __init__(
        self,
        scene: Scene | str | os.PathLike[str],
        settings: Vlf | str | None = None,
        *,
        mode: Literal["overlay", "in_place"] = "overlay",
        threads: int | None = None,
        progress: Progress = False,
    ) -> None:
        settings = Vlf(head_room=1.25) if settings is None else vlf_settings(settings)
        require(mode in ("overlay", "in_place"), 'mode must be "overlay" or "in_place"', mode)
        require(not settings.lazy, "lazy must be false for objects that move", settings.lazy)
        require(not settings.snap, "snap must be false for objects that move", settings.snap)
        self.scene, self.settings, self.mode = sources.opened(scene), settings, mode
        self._turn = Turn("the field")
        with progress_bar(progress) as report:
            self._core = _core.vlf.DynamicField(
                self.scene._core,
                settings.core(),
                _core.vlf.UpdateMode[mode.upper()],
                threads=checked_threads(threads),
                progress=report,
            )

    def insert(
        self, vertices: npt.ArrayLike, triangles: npt.ArrayLike, *, threads: int | None = None
    ) -> int:
        """Add an object.

        Parameters
        ----------
        vertices : (V, 3) float
            In scene units.
        triangles : (T, 3) int
            Vertex indices. Triangles without area are never hit.
        threads : int, optional
            All cores by default.

        Returns
        -------
        int
            Number of the object; numbers are not reused.

        Raises
        ------
        ValueError
            The object leaves the ball of the field, or an index or vertex is invalid.
        """
        indices = np.asarray(triangles)
        whole = indices.dtype.kind in "iu" or indices.size == 0
        require(whole, "triangles must be integers", indices.dtype)
        if indices.size:
            fits = indices.min() >= 0 and indices.max() < 1 << 32
            require(fits, "triangles must be in [0, 2^32)", (indices.min(), indices.max()))
        points = checked_points(vertices, "vertices")
        rows = indices.astype(np.uint32).reshape(-1, 3) if indices.size == 0 else indices
        with self._turn:
            return self._core.insert(points, rows.astype(np.uint32), checked_threads(threads))

    def delete(self, number: int, *, threads: int | None = None) -> None:
        """Remove an object.

        Raises
        ------
        ValueError
            There is no such object.
        """
        with self._turn:
            self._core.remove(_number(number), checked_threads(threads))

    def transform(self, number: int, matrix: npt.ArrayLike, *, threads: int | None = None) -> None:
        """Move an object.

        Parameters
        ----------
        number : int
        matrix : (3, 4) or (4, 4) float
            Transform from the place of insertion to the new place; transforms do not accumulate.
        threads : int, optional
            All cores by default.

        Raises
        ------
        ValueError
            There is no such object, the matrix is invalid, or the object leaves the ball of the
            field.
        """
        m = checked_floats(matrix, "matrix", np.float64)
        affine = m.shape == (3, 4) or (m.shape == (4, 4) and np.allclose(m[3], [0, 0, 0, 1]))
        require(affine, "matrix must be affine, of shape (3, 4) or (4, 4)", m.shape)
        require(bool(np.isfinite(m).all()), "matrix must be finite", matrix)
        with self._turn:
            self._core.transform(_number(number), m[:3].tolist(), checked_threads(threads))

    def intersect(
        self, origins: npt.ArrayLike, directions: npt.ArrayLike, *, threads: int | None = None
    ) -> DynamicHits:
        """Nearest hits of (..., 3) rays, which broadcast; see `DynamicHits`."""
        with self._turn:
            return DynamicHits(*queries.hits(self._core, origins, directions, threads))

    def occluded(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        t_max: float | npt.ArrayLike = np.inf,
        *,
        threads: int | None = None,
    ) -> npt.NDArray[np.bool_]:
        """Does a ray hit anything in (0, t_max)? As `Scene.occluded`."""
        with self._turn:
            return queries.occluded(self._core, origins, directions, t_max, threads)

    @property
    def stats(self) -> dict[str, int]:
        """Number of objects, and bytes of lists and triangles."""
        with self._turn:
            return {"objects": self._core.objects, "bytes": self._core.bytes}


def _number(value: Any) -> int:
    fits = is_whole(value) and 0 <= value < 1 << 32
    require(fits, "object must be one that was inserted and not deleted", value)
    return int(value)
