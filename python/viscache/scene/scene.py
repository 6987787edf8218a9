"""Scenes: loaded from files, made from arrays, asked for exact visibility."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias, overload

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache._core import SceneDescription, SceneError
from viscache.oracles.correct import Correct
from viscache.oracles.oracle import Oracle
from viscache.oracles.written import Written
from viscache.scene.coplanar import coplanar_share
from viscache.scene.environments import apply_environment, decode_images
from viscache.settings.checks import checked_points, checked_threads
from viscache.settings.rays import Bsp, Caster, Embree, Rays, Vlf, check_rays
from viscache.settings.visibility import Visibility

__all__ = ["Intersection", "Scene", "SceneError", "load_scene"]

Env: TypeAlias = "str | os.PathLike[str] | float | Sequence[float] | npt.NDArray[np.floating[Any]]"


MOST_COUNTED_TRIANGLES = 5_000_000


class Intersection(NamedTuple):
    """Nearest hits of N rays.

    Attributes
    ----------
    t : (N,) float32
        Distance in units of the direction's length; inf where nothing is hit. A surface through the
        origin itself is hit at 0 by Embree's robust rays, not by others: start off it.
    triangle : (N,) int64
        Index over the triangles of all meshes in order (instances share theirs); -1 for a miss.
    barycentrics : (N, 2) float32
        Weights of the triangle's vertices 1 and 2; NaN for a miss.
    instance : (N,) int64
        Index of the instance; -1 for a miss or a mesh that is not instanced.
    """

    t: npt.NDArray[np.float32]
    triangle: npt.NDArray[np.int64]
    barycentrics: npt.NDArray[np.float32]
    instance: npt.NDArray[np.int64]


#: Sizes from the origin from which on a scene is warned of.
FAR_AWAY = 1e4


class Scene:
    """An immutable scene.

    Made by `load_scene`, `Scene.from_arrays`, a function of `viscache.scenes`, or
    `Scene.from_description`.
    """

    def __init__(self, core: _core.Scene, spec: str | None = None) -> None:
        self._core = core
        #: What the scene was made from: a path or `room?triangles=…`; None for arrays.
        self.spec = spec
        self._embree: dict[Embree, _core.EmbreeCaster] = {}
        self._other: tuple[Rays, Caster] | None = None
        self._batch: _core.vlf.AlignedBatch | None = None

    @classmethod
    def from_description(
        cls, description: SceneDescription, *, spec: str | None = None, threads: int | None = None
    ) -> Scene:
        """Freeze a description, on all cores by default; the scene is the same on any number.

        Raises
        ------
        SceneError
            Something in it cannot be used; the message says what and where.
        """
        return cls(_core.Scene.freeze(description, checked_threads(threads)), spec)

    @classmethod
    def from_arrays(
        cls,
        vertices: npt.ArrayLike,
        triangles: npt.ArrayLike,
        *,
        normals: npt.ArrayLike | None = None,
        base_color: Sequence[float] = (0.5, 0.5, 0.5),
        env: Env | None = None,
    ) -> Scene:
        """One diffuse, two-sided mesh.

        Parameters
        ----------
        vertices : (V, 3) float
            Positions; finite, at most 1e16 in size.
        triangles : (T, 3) int
            Vertex indices in [0, V).
        normals : (V, 3) float, optional
            Shading normals.
        base_color : (3,) float in [0, 1]
            Albedo.
        env : path, float, (3,) or (H, W, 3), optional
            Environment light: a lat-long image or constant radiance.

        Raises
        ------
        SceneError
            An index out of range or a vertex that is not finite.

        Examples
        --------
        >>> import viscache as vc
        >>> scene = vc.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        >>> scene.visible([[0.2, 0.2, 1.0]], [[0.2, 0.2, -1.0]])
        array([False])
        """
        indices = np.asarray(triangles)
        if indices.size and indices.dtype.kind not in "iu":
            raise SceneError(f"triangles must be integers, got dtype {indices.dtype}")
        if indices.size and (indices.min() < 0 or indices.max() > 0xFFFFFFFF):
            low, high = indices.min(), indices.max()
            raise SceneError(f"triangles must index vertices, got values from {low} to {high}")
        description = SceneDescription()
        material = description.add_material(base_color=_rgb(base_color, "base_color"))
        description.add_mesh(
            vertices, indices.astype(np.uint32), material=material, normals=normals
        )
        if env is not None:
            apply_environment(description, env)
        return cls.from_description(description)

    # What it is

    @property
    def name(self) -> str:
        """Name given by the file or the built-in scene."""
        return self._core.name

    @property
    def triangles(self) -> int:
        """Placed triangles: instances expanded, emitting spheres not counted."""
        return self._core.triangles

    @property
    def bounds(self) -> npt.NDArray[np.float32]:
        """(2, 3): lowest and highest corner of everything placed."""
        return np.array(self._core.bounds, dtype=np.float32)

    @property
    def cameras(self) -> list[_core.Camera]:
        """Cameras of the file, in order."""
        return _core.scene_cameras(self._core)

    @property
    def lights(self) -> list[dict[str, Any]]:
        """One dict per light: its kind and its values."""
        return _core.scene_lights(self._core)

    @cached_property
    def warnings(self) -> list[str]:
        """What the file asked for that is not modelled, with its place; what to know of a scene.

        That it has no light, or lies so far from the origin that single precision has lost much of
        its shape.
        """
        texts = [
            f"{where}: {text}" if where else text
            for where, text in _core.scene_warnings(self._core)
        ]
        if not self.lights:
            texts.append("the scene has no light; give it one with env=")
        return texts + self._far_away()

    def _far_away(self) -> list[str]:
        low, high = self.bounds.astype(float)
        size = float(np.max(high - low))
        if not (np.isfinite(size) and size > 0):
            return []
        away = float(np.max(np.abs(low + high))) / 2 / size
        if away <= FAR_AWAY:
            return []
        steps = size / np.spacing(np.float32(away * size))
        return [
            f"the scene lies {away:.3g} times its size from the origin, where single precision "
            f"leaves it {steps:.3g} steps across"
        ]

    @cached_property
    def content_hash(self) -> str:
        """Hash of everything that decides how the scene looks."""
        return _core.scene_hash(self._core)

    @cached_property
    def geometry_hash(self) -> str:
        """Hash of what decides who sees whom: shapes, where they are, and holes cut by alpha."""
        return _core.geometry_hash(self._core)

    def meshes(self) -> list[dict[str, Any]]:
        """Arrays of every mesh: vertices, triangles, normals, material, emission."""
        return [_core.scene_mesh(self._core, i) for i in range(_core.scene_mesh_count(self._core))]

    @cached_property
    def coplanar_share(self) -> float | None:
        """Share of the placed triangles that lie in one plane with a neighbour.

        Many of them are flat faces cut up: they raise the count without adding shape. None above 5
        million unique triangles, where counting would take long.
        """
        if self._core.unique_triangles > MOST_COUNTED_TRIANGLES:
            return None
        meshes = self.meshes()
        placed = np.array([int(m["in_world"]) for m in meshes], dtype=float)
        for members, _ in _core.scene_instances(self._core):
            placed[list(members)] += 1
        counts = placed * [len(m["triangles"]) for m in meshes]
        shares = [
            coplanar_share(m["vertices"], m["triangles"]) if count else 0.0
            for m, count in zip(meshes, counts, strict=True)
        ]
        return float(counts @ shares / counts.sum()) if counts.sum() > 0 else 0.0

    def info(self) -> dict[str, Any]:
        """What `viscache info --json` prints."""
        bounds = [[float(str(v)) for v in corner] for corner in self.bounds]
        return {
            "name": self.name,
            "triangles": self.triangles,
            "unique_triangles": self._core.unique_triangles,
            "instances": self._core.instances,
            "bounds": bounds,
            "lights": self.lights,
            "cameras": [
                {
                    "name": c.name,
                    "origin": list(c.origin),
                    "forward": list(c.forward),
                    "size": [c.width, c.height],
                }
                for c in self.cameras
            ],
            "memory_bytes": self._core.memory_bytes,
            "coplanar_share": self.coplanar_share,
            "content_hash": self.content_hash,
            "warnings": self.warnings,
        }

    def with_environment(self, env: Env, *, threads: int | None = None) -> Scene:
        """The same scene under another environment light."""
        description = _core.description_of(self._core)
        apply_environment(description, env)
        return Scene.from_description(description, spec=self.spec, threads=threads)

    def overview_camera(self) -> _core.Camera:
        """A camera that sees the whole scene from a corner above."""
        center = np.array(self._core.center)
        radius = self._core.radius if self._core.offset_extent > 0 else 1.0
        origin = center + radius * np.array([1.2, 0.9, 1.6])
        up = (0.0, 1.0, 0.0)
        return _core.look_at(tuple(origin.tolist()), tuple(center.tolist()), up, 55.0)

    # What it answers

    @overload
    def caster(
        self, rays: Embree | None = None, *, threads: int | None = None
    ) -> _core.EmbreeCaster: ...
    @overload
    def caster(self, rays: Bsp, *, threads: int | None = None) -> _core.visibility.BspCaster: ...
    @overload
    def caster(self, rays: Vlf, *, threads: int | None = None) -> _core.vlf.VisibilityField: ...
    @overload
    def caster(self, rays: Rays | None, *, threads: int | None = None) -> Caster: ...
    def caster(self, rays: Rays | None = None, *, threads: int | None = None) -> Caster:
        """A ray caster over the scene, built on first use.

        Embree's stay with the scene; of the others, the one asked for last.

        Parameters
        ----------
        rays : Embree, Bsp or Vlf, optional
            Embree, robust, by default.
        threads : int, optional
            To build with; all cores by default. The caster is the same on any number.

        Raises
        ------
        MemoryError
            The structure would need more than the settings allow.
        """
        rays = Embree() if rays is None else check_rays(rays)
        if isinstance(rays, Embree):
            if rays not in self._embree:
                self._embree[rays] = rays.build(self._core)
            return self._embree[rays]
        if self._other is None or self._other[0] != rays:
            self._other = None  # before the next one takes memory
            self._other = rays, rays.build(self._core, checked_threads(threads))
        return self._other[1]

    def aligned_batch(self) -> _core.vlf.AlignedBatch:
        """The triangles as aligned rays meet them, put in order on first use."""
        if self._batch is None:
            self._batch = _core.vlf.AlignedBatch(self._core)
        return self._batch

    def visible(
        self,
        x: npt.ArrayLike,
        y: npt.ArrayLike,
        *,
        rays: Rays | None = None,
        threads: int | None = None,
    ) -> npt.NDArray[np.bool_]:
        """Does x see y?

        Parameters
        ----------
        x, y : (N, 3) float
            End points, in scene units. The segment is shortened at both ends by 32 units in the
            last place of the larger coordinate, so that surfaces at the ends do not block it.
        rays : Embree, Bsp or Vlf, optional
            Who traces; Embree by default.
        threads : int, optional
            All cores by default.

        Returns
        -------
        (N,) bool

        Raises
        ------
        ValueError
            Wrong shapes, or coordinates that are not finite or above 1e16.
        """
        ends = checked_points(x, "x"), checked_points(y, "y")
        return self.caster(rays, threads=threads).visible(*ends, checked_threads(threads))

    def occluded(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        t_max: float | npt.ArrayLike = np.inf,
        *,
        rays: Rays | None = None,
        threads: int | None = None,
    ) -> npt.NDArray[np.bool_]:
        """Does a ray hit anything up to t_max?

        A surface through the origin itself counts with Embree's robust rays alone; what lies at
        t_max within rounding may count or not.

        Parameters
        ----------
        origins, directions : (N, 3) float
            Directions of any length; a zero direction hits nothing.
        t_max : float or (N,) float, >= 0
            In units of the direction's length.
        rays : Embree, Bsp or Vlf, optional
            Who traces; Embree by default.
        threads : int, optional
            All cores by default.

        Returns
        -------
        (N,) bool
        """
        o, d = checked_points(origins, "origins"), checked_points(directions, "directions")
        cores = checked_threads(threads)
        return self.caster(rays, threads=threads).occluded(o, d, t_max, cores)

    def intersect(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        rays: Rays | None = None,
        threads: int | None = None,
    ) -> Intersection:
        """Nearest hits of (N, 3) rays; see `Intersection`."""
        o, d = checked_points(origins, "origins"), checked_points(directions, "directions")
        caster = self.caster(rays, threads=threads)
        return Intersection(*caster.intersect(o, d, checked_threads(threads)))

    def oracle(
        self,
        visibility: Visibility | Written,
        *,
        rays: Rays | None = None,
        use: Literal["replace", "correct"] | Correct | None = None,
        seed: int = 0,
        spp: int = 1,
        threads: int | None = None,
    ) -> Oracle:
        """A visibility cache as a module: arrays of points in, bits out.

        Parameters
        ----------
        visibility : Exact, Aqvc, ShadowMap, NeePlusPlus, or an oracle of your own
        rays : Embree, Bsp or Vlf, optional
            Who traces.
        use : {"replace", "correct"} or Correct, optional
            As in `viscache.render`.
        seed : int >= 0
            Of methods that draw at random.
        spp : int >= 1
            Eye samples per pixel, where the points are such: it tells whether refinement pays.
        threads : int, optional
            All cores by default. Answers are the same bits for any number.

        Returns
        -------
        Oracle
            With `block(eyes, lamps)` and `pairs(eyes, index, ends)`.

        Raises
        ------
        ValueError
            A visibility that answers no single connections, such as VisMaps.
        """
        return Oracle(self, visibility, rays=rays, use=use, seed=seed, spp=spp, threads=threads)

    def __repr__(self) -> str:
        return f"<viscache.Scene {self.name or 'unnamed'}: {self.triangles:,} triangles>"


def load_scene(
    path: str | os.PathLike[str],
    *,
    strict: bool = False,
    env: Env | None = None,
    threads: int | None = None,
) -> Scene:
    """Load a scene file.

    Parameters
    ----------
    path : path
        `.xml` (Mitsuba), `.pbrt`, `.gltf`, `.glb`, `.obj` or `.ply`.
    strict : bool
        Make what viscache does not model an error; by default it is skipped and named in
        `Scene.warnings`.
    env : path, float, (3,) or (H, W, 3), optional
        Environment light that replaces the file's.
    threads : int, optional
        All cores by default.

    Raises
    ------
    SceneError
        A missing, malformed or inconsistent file; names file and place.
    """
    if str(path) and Path(path).is_dir():
        raise SceneError(f"{path}: is a directory, not a scene file")
    description = _core.load_scene_file(os.fspath(path), strict=strict)
    decode_images(description, strict=strict)
    if env is not None:
        apply_environment(description, env)
    return Scene.from_description(description, spec=str(Path(path)), threads=threads)


def _rgb(value: Sequence[float], name: str) -> tuple[float, float, float]:
    rgb = tuple(float(v) for v in value)
    if len(rgb) != 3:
        raise ValueError(f"{name} must have 3 values, got {len(rgb)}")
    return rgb
