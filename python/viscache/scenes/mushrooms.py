"""Mushrooms on a forest floor, with plants around them that the camera does not see."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from viscache.scenes.builder import Builder
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import Array, bumpy_sphere, leaf, place, revolve, surface, tube
from viscache.scenes.sky import sky

SEED = 1303
FULL = 300_000
LEAST = 5_000
HALF = 14.0  # of the floor's width; all sizes are in the units of the visibility-map paper
SIZE = 1.3  # mean height and diameter of a mushroom
CAMERA, TARGET = (0.5, 2.6, 6.2), (-0.3, 0.5, 0.0)
MUSHROOMS, PLANTS, STONES = 44, 21, 60


@scene()
def mushrooms(triangles: Annotated[int, Range(LEAST, MOST_TRIANGLES)] = FULL) -> Builder:
    """Mushrooms 1.3 units high and wide on uneven ground, with ferns around, under a sky.

    A stand-in for the scene of the same name in the visibility-map paper, with its sizes.

    Parameters
    ----------
    triangles : int
        Placed triangles; the scene has this many to 1.25 times as many. At least 5000.
    """
    b, rng = Builder("mushrooms"), np.random.Generator(np.random.PCG64(SEED))
    floor = surface(_floor, 100, 100, least=(12, 12))
    b.add(floor, b.diffuse("forest floor", (0.2, 0.16, 0.09)))
    _mushrooms(b, rng)
    _stones(b, rng)
    _ferns(b, rng)
    b.fit(triangles)
    b.description.set_environment(image=b.description.add_image(sky((0.55, 0.6, 0.35))))
    b.camera(CAMERA, TARGET, 42.0, size=(640, 480))
    return b


def height(x: Array, z: Array) -> Array:
    """Height of the ground."""
    hills: Array = 0.22 * np.sin(0.5 * x + 0.4) * np.cos(0.43 * z + 0.8)
    return hills + 0.05 * np.sin(2.3 * x + 1.1 * z) + 0.03 * np.sin(4.1 * z - 2.7 * x)


def _floor(u: Array, v: Array) -> Array:
    x, z = (2 * u - 1) * HALF, (1 - 2 * v) * HALF
    return np.stack([x, height(x, z), z], axis=-1)


def _on_ground(at: Array, sink: float) -> Array:
    x, z = at[..., 0], at[..., 1]
    return np.stack([x, height(x, z) - sink, z], axis=-1)


def spots(rng: np.random.Generator, n: int, apart: float, half: float) -> Array:
    """Positions (n, 2) in a square, at least `apart` from each other."""
    kept = np.zeros((0, 2))
    while len(kept) < n:
        p = rng.uniform(-half, half, 2)
        if not len(kept) or np.hypot(*(kept - p).T).min() > apart:
            kept = np.append(kept, [p], axis=0)
    return kept


def _mushrooms(b: Builder, rng: np.random.Generator) -> None:
    """Stem with a ring, and cap: 1 high and 1 wide before scaling to SIZE."""
    at = spots(rng, MUSHROOMS, 1.35, 5.6)
    size = SIZE * np.clip(rng.normal(1, 0.14, len(at)), 0.7, 1.3)
    lean = rng.uniform(-7, 7, (2, len(at)))
    frames = place(_on_ground(at, 0.03), rng.uniform(0, 360, len(at)), size, *lean)
    foot = [[0.17, 0.0], [0.15, 0.08], [0.105, 0.3], [0.1, 0.5], [0.16, 0.53], [0.1, 0.56]]
    stem = revolve([*foot, [0.095, 0.68]], 26, 26, caps=(False, False), flutes=(9, 0.02))
    # From the stem out under the gills, around the rim, up to the crown
    cap = [[0.09, 0.66], [0.3, 0.62], [0.46, 0.57], [0.5, 0.6], [0.485, 0.68]]
    cap += [[0.4, 0.83], [0.25, 0.95], [0.1, 0.995], [0.012, 1.0]]
    hood = revolve(cap, 40, 40, caps=(False, True), flutes=(7, 0.012), dome=0.02)
    b.add(stem, b.diffuse("stems", (0.78, 0.72, 0.6)), frames)
    paints = (("red caps", (0.55, 0.08, 0.05)), ("brown caps", (0.36, 0.2, 0.1)))
    for k, (name, color) in enumerate(paints):
        b.add(hood, b.glossy(name, color, 0.05, 0.2), frames[k::2])


def _stones(b: Builder, rng: np.random.Generator) -> None:
    at = spots(rng, STONES, 0.7, 0.93 * HALF)
    scale = np.stack(
        [
            rng.uniform(0.7, 1.6, STONES),
            rng.uniform(0.5, 0.9, STONES),
            rng.uniform(0.7, 1.6, STONES),
        ],
        -1,
    )
    frames = place(_on_ground(at, 0.02), rng.uniform(0, 360, STONES), scale)
    grey = b.diffuse("stones", (0.4, 0.39, 0.36))
    for k in range(3):
        b.add(bumpy_sphere(0.16, 7, 1.3 * k, 0.1), grey, frames[k::3], optional=True)


def _ferns(b: Builder, rng: np.random.Generator) -> None:
    """Rosettes of fronds: small ones behind, large ones beside and above, outside the image."""
    green = b.glossy("ferns", (0.15, 0.36, 0.09), 0.04, 0.3)
    turn = 2 * np.pi * (np.arange(PLANTS) + rng.uniform(-0.3, 0.3, PLANTS)) / PLANTS
    behind = np.cos(turn) < -0.7
    radius = np.where(behind, rng.uniform(8.5, 10.5, PLANTS), rng.uniform(8.0, 11.0, PLANTS))
    scale = np.where(behind, rng.uniform(0.8, 1.2, PLANTS), rng.uniform(1.3, 2.0, PLANTS))
    at = np.stack([radius * np.sin(turn), radius * np.cos(turn)], -1)
    feet = place(_on_ground(at, 0.02), rng.uniform(0, 360, PLANTS), scale)
    arch = np.array([[0, 0, 0], [0, 1.0, 0.5], [0, 1.35, 1.3], [0, 1.1, 2.0]])
    rib = tube(arch, [0.035, 0.02, 0.006], 4, 9)
    blade = leaf(0.5, 0.13, 0.3, 2, 4)
    t = np.linspace(0.15, 1, 12)
    along = np.stack([0 * t, 1.5 * np.sin(1.9 * t**0.9), 0.1 + 1.9 * t**1.3], -1)
    for k in range(9):
        frond = feet @ place(yaw=40.0 * k + rng.uniform(-12, 12, PLANTS), pitch=rng.uniform(-12, 8))
        frond = frond[_out_of_the_way(frond[:, None] @ place(along))]
        b.add(rib, green, frond, optional=True)
        for side in (-1, 1):
            leaves = place(along, side * (62 - 25 * t), 1.15 - 0.75 * t)
            b.add(blade, green, frond[:, None] @ leaves, optional=True)


def _out_of_the_way(leaves: Array) -> Array:
    """True for fronds, rows of leaves (K, L, 4, 4), neither at the camera nor in front of it."""
    offset = leaves[..., :3, 3] - CAMERA
    forward = np.subtract(TARGET, CAMERA)
    ahead = offset @ (forward / np.linalg.norm(forward))
    far = np.linalg.norm(offset, axis=-1)
    free: Array = ((far > 2.0) & ((ahead < 0.6 * far) | (far > 9))).all(axis=1)
    return free
