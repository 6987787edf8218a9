"""Frames with the quantized cache and with a ray per query, for the tests beside this file."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache import _core
from viscache.settings.by_name import replaced

Image = npt.NDArray[np.float32]

SIZE = (80, 50)
#: Every way of answering the groups of shared lights.
FORMS: dict[str, dict[str, Any]] = {
    "waves": {"form": "waves"},
    "pairs-table": {"form": "pairs", "storage": "table", "table_bytes": 64 << 20},
    "pairs-exact": {"form": "pairs", "storage": "exact"},
}
#: Light that is the same for all pixels, and light that every eye point samples for itself.
SHARED = vc.Whitted(n_vpls=24, n_area=0, n_environment=0, n_brdf=0)
LOCAL = vc.Direct(n_area=8, n_environment=4, n_brdf=4)


def rel_l1(image: Image, reference: Image) -> float:
    """Σ|a − b| / Σb."""
    a, b = np.asarray(image, np.float64), np.asarray(reference, np.float64)
    return float(np.abs(a - b).sum() / b.sum())


def energy(image: Image, reference: Image) -> float:
    """Σ(a − b) / Σb."""
    a, b = np.asarray(image, np.float64), np.asarray(reference, np.float64)
    return float((a - b).sum() / b.sum())


def render(
    scene: vc.Scene, integrator: Any = None, *, size: tuple[int, int] = SIZE, **aqvc: Any
) -> vc.Frame:
    """A frame with these parameters of `Aqvc` and of its `paper`; every light group is cached.

    `spp`, `seed`, `threads`, `camera` go to `vc.render`.
    """
    passed = {n: aqvc.pop(n) for n in ("spp", "seed", "threads", "camera") if n in aqvc}
    visibility = replaced(vc.Aqvc(exact_groups=()), aqvc, "visibility")
    return vc.render(scene, integrator or SHARED, visibility=visibility, size=size, **passed)


@cache
def exact(
    scene: vc.Scene, integrator: Any = SHARED, size: tuple[int, int] = SIZE, **passed: Any
) -> vc.Frame:
    """The same frame with a ray per query; made once."""
    return vc.render(scene, integrator, visibility=vc.Exact(), size=size, **passed)


@cache
def scene(name: str, **parameters: Any) -> vc.Scene:
    """A built-in scene; made once."""
    return getattr(vc.scenes, name)(**parameters)


@cache
def lit_box() -> vc.Scene:
    """The Cornell box with its area light, a point light and a sun through the open side."""
    description = description_of(scene("cornell_box"))
    description.add_point_light((-0.15, 0.5, -0.1), (0.4, 0.4, 0.4))
    description.add_directional_light((0.3, 0.3, 1.0), (1.5, 1.4, 1.2))
    return vc.Scene.from_description(description)


def description_of(
    made: vc.Scene,
    *,
    scale: float = 1.0,
    rotation: npt.ArrayLike | None = None,
    shift: npt.ArrayLike = (0.0, 0.0, 0.0),
    noise: float = 0.0,
) -> vc.SceneDescription:
    """The scene written anew: rotated, then scaled, then moved; the picture stays the same.

    `noise` (scene units, uniform, fixed seed) shakes the vertices.
    """
    turn = np.eye(3) if rotation is None else np.asarray(rotation, float)
    rng = np.random.default_rng(5)

    def point(p: npt.ArrayLike) -> npt.NDArray[np.float64]:
        return scale * (np.asarray(p, float) @ turn.T) + np.asarray(shift, float)

    old, new = _core.description_of(made._core), vc.SceneDescription()
    for material in old.materials:
        new.add_material(material.pop("kind"), **material)
    for mesh in made.meshes():
        shaken = mesh["vertices"] + noise * rng.uniform(-1, 1, mesh["vertices"].shape)
        new.add_mesh(
            point(shaken),
            mesh["triangles"],
            material=mesh["material"],
            emission=mesh["emission"],
            name=mesh["name"],
        )
    for light in old.lights:
        if light["kind"] == "point":
            intensity = np.asarray(light["intensity"]) * scale**2
            new.add_point_light(point(light["position"]), intensity)
        elif light["kind"] == "directional":
            new.add_directional_light(turn @ light["direction"], light["irradiance"])
    for camera in old.cameras:
        target = np.add(camera["origin"], camera["forward"])
        new.add_camera(
            point(camera["origin"]),
            point(target),
            up=turn @ camera["up"],
            fov_deg=camera["fov_deg"],
        )
    return new


def moved(made: vc.Scene, **transform: Any) -> vc.Scene:
    """The scene of `description_of`."""
    return vc.Scene.from_description(description_of(made, **transform))
