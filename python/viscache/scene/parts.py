"""Adds meshes with materials, from arrays or trimesh, to a description."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache._core import SceneDescription, SceneError
from viscache.base.real_numbers import real_array
from viscache.settings.checks import checked_floats, require

#: Vertices (V, 3), triangles (T, 3), perhaps its own material, an albedo (3,) or a mapping with the
#: arguments of `SceneDescription.add_material`, and perhaps colours.
Mesh: TypeAlias = (
    "tuple[npt.ArrayLike, npt.ArrayLike] | tuple[npt.ArrayLike, npt.ArrayLike, Any]"
    " | tuple[npt.ArrayLike, npt.ArrayLike, Any, npt.ArrayLike]"
)


def origin_of(given: Any) -> tuple[float, float, float]:
    """The origin of a scene; ValueError unless it is three finite numbers."""
    point = checked_floats(given, "origin", np.float64)
    good = point.shape == (3,) and bool(np.isfinite(point).all())
    require(good, "origin must be 3 finite numbers", given)
    x, y, z = point.tolist()
    return x, y, z


def add_meshes(
    description: SceneDescription,
    vertices: npt.ArrayLike | Sequence[Mesh],
    triangles: npt.ArrayLike | None,
    base_color: Any,
    normals: npt.ArrayLike | None,
    colors: npt.ArrayLike | None,
) -> None:
    """Add one mesh, or a list of meshes in the place of vertices."""
    if triangles is not None:
        one = cast("npt.ArrayLike", vertices)
        return add_mesh(description, one, triangles, base_color, normals, colors=colors)
    for name, given in (("normals", normals), ("colors", colors)):
        require(given is None, f"{name} must be left out with a list of meshes", given)
    for mesh in _checked_meshes(vertices):
        material = mesh[2] if len(mesh) > 2 and mesh[2] is not None else base_color
        own = mesh[3] if len(mesh) > 3 else None
        add_mesh(description, mesh[0], mesh[1], material, colors=own)


def _checked_meshes(value: Any) -> Sequence[Mesh]:
    """The list of meshes; ValueError for anything else."""
    listed = isinstance(value, (list, tuple)) and all(
        isinstance(mesh, (list, tuple)) and 2 <= len(mesh) <= 4 for mesh in value
    )
    require(
        listed,
        "meshes must be a list of (vertices, triangles), (vertices, triangles, material) or"
        " (vertices, triangles, material, colors), where triangles are left out",
        type(value).__name__,
    )
    meshes: Sequence[Mesh] = value
    return meshes


def add_mesh(
    description: SceneDescription,
    vertices: npt.ArrayLike,
    triangles: npt.ArrayLike,
    material: Any,
    normals: npt.ArrayLike | None = None,
    name: str = "",
    colors: npt.ArrayLike | None = None,
    face_colors: npt.NDArray[Any] | None = None,
) -> None:
    """Add a mesh with its own material: an albedo, a mapping, or None for the default."""
    indices = np.asarray(triangles)
    if indices.size and indices.dtype.kind not in "iu":
        raise SceneError(f"triangles must be integers, got dtype {indices.dtype}")
    if indices.size and (indices.min() < 0 or indices.max() > 0xFFFFFFFF):
        low, high = indices.min(), indices.max()
        raise SceneError(f"triangles must index vertices, got values from {low} to {high}")
    points = _real(vertices, "vertices")
    look: dict[str, Any] = {} if colors is None else _colors(colors, points, indices)
    if face_colors is not None:
        look = {"face_colors": face_colors}
    if material is None:
        material = (1.0, 1.0, 1.0) if look else (0.5, 0.5, 0.5)
    has_alpha = any(given.shape[-1] == 4 for given in look.values())
    if has_alpha and not isinstance(material, Mapping):
        # Alpha is a share of the surface, unless the material says at which alpha it ends
        material = {"base_color": _albedo_of(material), "alpha_cutoff": -1.0}
    description.add_mesh(
        points,
        indices.astype(np.uint32),
        material=_add_material(description, material),
        normals=None if normals is None else _real(normals, "normals"),
        name=name,
        **look,
    )


def _colors(
    given: npt.ArrayLike, points: npt.NDArray[Any], triangles: npt.NDArray[Any]
) -> dict[str, Any]:
    """The argument of `SceneDescription.add_mesh` that takes these colours."""
    vertices, faces = (len(rows) if rows.ndim else 0 for rows in (points, triangles))
    array = _real(real_array(given, "colors"), "colors")
    good = array.ndim == 2 and len(array) in (vertices, faces) and array.shape[1] in (3, 4)
    require(
        good,
        f"colors must have shape ({vertices}, 3 or 4), for vertices, or ({faces}, 3 or 4), for"
        " faces",
        array.shape,
    )
    require(
        array.dtype.kind == "f" or array.dtype == np.uint8,
        "colors must be floats in [0, 1] or bytes of dtype uint8",
        array.dtype,
    )
    return {"colors" if len(array) == vertices else "face_colors": array}


def _real(given: npt.ArrayLike, name: str) -> npt.NDArray[Any]:
    """Numbers that are not complex; SceneError for others."""
    array = np.asarray(given)
    if array.size and array.dtype.kind not in "fiu":
        raise SceneError(f"{name} must be real numbers, got dtype {array.dtype}")
    return array


def _add_material(description: SceneDescription, material: Any) -> int:
    if isinstance(material, Mapping):
        given = dict(material)
        kind = _named(_core.MaterialKind, "kind", given.pop("kind", _core.MaterialKind.DIFFUSE))
        coat = _named(_core.CoatKind, "coat", given.pop("coat", _core.CoatKind.NONE))
        return description.add_material(kind, coat=coat, **given)
    return description.add_material(base_color=_albedo_of(material))


def _albedo_of(material: Any) -> tuple[float, float, float]:
    try:
        rgb = tuple(float(v) for v in real_array(material, "base_color"))
    except (TypeError, ValueError):
        raise ValueError(f"base_color must be 3 numbers, got {material!r}") from None
    require(len(rgb) == 3, "base_color must have 3 values", len(rgb))
    return rgb[0], rgb[1], rgb[2]


def _named(kinds: Any, what: str, given: Any) -> Any:
    """A member of the enum, also by its name in lower case."""
    if not isinstance(given, str):
        return given
    known = [k.name.lower() for k in kinds]
    require(given in known, f"{what} of a material must be one of {known}", given)
    return kinds[given.upper()]


def add_trimesh(description: SceneDescription, given: Any) -> None:
    """Add a trimesh.Trimesh, a trimesh.Scene, or several; recognised by their attributes."""
    for name, mesh, to_world in _placed(given):
        if not (hasattr(mesh, "vertices") and hasattr(mesh, "faces")):
            kind = type(mesh).__name__
            raise SceneError(
                f"meshes must be triangle meshes of trimesh, got {name or kind}: {kind}"
            )
        vertices = checked_floats(mesh.vertices, "vertices", np.float64)
        vertices = vertices @ to_world[:3, :3].T + to_world[:3, 3]
        triangles = np.asarray(mesh.faces)
        if np.linalg.det(to_world[:3, :3]) < 0:  # a mirrored mesh keeps its orientation
            triangles = triangles[:, ::-1]
        colors = _visual_colors(mesh)
        material = None if colors else _albedo(mesh)
        add_mesh(description, vertices, triangles, material, name=name, **colors)


def _placed(given: Any) -> Iterable[tuple[str, Any, npt.NDArray[np.float64]]]:
    """(name, mesh, matrix (4, 4)) of every placed mesh."""
    if isinstance(given, (list, tuple)):
        for one in given:
            yield from _placed(one)
    elif hasattr(given, "graph") and hasattr(given, "geometry"):
        for node in given.graph.nodes_geometry:
            matrix, name = given.graph[node]
            yield str(node), given.geometry[name], np.asarray(matrix, dtype=np.float64)
    else:
        yield str((getattr(given, "metadata", None) or {}).get("name", "")), given, np.eye(4)


def _visual_colors(mesh: Any) -> dict[str, npt.NDArray[Any]]:
    """RGBA bytes of vertices or faces, of a mesh that has such colours."""
    visual: Any = getattr(mesh, "visual", None)
    kind = getattr(visual, "kind", None)
    if kind == "vertex":
        return {"colors": np.asarray(visual.vertex_colors)}
    return {"face_colors": np.asarray(visual.face_colors)} if kind == "face" else {}


def _albedo(mesh: Any) -> tuple[float, ...]:
    """The main colour of the mesh's material, RGBA bytes in trimesh."""
    visual = getattr(mesh, "visual", None)
    source = getattr(visual, "material", visual)
    color = np.asarray(getattr(source, "main_color", (127.5,) * 3), dtype=np.float64)
    return tuple(np.clip(color.reshape(-1)[:3] / 255, 0, 1).tolist())
