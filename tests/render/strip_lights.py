"""A hall under many strip lights, made by numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

import viscache as vc
from viscache._core import MaterialKind

SIZE = 20.0
HEIGHT = 4.0


def strip_lights(
    strips: int = 1000, *, seed: int = 0, glossy: bool = False, blocks: int = 30
) -> vc.Scene:
    """Strips of .6 × .04 under a ceiling, of powers that differ by up to 20, over blocks."""
    random = np.random.default_rng(seed)
    d = vc.SceneDescription()
    grey = d.add_material(base_color=(0.6, 0.6, 0.6))
    floor = grey
    if glossy:
        floor = d.add_material(
            MaterialKind.GLOSSY, base_color=(0.3, 0.3, 0.3), specular=(0.5, 0.5, 0.5), roughness=0.1
        )
    add_quad(d, (0, 0, 0), (0, 0, SIZE), (SIZE, 0, 0), material=floor)
    add_quad(d, (0, HEIGHT, 0), (SIZE, 0, 0), (0, 0, SIZE), material=grey)
    for wall in range(4):
        turn = np.pi / 2 * wall
        c, s = np.cos(turn), np.sin(turn)
        corner = np.array([0.5 - 0.5 * c - 0.5 * s, 0, 0.5 + 0.5 * s - 0.5 * c]) * SIZE
        add_quad(d, corner, (SIZE * c, 0, -SIZE * s), (0, HEIGHT, 0), material=grey)
    for _ in range(blocks):
        x, z = random.uniform(1, SIZE - 1, 2)
        w, h = random.uniform(0.2, 0.6), random.uniform(0.3, 2.5)
        add_block(d, (x - w, 0, z - w), (x + w, h, z + w), material=grey)
    rows = int(np.ceil(np.sqrt(strips / 2.5)))
    columns = int(np.ceil(strips / rows))
    for i in range(strips):
        x = (i % columns + 0.5) / columns * SIZE
        z = (i // columns + 0.5) / rows * SIZE
        power = 20 ** random.random()
        colour = tuple(random.uniform(0.5, 1, 3) * power)
        y = HEIGHT - 0.05 - 0.5 * random.random()
        add_quad(
            d, (x - 0.02, y, z - 0.3), (0.04, 0, 0), (0, 0, 0.6), material=grey, emission=colour
        )
    d.add_camera((1.5, 1.7, 1.5), (SIZE * 0.6, 0.8, SIZE * 0.7), up=(0, 1, 0), fov_deg=60)
    return vc.Scene.from_description(d)


def add_quad(d: Any, corner: Any, a: Any, b: Any, **given: Any) -> None:
    """A parallelogram; its front looks along a × b."""
    o, u, v = (np.asarray(x, np.float32) for x in (corner, a, b))
    d.add_mesh(np.stack([o, o + u, o + u + v, o + v]), np.array([[0, 1, 2], [0, 2, 3]]), **given)


def add_block(d: Any, low: Any, high: Any, **given: Any) -> None:
    """A box with its sides outwards."""
    lo, hi = np.asarray(low, np.float32), np.asarray(high, np.float32)
    at = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, e in faces for t in ((a, b, c), (a, c, e))]
    d.add_mesh(lo + at * (hi - lo), np.array(triangles), **given)
