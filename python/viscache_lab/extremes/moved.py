"""Scenes written anew: rotated, scaled, moved, shaken. The picture stays the same."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc

Array = npt.NDArray[np.float64]


def description_of(
    made: vc.Scene,
    *,
    scale: float = 1.0,
    rotation: npt.ArrayLike | None = None,
    shift: npt.ArrayLike = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> vc.SceneDescription:
    """A scene shaken by `noise`, rotated, scaled, then moved; `origin` is the new scene's.

    It has materials without textures, meshes in world space, point and directional lights, cameras.
    Point lights have `scale²` times their intensity. Noise is uniform, from a fixed seed.
    """
    turn: Array = np.eye(3) if rotation is None else np.asarray(rotation, float)
    rng = np.random.default_rng(5)

    def point(p: npt.ArrayLike) -> Array:
        return np.asarray(scale * (np.asarray(p, float) @ turn.T) + np.asarray(shift, float))

    def place(p: npt.ArrayLike) -> list[float]:
        return [float(x) for x in point(p)]

    old, new = made.description(), vc.SceneDescription(origin)
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
            intensity = (np.asarray(light["intensity"]) * scale**2).tolist()
            new.add_point_light(place(light["position"]), intensity)
        elif light["kind"] == "directional":
            new.add_directional_light(turn @ light["direction"], light["irradiance"])
    for camera in old.cameras:
        target = np.add(camera["origin"], camera["forward"])
        new.add_camera(
            place(camera["origin"]),
            place(target),
            up=turn @ camera["up"],
            fov_deg=camera["fov_deg"],
        )
    return new


def moved(made: vc.Scene, **transform: Any) -> vc.Scene:
    """The scene of `description_of`."""
    return vc.Scene.from_description(description_of(made, **transform))
