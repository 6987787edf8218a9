"""Scenes: made from files or arrays, and queried for exact visibility."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, Literal, TypeAlias, overload

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache._core import SceneDescription, SceneError
from viscache.base.sharing import MadeOnce, Newest
from viscache.oracles.correct import Correct
from viscache.oracles.oracle import Oracle
from viscache.oracles.written import Written
from viscache.scene import queries
from viscache.scene.about import info, placed_coplanar_share, problems
from viscache.scene.environments import apply_environment
from viscache.scene.html import scene_html
from viscache.scene.parts import Mesh, add_meshes, add_trimesh, origin_of
from viscache.scene.queries import Intersection
from viscache.scene.sky import Sky
from viscache.settings.checks import checked_floats, checked_threads
from viscache.settings.chosen_rays import check_rays
from viscache.settings.rays import Bsp, Caster, Embree, Rays, Vlf
from viscache.settings.spelling import spelled
from viscache.settings.visibility import Visibility

__all__ = ["Intersection", "Scene", "SceneError"]

Env: TypeAlias = (
    "Sky | str | os.PathLike[str] | float | Sequence[float] | npt.NDArray[np.floating[Any]]"
)


@spelled
class Scene:
    """An immutable scene.

    Made by `load_scene`, `Scene.from_arrays`, `Scene.from_trimesh`, a function of
    `viscache.scenes`, or `Scene.from_description`. Scenes can be pickled for process pools: as the
    spec if that gives a scene of the same `content_hash`, otherwise with all arrays.
    """

    def __init__(self, core: _core.Scene, spec: str | None = None) -> None:
        self._core = core
        #: What the scene was made from: a path or `room?triangles=…`; None for arrays.
        self.spec = spec
        self._made, self._other_caster = MadeOnce(), Newest()

    #: Renders the thumbnail; set by the package.
    _picture: ClassVar[Callable[[Any], str] | None] = None

    @classmethod
    def from_description(
        cls, description: SceneDescription, *, spec: str | None = None, threads: int | None = None
    ) -> Scene:
        """Make a scene from a description; it does not depend on `threads` (default: all cores).

        Raises
        ------
        SceneError
            The description has an error; the message says what and where.
        """
        return cls(_core.Scene.freeze(description, checked_threads(threads)), spec)

    @classmethod
    def from_arrays(
        cls,
        vertices: npt.ArrayLike | Sequence[Mesh],
        triangles: npt.ArrayLike | None = None,
        *,
        normals: npt.ArrayLike | None = None,
        colors: npt.ArrayLike | None = None,
        base_color: Sequence[float] | None = None,
        env: Env | None = None,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> Scene:
        """One diffuse, two-sided mesh, or a list of meshes with materials.

        Parameters
        ----------
        vertices : (V, 3) float, or list of (vertices, triangles[, material[, colors]])
            Positions; finite, at most 1e12 in size. A material is an albedo (3,), a mapping with
            the arguments of `SceneDescription.add_material`, or None. Its kind may be a string:
            `{"kind": "glossy", "roughness": 0.3}`.
        triangles : (T, 3) int
            Vertex indices in [0, V). Must be absent if `vertices` is a list of meshes.
        normals : (V, 3) float, optional
            Shading normals of a single mesh.
        colors : (V, 3), (V, 4), (T, 3) or (T, 4), optional
            Colours of the vertices or, if there are T of them and not V, of the triangles of a
            single mesh; they multiply the base colour. Floats are linear, in [0, 1]; uint8 are
            sRGB, as in pictures and trimesh. Alpha is the share of the surface that is there, or
            what a material with `alpha_cutoff` >= 0 is cut by. A vertex keeps four bytes.
        base_color : (3,) float in [0, 1], optional
            Albedo of meshes without a material: 0.5 by default, and 1 with colours.
        env : Sky, path, float, (3,) or (H, W, 3), optional
            Environment light: a lat-long image or constant radiance.
        origin : (3,) float
            The point of the world that becomes (0, 0, 0) of the scene. It is subtracted from
            `vertices` in double precision, so scenes far away keep their digits. See `Scene.local`.

        Raises
        ------
        SceneError
            An index out of range, a vertex that is not finite, or a colour outside of [0, 1].
        ValueError
            Without triangles, `vertices` is not a list of meshes.

        Examples
        --------
        >>> import viscache as vc
        >>> corners, one = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]
        >>> scene = vc.Scene.from_arrays(corners, one)
        >>> scene.visible([0.2, 0.2, 1.0], [[0.2, 0.2, -1.0], [0.9, 0.9, -1.0]])
        array([False,  True])
        >>> vc.Scene.from_arrays([(corners, one), (corners, one, (1.0, 0.0, 0.0))]).triangles
        2
        """
        description = SceneDescription(origin_of(origin))
        add_meshes(description, vertices, triangles, base_color, normals, colors)
        if env is not None:
            apply_environment(description, env)
        return cls.from_description(description)

    @classmethod
    def from_trimesh(
        cls, meshes: Any, *, env: Env | None = None, origin: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> Scene:
        """A scene from trimesh objects.

        Parameters
        ----------
        meshes : trimesh.Trimesh, trimesh.Scene or a list of them
            A trimesh scene keeps its placements. Colours of vertices and faces are kept, as sRGB.
            Of other meshes the main colour becomes the albedo; textures, shading and lights are
            ignored.
        env : Sky, path, float, (3,) or (H, W, 3), optional
            Environment light, as in `from_arrays`.
        origin : (3,) float
            As in `from_arrays`.

        Raises
        ------
        SceneError
            An object has no triangles, or invalid ones.

        Examples
        --------
        >>> import trimesh
        >>> import viscache as vc
        >>> vc.Scene.from_trimesh(trimesh.creation.box(), env=1.0).triangles
        12
        """
        description = SceneDescription(origin_of(origin))
        add_trimesh(description, meshes)
        if env is not None:
            apply_environment(description, env)
        return cls.from_description(description)

    @property
    def name(self) -> str:
        """Name from the file or the built-in scene."""
        return self._core.name

    @property
    def origin(self) -> npt.NDArray[np.float64]:
        """(3,): the point of the world that is (0, 0, 0) of the scene."""
        return np.array(self._core.origin)

    def local(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Points of the world in coordinates of the scene, (..., 3), subtracted in double.

        Cameras, queries, hits and the layer "position" use these. Plus `origin`, they are points of
        the world.

        Examples
        --------
        >>> import viscache as vc
        >>> corners = [[5e7, 0, 0], [5e7 + 1, 0, 0], [5e7, 1, 0]]
        >>> scene = vc.Scene.from_arrays(corners, [[0, 1, 2]], origin=(5e7, 0, 0))
        >>> bool(scene.visible(*scene.local([[5e7 + 0.2, 0.2, 1], [5e7 + 0.2, 0.2, -1]])))
        False
        """
        return checked_floats(points, "points", np.float64) - self.origin

    @property
    def triangles(self) -> int:
        """Number of placed triangles: with instances expanded, without emitting spheres."""
        return self._core.triangles

    @property
    def bounds(self) -> npt.NDArray[np.float32]:
        """(2, 3): lowest and highest corner of the placed geometry."""
        return np.array(self._core.bounds, dtype=np.float32)

    @property
    def cameras(self) -> list[_core.Camera]:
        """Cameras of the file, in order."""
        return _core.scene_cameras(self._core)

    @property
    def lights(self) -> list[dict[str, Any]]:
        """One dict per light, with its kind and its values."""
        return _core.scene_lights(self._core)

    @property
    def materials(self) -> list[dict[str, Any]]:
        """One dict per material; triangles refer to them by index."""
        return _core.scene_materials(self._core)

    @property
    def warnings(self) -> list[str]:
        """Features of the file that are not modelled, with their place, and problems of the scene.

        A problem is: no triangles, no light, or a distance from the origin at which single
        precision loses much of the shape.
        """
        return self._made.get("warnings", lambda: problems(self))

    @property
    def content_hash(self) -> str:
        """Hash of everything that determines the look of the scene."""
        return self._made.get("content_hash", lambda: _core.scene_hash(self._core))

    @property
    def geometry_hash(self) -> str:
        """Hash of what determines visibility: shapes, their places, holes of alpha and opacity."""
        return self._made.get("geometry_hash", lambda: _core.geometry_hash(self._core))

    def meshes(self) -> list[dict[str, Any]]:
        """Arrays of every mesh: vertices, triangles, normals, linear colors, material, emission."""
        return [_core.scene_mesh(self._core, i) for i in range(_core.scene_mesh_count(self._core))]

    @property
    def coplanar_share(self) -> float | None:
        """Share of the placed triangles that are coplanar with a neighbour.

        A high share means subdivided flat faces, which add triangles but no shape. None above 5
        million unique triangles, because counting would take long.
        """
        return self._made.get(
            "coplanar_share", lambda: placed_coplanar_share(self._core, self.meshes)
        )

    def info(self) -> dict[str, Any]:
        """The facts that `viscache info --json` prints."""
        return info(self)

    def description(self) -> SceneDescription:
        """A copy to change, for `from_description`."""
        return _core.description_of(self._core)

    def with_environment(self, env: Env, *, threads: int | None = None) -> Scene:
        """The same scene with another environment light."""
        description = self.description()
        apply_environment(description, env)
        return Scene.from_description(description, spec=self.spec, threads=threads)

    def overview_camera(self) -> _core.Camera:
        """A camera that sees the whole scene from a corner above."""
        center, radius = np.array(self._core.center), self._core.radius
        origin = center + (radius if radius > 2e-30 else 1.0) * np.array([1.2, 0.9, 1.6])
        return _core.look_at(tuple(origin.tolist()), tuple(center.tolist()), (0, 1, 0), 55.0)

    # Queries

    @overload
    def caster(self, rays: None = None, *, threads: int | None = None) -> _core.EmbreeCaster: ...
    @overload
    def caster(self, rays: Bsp, *, threads: int | None = None) -> _core.visibility.BspCaster: ...
    @overload
    def caster(self, rays: Vlf, *, threads: int | None = None) -> _core.vlf.VisibilityField: ...
    @overload
    def caster(self, rays: Rays | str | None, *, threads: int | None = None) -> Caster: ...
    def caster(self, rays: Rays | str | None = None, *, threads: int | None = None) -> Caster:
        """A ray caster over the scene, built on first use.

        The scene keeps all casters of Embree, and the last of the others. All threads get the same
        object; one that asks for it while another builds it waits.

        Parameters
        ----------
        rays : Embree, Bsp or Vlf, optional
            Or "embree", "bsp", "vlf". Default: Embree with its robust flag.
        threads : int, optional
            Threads of the build; all cores by default. The caster is the same for any number.

        Raises
        ------
        MemoryError
            The structure would need more than the settings allow.
        """
        chosen = check_rays(rays)
        if isinstance(chosen, Embree):
            return self._made.get(chosen, lambda: chosen.build(self))
        cores = checked_threads(threads)
        return self._other_caster.get(chosen, lambda: chosen.build(self, cores))

    def aligned_batch(self) -> _core.vlf.AlignedBatch:
        """The triangles in the order of the aligned batch, sorted on first use."""
        return self._made.get("aligned_batch", lambda: _core.vlf.AlignedBatch(self._core))

    def shafts(self) -> _core.ShaftScene:
        """The triangles for `Exact(engine="shafts")`; the tree is built on first use."""
        return self._made.get("shafts", lambda: _core.ShaftScene(self._core))

    def visible(
        self,
        x: npt.ArrayLike,
        y: npt.ArrayLike,
        *,
        rays: Rays | str | None = None,
        threads: int | None = None,
    ) -> npt.NDArray[np.bool_]:
        """Does x see y?

        Parameters
        ----------
        x, y : (..., 3) float
            End points in scene units, broadcast as in NumPy. The segment is shortened at both ends
            by 32 units in the last place of the larger coordinate, so that surfaces at the ends do
            not block it.
        rays : Embree, Bsp or Vlf, optional
            The ray caster, as in `caster`.
        threads : int, optional
            All cores by default.

        Returns
        -------
        (...) bool

        Raises
        ------
        ValueError
            Shapes do not broadcast, or coordinates are not finite or above 1e16.

        Examples
        --------
        A matrix of four points and two:

        >>> import numpy as np
        >>> import viscache as vc
        >>> x, y = np.eye(4, 3) + 1, np.eye(2, 3) + 3
        >>> vc.scenes.cube_on_plane().visible(x[:, None], y[None]).shape
        (4, 2)
        """
        return queries.visible(self.caster(rays, threads=threads), x, y, threads)

    def visible_matrix(
        self,
        points: npt.ArrayLike,
        targets: npt.ArrayLike,
        *,
        rays: Rays | str | None = None,
        engine: queries.MatrixEngine = "auto",
        threads: int | None = None,
        progress: bool | Callable[[int, int], None] = False,
    ) -> npt.NDArray[np.uint64]:
        """Does each of N points see each of M targets? One bit per pair.

        The answers equal `visible(points[:, None], targets[None])`. Rays are generated tile by
        tile, which takes 1/512 of its memory.

        Where points lie more densely than triangles, shafts answer many of them at once, with the
        same bits.

        Parameters
        ----------
        points : (N, 3) float
        targets : (M, 3) float
            In scene units. Segments are shortened as in `visible`.
        rays : Embree, Bsp or Vlf, optional
            As in `visible`. With `Embree(robust=False)`, answers of rays through an edge may differ
            from those of `visible`.
        engine : {"auto", "packets", "shafts"}
            As in `Exact`, for targets instead of lights. "auto": shafts with `Embree()` where they
            pay, and packets of 16 rays elsewhere.
        threads : int, optional
            All cores by default; the bits do not depend on it.
        progress : bool or callable
            True shows a progress bar; a callable is called with (done, total).

        Returns
        -------
        (N, ⌈M/64⌉) uint64
            Bit k % 64 of word k // 64 of row i is 1 if point i sees target k; unused bits are 0.

        Raises
        ------
        ValueError
            Shapes are wrong, coordinates are not finite or above 1e16, or the engine is shafts with
            other rays than `Embree()`.
        KeyboardInterrupt
            Within half a second of Ctrl-C.

        Examples
        --------
        >>> import numpy as np
        >>> import viscache as vc
        >>> scene = vc.scenes.cube_on_plane()
        >>> bits = scene.visible_matrix(np.eye(4, 3) + 1, np.eye(2, 3) + 3)
        >>> np.unpackbits(bits.view(np.uint8), axis=1, bitorder="little", count=2).shape
        (4, 2)
        """
        return queries.matrix(self, points, targets, rays, engine, threads, progress)

    def occluded(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        t_max: float | npt.ArrayLike = np.inf,
        *,
        rays: Rays | str | None = None,
        threads: int | None = None,
    ) -> npt.NDArray[np.bool_]:
        """Does a ray hit anything up to t_max?

        A surface through the ray's origin counts only with Embree's robust rays. A surface at t_max
        within rounding error may count or not.

        Parameters
        ----------
        origins, directions : (..., 3) float
            Directions of any length; a zero direction hits nothing. Both broadcast with `t_max`.
        t_max : float or (...) float, >= 0
            In units of the direction's length.
        rays, threads
            As in `visible`.

        Returns
        -------
        (...) bool

        Raises
        ------
        ValueError
            As in `visible`.
        """
        caster = self.caster(rays, threads=threads)
        return queries.occluded(caster, origins, directions, t_max, threads)

    def intersect(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        rays: Rays | str | None = None,
        threads: int | None = None,
    ) -> Intersection:
        """Nearest hits of (..., 3) rays, which broadcast; see `Intersection`."""
        return queries.intersect(self.caster(rays, threads=threads), origins, directions, threads)

    def _repr_html_(self) -> str:
        return scene_html(self, Scene._picture)

    def oracle(
        self,
        visibility: Visibility | Written | str,
        *,
        rays: Rays | str | None = None,
        use: Literal["replace", "correct"] | Correct | None = None,
        seed: int = 0,
        spp: int = 1,
        threads: int | None = None,
    ) -> Oracle:
        """A visibility cache as a module that takes arrays of points and returns bits.

        Parameters
        ----------
        visibility : Exact, Aqvc, ShadowMap, NeePlusPlus, or an oracle of your own
            Or its name with default settings, as in `viscache.render`.
        rays : Embree, Bsp or Vlf, optional
            As in `visible`.
        use : {"replace", "correct"} or Correct, optional
            As in `viscache.render`.
        seed : int >= 0
            Seed of random methods.
        spp : int in [1, 2^20]
            Samples per pixel if the points are eye samples; decides whether refinement pays off.
        threads : int, optional
            All cores by default; the bits do not depend on it.

        Returns
        -------
        Oracle
            With `block(eyes, lamps)` and `pairs(eyes, index, ends)`.

        Raises
        ------
        ValueError
            The visibility does not answer single connections, such as `VisMaps`.
        """
        return Oracle(self, visibility, rays=rays, use=use, seed=seed, spp=spp, threads=threads)

    def __repr__(self) -> str:
        return f"<viscache.Scene {self.name or 'unnamed'}: {self.triangles:,} triangles>"
