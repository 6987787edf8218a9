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
            look = dict(vars(part.look))
            kind, texture = MaterialKind[look.pop("kind").upper()], look.pop("texture")
            if texture is not None:
                look["base_texture"] = d.add_image(texture)
            given = {name: getattr(part, name) for name in ("emission", "uvs", "normals")}
            material = d.add_material(kind, **look)
            d.add_mesh(part.vertices, part.triangles, material=material, **given)
        for point in self.points:
            d.add_point_light(*point)
        for position, intensity, axis, cone_deg in self.spots:
            d.add_point_light(position, intensity, axis=axis, cone_deg=cone_deg, falloff="angle")
        for direction in self.directions:
            d.add_directional_light(*direction)
        for sphere in self.spheres:
            d.add_sphere_light(*sphere)
        if isinstance(self.env, np.ndarray):
            d.set_environment((1, 1, 1), image=d.add_image(self.env))
        elif self.env is not None:
            d.set_environment(self.env)
        d.add_camera(self.origin, self.target, up=self.up, fov_deg=self.fov_deg)
        return vc.Scene.from_description(d)

    def to_mitsuba(self, mi, size: tuple[int, int], folder: Path):
        look_at = mi.ScalarTransform4f().look_at
        view = look_at(origin=self.origin, target=self.target, up=self.up)
        made = [sensor(view, size, fov=self.fov_deg, fov_axis="y")]
        for i, part in enumerate(self.parts):
            file = write_ply(folder / f"{i}.ply", part)
            made.append({"type": "ply", "filename": file, "bsdf": _bsdf(mi, part.look)})
            made[-1]["face_normals"] = part.normals is None
            if max(part.emission) > 0:
                made[-1]["emitter"] = {"type": "area", "radiance": _rgb(part.emission)}
        for position, intensity in self.points:
            made.append({"type": "point", "position": position, "intensity": _rgb(intensity)})
        for position, intensity, axis, (inner, outer) in self.spots:
            up = (0, 0, 1) if abs(axis[2]) < 0.9 else (1, 0, 0)
            at = look_at(origin=position, target=np.add(position, axis).tolist(), up=up)
            cone = {"beam_width": inner, "cutoff_angle": outer}
            made.append({"type": "spot", "to_world": at, "intensity": _rgb(intensity), **cone})
        for direction, irradiance in self.directions:
            made.append({"type": "directional", "irradiance": _rgb(irradiance)})
            made[-1]["direction"] = [-v for v in direction]
        for center, radius, radiance in self.spheres:
            made.append({"type": "sphere", "center": center, "radius": radius})
            made[-1]["bsdf"] = {"type": "diffuse", "reflectance": 0.0}
            made[-1]["emitter"] = {"type": "area", "radiance": _rgb(radiance)}
        if isinstance(self.env, np.ndarray):
            made.append({"type": "envmap", "bitmap": mi.Bitmap(self.env)})
        elif self.env is not None:
            made.append({"type": "constant", "radiance": _rgb(self.env)})
        # Merging what is alike would order the lamps anew each time, and so change the noise
        scene = {f"part{i:03}": part for i, part in enumerate(made)}
        return mi.load_dict({"type": "scene", **scene}, optimize=False)


def sensor(to_world, size: tuple[int, int], *, fov: float, fov_axis: str):
    """A pinhole camera with a box filter."""
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}}
    film |= {"pixel_format": "rgb", "component_format": "float32"}
    camera = {"type": "perspective", "fov": fov, "fov_axis": fov_axis, "near_clip": 1e-3}
    return camera | {"to_world": to_world, "film": film, "sampler": {"type": "independent"}}


def _rgb(value: Color):
    return {"type": "rgb", "value": list(value)}


