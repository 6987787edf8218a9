"""Builder: collects shapes, fits them to a triangle budget and writes a `SceneDescription`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.scenes.palette import COLORS, Rgb
from viscache.scenes.shapes import Array, Indices, Shape

MOST_DETAIL = 64.0
LEAST_DETAIL = 0.02
ROUGH_DETAIL = 0.4  # below this detail, clutter is left out before shapes get coarser
BARE_DETAIL = 0.1  # below this detail, furniture is left out
GOLDEN = 0.6180339887498949


@dataclass(frozen=True, slots=True)
class _Placement:
    shape: Shape
    material: int
    transforms: Array  # (K, 4, 4)
    order: float  # scattered rank in [0, 1): the order in which optional parts are dropped
    optional: bool
    emission: Rgb

    def n_triangles(self, detail: float) -> int:
        # Ranks distribute the rounding, so that the total grows in small steps.
        return self.shape.n_triangles(detail * (0.9 + 0.2 * self.order)) * len(self.transforms)

    def mesh(self, detail: float) -> tuple[Array, Indices]:
        vertices, triangles = self.shape.mesh(detail * (0.9 + 0.2 * self.order))
        k = len(self.transforms)
        turned = vertices @ self.transforms[:, :3, :3].transpose(0, 2, 1)
        moved = (turned + self.transforms[:, None, :3, 3]).reshape(-1, 3)
        offsets = (np.arange(k, dtype=np.uint32) * len(vertices))[:, None, None]
        return moved, (triangles[None] + offsets).reshape(-1, 3)


@dataclass
class Builder:
    """Materials, placed shapes, lights and cameras of one scene.

    Shapes are tessellated by `fit`, which finds the detail that meets a triangle budget.
    `sizes` has the triangles of each mesh, `placed` those of all in the world and of instances.
    """

    name: str
    description: _core.SceneDescription = field(default_factory=_core.SceneDescription)
    sizes: list[int] = field(default_factory=list)
    placed: int = 0
    detail: float = 1.0
    _materials: dict[str, int] = field(default_factory=dict)
    _placements: list[_Placement] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.description.name = self.name

    def diffuse(self, name: str, color: Rgb) -> int:
        """Two-sided Lambertian material, one per name."""
        return self._material(name, _core.MaterialKind.DIFFUSE, base_color=color)

    def paint(self, name: str) -> int:
        """The diffuse material of a color of the palette."""
        return self.diffuse(name, COLORS[name])

    def glossy(self, name: str, color: Rgb, specular: float, roughness: float) -> int:
        """Lambertian base with a GGX lobe."""
        kind = _core.MaterialKind.GLOSSY
        grey = (specular,) * 3
        return self._material(name, kind, base_color=color, specular=grey, roughness=roughness)

    def mirror(self, name: str, reflectance: float = 0.95) -> int:
        """Perfect mirror."""
        return self._material(name, _core.MaterialKind.MIRROR, specular=(reflectance,) * 3)

    def glass(self, name: str, eta: float = 1.5) -> int:
        """Smooth dielectric."""
        return self._material(name, _core.MaterialKind.DIELECTRIC, eta=eta)

    def _material(
        self,
        name: str,
        kind: _core.MaterialKind,
        *,
        base_color: Rgb = (0.5, 0.5, 0.5),
        specular: Rgb = (1.0, 1.0, 1.0),
        roughness: float = 0.1,
        eta: float = 1.5,
    ) -> int:
        if name not in self._materials:
            self._materials[name] = self.description.add_material(
                kind, base_color=base_color, specular=specular, roughness=roughness, eta=eta
            )
        return self._materials[name]

    def add(
        self,
        shape: Shape,
        material: int | str,
        to_world: Array | None = None,
        *,
        optional: bool = False,
        emission: Rgb = (0.0, 0.0, 0.0),
    ) -> None:
        """Place `shape` by one (4, 4) or many (..., 4, 4) transforms.

        A material with a name is a color of the palette.
        `optional` parts are clutter: if the budget is too small, scattered ones are left out.
        """
        if isinstance(material, str):
            material = self.paint(material)
        transforms = np.eye(4)[None] if to_world is None else to_world.reshape(-1, 4, 4)
        groups = min(5, len(transforms)) if len(transforms) >= 8 or optional else 1
        for part in np.array_split(transforms, groups):
            order = (len(self._placements) * GOLDEN) % 1.0
            self._placements.append(_Placement(shape, material, part, order, optional, emission))

    def fit(self, triangles: int, *, slack: float = 1.25) -> None:
        """Tessellate all placed shapes so that they have `triangles` to `slack` * `triangles`."""
        _, self.detail = self._details_around(triangles)
        if self._total(self.detail) > slack * triangles:
            total = self._total(self.detail)
            raise ValueError(f"triangles must be >= {total}, got {triangles}")
        self.write()

    def fit_below(self, triangles: int) -> int:
        """Tessellate all placed shapes to `triangles` or fewer; returns how many are missing."""
        self.detail, _ = self._details_around(triangles)
        missing = triangles - self._total(self.detail)
        if missing < 0:
            raise ValueError(f"triangles must be >= {triangles - missing}, got {triangles}")
        self.write()
        return missing

    def _details_around(self, triangles: int) -> tuple[float, float]:
        """Adjacent details: one gives fewer triangles, the other as many or more."""
        self._drop_clutter(triangles)
        low, high = LEAST_DETAIL, MOST_DETAIL
        if self._total(high) < triangles:
            raise ValueError(f"triangles must be <= {self._total(high)}, got {triangles}")
        if self._total(low) >= triangles:
            return low, low
        for _ in range(20):
            middle = (low * high) ** 0.5
            low, high = (low, middle) if self._total(middle) >= triangles else (middle, high)
        return low, high

    def write(self, detail: float | None = None) -> None:
        """Tessellate the placed shapes at `detail` into one mesh per material and emission."""
        detail = self.detail if detail is None else detail
        groups: dict[tuple[int, Rgb], list[tuple[Array, Indices]]] = {}
        for p in self._placements:
            groups.setdefault((p.material, p.emission), []).append(p.mesh(detail))
        names = list(self._materials)
        for (material, emission), parts in groups.items():
            vertices, triangles = join(parts)
            self.add_mesh(vertices, triangles, material, name=names[material], emission=emission)
        self._placements.clear()

    def _total(self, detail: float) -> int:
        return sum(p.n_triangles(detail) for p in self._placements)

    def _drop_clutter(self, triangles: int) -> None:
        # Clutter is dropped first; if necessary also furniture, and walls last.
        for detail, everything in ((ROUGH_DETAIL, False), (BARE_DETAIL, True)):
            tier = [p for p in self._placements if p.optional or everything]
            total = self._total(detail)
            gone: set[int] = set()
            for part in sorted(tier, key=lambda p: -p.order):
                if total <= triangles:
                    break
                if type(part.shape) is not Shape:
                    total -= part.n_triangles(detail)
                    gone.add(id(part))
            self._placements = [p for p in self._placements if id(p) not in gone]

    def add_mesh(
        self,
        vertices: npt.ArrayLike,
        triangles: Indices,
        material: int,
        *,
        name: str = "",
        emission: Rgb = (0.0, 0.0, 0.0),
        in_world: bool = True,
    ) -> int:
        """Write a mesh unchanged; returns its index."""
        points = np.ascontiguousarray(vertices, np.float32)
        faces = np.ascontiguousarray(triangles, np.uint32)
        self.sizes.append(len(faces))
        self.placed += len(faces) * in_world
        return self.description.add_mesh(
            points, faces, material=material, emission=emission, in_world=in_world, name=name
        )

    def add_instance(self, meshes: Sequence[int], to_world: Array) -> None:
        """Add a placement of meshes written with in_world=False."""
        self.placed += sum(self.sizes[k] for k in meshes)
        self.description.add_instance(list(meshes), to_world)

    def point_light(self, position: npt.ArrayLike, intensity: npt.ArrayLike) -> None:
        """Point light; intensity in W/sr, one number or RGB."""
        p, c = _three(position), _three(np.broadcast_to(np.asarray(intensity, float), (3,)))
        self.description.add_point_light(p, c)

    def camera(
        self,
        origin: Rgb,
        target: Rgb,
        fov_deg: float,
        *,
        name: str = "camera",
        up: Rgb = (0.0, 1.0, 0.0),
        size: tuple[int, int] = (640, 400),
        horizontal: bool = False,
    ) -> None:
        """Pinhole camera; `fov_deg` is vertical unless `horizontal`."""
        self.description.add_camera(
            origin,
            target,
            up=up,
            fov_deg=fov_deg,
            width=size[0],
            height=size[1],
            horizontal=horizontal,
            name=name,
        )


def join(parts: Sequence[tuple[Array, Indices]]) -> tuple[Array, Indices]:
    """Meshes appended to one another."""
    starts = np.cumsum([0] + [len(v) for v, _ in parts])
    triangles = [t + np.uint32(s) for (_, t), s in zip(parts, starts, strict=False)]
    return np.concatenate([v for v, _ in parts]), np.concatenate(triangles)


def _three(values: npt.ArrayLike) -> Rgb:
    x, y, z = (float(v) for v in np.asarray(values, float))
    return x, y, z
