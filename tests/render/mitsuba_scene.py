"""Small scenes said once and built twice: for viscache and for Mitsuba 3."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache._core import CoatKind, MaterialKind

Array = npt.NDArray[Any]
Color = tuple[float, float, float]


@dataclass(frozen=True)
class Look:
    """A material; names as in `SceneDescription.add_material`."""

    kind: str = "diffuse"
    base_color: Color = (0.5, 0.5, 0.5)
    specular: Color = (1.0, 1.0, 1.0)
    roughness: float = 0.3
    eta: float = 1.5
    two_sided: bool = True
    thin: bool = False
    coat: CoatKind = CoatKind.NONE
    nonlinear: bool = False
    texture: Array | None = None


@dataclass(frozen=True)
class Part:
    """A mesh with its material and emission."""

    vertices: Array
    triangles: Array
    look: Look = Look()
    emission: Color = (0.0, 0.0, 0.0)
    uvs: Array | None = None
    normals: Array | None = None

    def reversed(self) -> Part:
        """The other side is the front."""
        return replace(self, triangles=self.triangles[:, ::-1].copy())


@dataclass(frozen=True)
class Model:
    """A scene."""

    parts: tuple[Part, ...]
    points: tuple[tuple[Color, Color], ...] = ()  #: position, intensity
    #: Position, intensity, axis, inner and outer angle; linear in the angle between them.
    spots: tuple[tuple[Color, Color, Color, tuple[float, float]], ...] = ()
    directions: tuple[tuple[Color, Color], ...] = ()  #: towards the light, irradiance
    spheres: tuple[tuple[Color, float, Color], ...] = ()  #: center, radius, radiance
    env: Color | Array | None = None
    origin: Color = (0.0, 1.0, 4.0)
    target: Color = (0.0, 0.7, 0.0)
    fov_deg: float = 40.0
    up: Color = field(default=(0.0, 1.0, 0.0))

    def to_viscache(self) -> vc.Scene:
        d = vc.SceneDescription()
        for part in self.parts:
            look = part.look
            texture = -1 if look.texture is None else d.add_image(look.texture)
            material = d.add_material(
                MaterialKind[look.kind.upper()],
                base_color=look.base_color,
                specular=look.specular,
                roughness=look.roughness,
                eta=look.eta,
                two_sided=look.two_sided,
                thin=look.thin,
                coat=look.coat,
                nonlinear=look.nonlinear,
                base_texture=texture,
            )
            d.add_mesh(
                part.vertices,
                part.triangles,
                material=material,
                emission=part.emission,
                uvs=part.uvs,
                normals=part.normals,
            )
        for position, intensity in self.points:
            d.add_point_light(position, intensity)
        for position, intensity, axis, cone_deg in self.spots:
            d.add_point_light(position, intensity, axis=axis, cone_deg=cone_deg, falloff="angle")
        for direction, irradiance in self.directions:
            d.add_directional_light(direction, irradiance)
        for center, radius, radiance in self.spheres:
            d.add_sphere_light(center, radius, radiance)
        if isinstance(self.env, np.ndarray):
            d.set_environment((1, 1, 1), image=d.add_image(self.env))
        elif self.env is not None:
            d.set_environment(self.env)
        d.add_camera(self.origin, self.target, up=self.up, fov_deg=self.fov_deg)
        return vc.Scene.from_description(d)

    def to_mitsuba(self, mi: Any, size: tuple[int, int], folder: Path) -> Any:
        scene: dict[str, Any] = {"type": "scene", "sensor": self._sensor(mi, size)}
        for i, part in enumerate(self.parts):
            shape = {
                "type": "ply",
                "filename": write_ply(folder / f"{i}.ply", part),
                "face_normals": part.normals is None,
                "bsdf": _bsdf(mi, part.look),
            }
            if max(part.emission) > 0:
                shape["emitter"] = {"type": "area", "radiance": _rgb(part.emission)}
            scene[f"part{i}"] = shape
        for i, (position, intensity) in enumerate(self.points):
            scene[f"point{i}"] = {
                "type": "point",
                "position": position,
                "intensity": _rgb(intensity),
            }
        for i, (position, intensity, axis, cone_deg) in enumerate(self.spots):
            up = (0, 0, 1) if abs(axis[2]) < 0.9 else (1, 0, 0)
            at = np.add(position, axis).tolist()
            scene[f"spot{i}"] = {
                "type": "spot",
                "to_world": mi.ScalarTransform4f().look_at(origin=position, target=at, up=up),
                "intensity": _rgb(intensity),
                "beam_width": cone_deg[0],
                "cutoff_angle": cone_deg[1],
            }
        for i, (direction, irradiance) in enumerate(self.directions):
            scene[f"direction{i}"] = {
                "type": "directional",
                "direction": [-v for v in direction],
                "irradiance": _rgb(irradiance),
            }
        for i, (center, radius, radiance) in enumerate(self.spheres):
            scene[f"sphere{i}"] = {
                "type": "sphere",
                "center": center,
                "radius": radius,
                "bsdf": {"type": "diffuse", "reflectance": 0.0},
                "emitter": {"type": "area", "radiance": _rgb(radiance)},
            }
        if isinstance(self.env, np.ndarray):
            scene["env"] = {"type": "envmap", "bitmap": mi.Bitmap(self.env)}
        elif self.env is not None:
            scene["env"] = {"type": "constant", "radiance": _rgb(self.env)}
        # Merging what is alike would order the lamps anew each time, and so change the noise
        return mi.load_dict(scene, optimize=False)

    def _sensor(self, mi: Any, size: tuple[int, int]) -> dict[str, Any]:
        at = mi.ScalarTransform4f().look_at(origin=self.origin, target=self.target, up=self.up)
        return sensor(at, size, fov=self.fov_deg, fov_axis="y")


def sensor(to_world: Any, size: tuple[int, int], *, fov: float, fov_axis: str) -> dict[str, Any]:
    """A pinhole camera with a box filter."""
    return {
        "type": "perspective",
        "to_world": to_world,
        "fov": fov,
        "fov_axis": fov_axis,
        "near_clip": 1e-3,
        "film": {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
        "sampler": {"type": "independent"},
    }


def _rgb(value: Color) -> dict[str, Any]:
    return {"type": "rgb", "value": list(value)}


def _bsdf(mi: Any, look: Look) -> dict[str, Any]:
    match look.kind:
        case "diffuse":
            reflectance: Any = _rgb(look.base_color)
            if look.texture is not None:
                reflectance = {
                    "type": "bitmap",
                    "bitmap": mi.Bitmap(look.texture * np.float32(look.base_color)),
                    "raw": True,
                }
            inner: dict[str, Any] = {"type": "diffuse", "reflectance": reflectance}
        case "glossy":
            assert max(look.base_color) == 0 and min(look.specular) == 1
            assert look.coat == CoatKind.NONE
            inner = {
                "type": "roughconductor",
                "material": "none",
                "distribution": "ggx",
                "alpha": look.roughness,
            }
        case "mirror":
            inner = {
                "type": "conductor",
                "material": "none",
                "specular_reflectance": _rgb(look.specular),
            }
        case "dielectric":
            kind = "thindielectric" if look.thin else "dielectric"
            return {"type": kind, "int_ior": look.eta, "ext_ior": 1.0}
        case _:
            raise ValueError(look.kind)
    return {"type": "twosided", "bsdf": inner} if look.two_sided else inner


def write_ply(path: Path, part: Part) -> str:
    """ASCII PLY with all digits; v is turned over, as Mitsuba counts rows from v = 0."""
    columns = [part.vertices]
    names = ["x", "y", "z"]
    if part.normals is not None:
        columns.append(part.normals)
        names += ["nx", "ny", "nz"]
    if part.uvs is not None:
        columns.append(part.uvs * [1, -1] + [0, 1])
        names += ["u", "v"]
    rows = np.concatenate(columns, axis=1)
    lines = ["ply", "format ascii 1.0", f"element vertex {len(rows)}"]
    lines += [f"property float {n}" for n in names]
    lines += [
        f"element face {len(part.triangles)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    lines += [" ".join(f"{v:.9g}" for v in row) for row in rows]
    lines += ["3 " + " ".join(str(i) for i in t) for t in part.triangles]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return str(path)


# Shapes; their fronts look outwards


def quad(corner: Color, a: Color, b: Color, **kwargs: Any) -> Part:
    """Parallelogram; its front looks along a × b."""
    o, u, v = (np.asarray(x, np.float32) for x in (corner, a, b))
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    return Part(
        np.stack([o, o + u, o + u + v, o + v]), np.array([[0, 1, 2], [0, 2, 3]]), uvs=uvs, **kwargs
    )


def box(low: Color, high: Color, **kwargs: Any) -> Part:
    """Axis-parallel box."""
    lo, hi = np.asarray(low, np.float32), np.asarray(high, np.float32)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    return Part(lo + corners * (hi - lo), np.array(triangles), **kwargs)


def ball(
    center: Color, radius: float, rings: int = 12, *, smooth: bool = False, **kwargs: Any
) -> Part:
    """Sphere of latitudes and longitudes."""
    theta, phi = np.meshgrid(
        np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1), indexing="ij"
    )
    n = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1)
    n = n.reshape(-1, 3).astype(np.float32)
    columns = 2 * rings + 1
    triangles = []
    for i in range(rings):
        for j in range(2 * rings):
            a, b = i * columns + j, (i + 1) * columns + j
            if i > 0:
                triangles.append((a, a + 1, b))
            if i < rings - 1:
                triangles.append((a + 1, b + 1, b))
    vertices = (np.asarray(center) + radius * n).astype(np.float32)
    return Part(vertices, np.array(triangles), normals=n if smooth else None, **kwargs)
