"""A floor below lamps and slats that cells do not resolve."""

import numpy as np

import viscache as vc
from viscache import _core

FLOOR = [[-2.0, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]]


def slats(
    lamps,
    *,
    count: int = 23,
    height: float = 0.5,
    width: float = 0.09,
    kind: _core.MaterialKind = _core.MaterialKind.DIFFUSE,
    **look,
) -> vc.Scene:
    """Lamps are places and intensities."""
    low, high = [0, -2, height], [width, 2, height]
    slat = np.array([low, [width, -2, height], high, [0, 2, height]])
    every = slat + np.linspace(-2, 2, count)[:, None, None] * [1, 0, 0]
    corners = np.concatenate([[FLOOR], every]).reshape(-1, 3).astype(np.float32)
    triangles = 4 * np.arange(count + 1)[:, None, None] + [[0, 1, 2], [0, 2, 3]]
    d = _core.SceneDescription()
    d.name = "slats"
    d.add_mesh(corners, triangles.reshape(-1, 3), material=d.add_material(kind, **look))
    for place, intensity in lamps:
        d.add_point_light(tuple(place), (intensity,) * 3)
    d.add_camera((0.1, -0.2, 0.45), (0.1, 0.1, 0), up=(0, 1, 0), fov_deg=60)
    return vc.Scene.from_description(d)