def _bsdf(mi, look: Look):
    match look.kind:
        case "diffuse":
            reflectance = _rgb(look.base_color)
            if look.texture is not None:
                image = mi.Bitmap(look.texture * np.float32(look.base_color))
                reflectance = {"type": "bitmap", "bitmap": image, "raw": True}
            inner = {"type": "diffuse", "reflectance": reflectance}
        case "glossy":
            assert max(look.base_color) == 0 and min(look.specular) == 1
            assert look.coat == CoatKind.NONE
            inner = {"type": "roughconductor", "distribution": "ggx", "alpha": look.roughness}
            inner["material"] = "none"
        case "mirror":
            inner = {"type": "conductor", "specular_reflectance": _rgb(look.specular)}
            inner["material"] = "none"
        case "dielectric":
            kind = "thindielectric" if look.thin else "dielectric"
            return {"type": kind, "int_ior": look.eta, "ext_ior": 1.0}
        case _:
            raise ValueError(look.kind)
    return {"type": "twosided", "bsdf": inner} if look.two_sided else inner


def write_ply(path: Path, part: Part) -> str:
    """ASCII PLY with all digits; v is turned over, as Mitsuba counts rows from v = 0."""
    columns, names = [part.vertices], ["x", "y", "z"]
    if part.normals is not None:
        columns.append(part.normals)
        names += ["nx", "ny", "nz"]
    if part.uvs is not None:
        columns.append(part.uvs * [1, -1] + [0, 1])
        names += ["u", "v"]
    rows = np.concatenate(columns, axis=1)
    lines = ["ply", "format ascii 1.0", f"element vertex {len(rows)}"]
    lines += [f"property float {n}" for n in names]
    lines += [f"element face {len(part.triangles)}", "property list uchar int vertex_indices"]
    lines += ["end_header", *(" ".join(f"{v:.9g}" for v in row) for row in rows)]
    lines += ["3 " + " ".join(str(i) for i in t) for t in part.triangles]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return str(path)


# Shapes; their fronts look outwards


def quad(corner: Color, a: Color, b: Color, **kwargs) -> Part:
    """Parallelogram; its front looks along a × b."""
    o, u, v = (np.asarray(x, np.float32) for x in (corner, a, b))
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    return Part(
        np.stack([o, o + u, o + u + v, o + v]), np.array([[0, 1, 2], [0, 2, 3]]), uvs=uvs, **kwargs
    )


def box(low: Color, high: Color, **kwargs) -> Part:
    """Axis-parallel box."""
    lo, hi = np.asarray(low, np.float32), np.asarray(high, np.float32)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    return Part(lo + corners * (hi - lo), np.array(triangles), **kwargs)


def ball(center: Color, radius: float, rings: int = 12, *, smooth: bool = False, **kwargs) -> Part:
    """Sphere of latitudes and longitudes."""
    columns = 2 * rings + 1
    theta, phi = np.meshgrid(
        np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, columns), indexing="ij"
    )
    n = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1)
    n = n.reshape(-1, 3).astype(np.float32)
    triangles = []
    for i in range(rings):
        for a in range(i * columns, (i + 1) * columns - 1):
            b = a + columns
            triangles += [(a, a + 1, b)] if i > 0 else []
            triangles += [(a + 1, b + 1, b)] if i < rings - 1 else []
    vertices = (np.asarray(center) + radius * n).astype(np.float32)
    return Part(vertices, np.array(triangles), normals=n if smooth else None, **kwargs)


def busy_scene() -> vc.Scene:
    """Long in work, for processes that are stopped while they render it."""
    parts = (
        box((-3, 0, -3), (3, 3, 3)).reversed(),
        *(ball((x, y, z), 0.3, 24) for x in (-1, 0, 1) for y in (0.5, 1.5) for z in (-1, 0)),
        quad((-1, 2.9, -1), (2, 0, 0), (0, 0, 2), emission=(5, 5, 5)),
    )
    return Model(parts, env=(0.5, 0.5, 0.5), origin=(0, 1.5, 2.8)).to_viscache()
