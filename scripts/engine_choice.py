"""Scenes and rays that the choices of engines are fitted to, and others that test them."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

import viscache as vc

#: Scenes whose measurements set the prices of `vlf/engine_choice.cpp`: built-in specs, or files
#: in the folder of scenes by others.
FITTED = (
    "classroom/scene.xml",
    "veach-ajar/scene.pbrt",
    "scans/stanford_bunny.ply",
    "gltf-pine/scene.gltf",
    "cornell-box/scene.xml",
    "room?triangles=200000",
    "random_triangles?triangles=100000",
    "church",
    "apartment?triangles=300000",
    "bumpy_spheres?triangles=600000",
    "mushrooms?triangles=100000",
    "courtyard?triangles=400000",
)
#: Scenes that were not used for fitting.
HELD_OUT = (
    "living-room/scene.xml",
    "sponza-dabrovic/scene.xml",
    "sanmiguel-part/scene.xml",
    "gltf-balloon/scene.gltf",
    "scans/happy_buddha_30k.ply",
    "bumpy_spheres?triangles=15000",
    "conference?triangles=100000",
    "garden?triangles=300000",
    "garage?triangles=150000",
    "classroom_like",
    "hairball?triangles=300000",
    "cube_on_plane",
)
#: Length of the rays over the diagonal of the scene's bounds.
DISTANCES = (0.01, 0.05, 0.2, math.inf)


def eye_points(
    scene: vc.Scene, size: tuple[int, int]
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Positions and normals of a picture's eye points."""
    eyes = vc.connections(scene, vc.Direct(), size=size).eyes
    return np.ascontiguousarray(eyes.positions), np.ascontiguousarray(eyes.normals)


def rays_of(scene: vc.Scene, distance: float) -> float:
    """The length of rays in scene units."""
    low, high = np.asarray(scene.bounds)
    return float(distance * np.linalg.norm(high - low))
