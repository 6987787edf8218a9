"""The garden: high grass with tulips, where visibility is almost random."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from viscache.scenes.builder import Builder
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import Array, Indices, leaf, place, surface, tube
from viscache.scenes.sky import sky

SEED = 1909
FULL = 2_000_000
LEAST = 5_000
HALF = 18.0  # of the garden's width; all sizes are in the units of the visibility-map paper
GRASS, TULIP = 3.8, 0.8  # mean height of the grass, diameter of a tulip
SEGMENTS, BLADE_WIDTH = 15, 0.16
CAMERAS = (((3.0, 6.6, 17.5), (-1.0, 2.4, 0.0)), ((-5.5, 2.3, 7.0), (1.5, 2.9, -5.0)))
SHARE = 0.45  # fraction of the triangles for ground and tulips
FREE = 0.9  # nothing grows within this distance of a camera
GLADE, GLADE_SLOPE = 5.0, 0.35  # length of the free cone in front of a camera, and its slope


@scene()
def garden(triangles: Annotated[int, Range(LEAST, MOST_TRIANGLES)] = FULL) -> Builder:
    """Grass blades 3.8 units high with tulips of 0.8, seen from above and from inside, under a sky.

    A stand-in for the garden of the visibility-map paper, with its two cameras and sizes.

    Parameters
    ----------
    triangles : int
        Placed triangles; the scene has this many to 1.25 times as many. At least 5000.
    """
    b, rng = Builder("garden"), np.random.Generator(np.random.PCG64(SEED))
    ground = surface(_ground, 50, 50, least=(10, 10))
    b.add(ground, b.diffuse("soil", (0.11, 0.08, 0.06)))
    _tulips(b, rng, int(np.clip(triangles / 4000, 6, 400)))
    b.fit(int(SHARE * triangles))
    _grass(b, rng, triangles)
    b.description.set_environment(image=b.description.add_image(sky((-0.45, 0.7, 0.4))))
    for k, (origin, target) in enumerate(CAMERAS):
        b.camera(origin, target, 48.0, name=f"garden{k + 1}", size=(640, 480))
    return b


def height(x: Array, z: Array) -> Array:
    """Height of the ground."""
    out: Array = 0.35 * np.sin(0.31 * x + 1.0) * np.cos(0.27 * z) + 0.08 * np.sin(1.7 * x + 1.3 * z)
    return out


def _ground(u: Array, v: Array) -> Array:
    x, z = (2 * u - 1) * HALF, (1 - 2 * v) * HALF
    return np.stack([x, height(x, z), z], axis=-1)


def _out_of_the_way(points: Array, near: float) -> Array:
    """True for points (..., 3) that are neither at a camera nor directly in front of it."""
    free = np.ones(points.shape[:-1], bool)
    for origin, target in CAMERAS:
        offset = points - np.array(origin)
        forward = np.subtract(target, origin)
        along = offset @ (forward / np.linalg.norm(forward))
        squared = (offset**2).sum(-1)
        aside = np.sqrt(np.maximum(squared - along**2, 0))
        before = (along > 0) & (along < GLADE) & (aside < GLADE_SLOPE * along)
        free &= (squared > near**2) & ~before
    return free


def _tulips(b: Builder, rng: np.random.Generator, n: int) -> None:
    at = rng.uniform(-0.95 * HALF, 0.95 * HALF, (4 * n, 2))
    stem = rng.uniform(3.6, 5.0, 4 * n)
    top = np.stack([at[:, 0], height(*at.T) + stem, at[:, 1]], -1)
    at, stem = (x[_out_of_the_way(top, 1.6)][:n] for x in (at, stem))
    foot = np.stack([at[:, 0], height(*at.T), at[:, 1]], -1)
    yaw = rng.uniform(0, 360, n)
    stretched = np.stack([0 * stem + 1, stem, 0 * stem + 1], -1)
    green = b.glossy("tulip leaves", (0.2, 0.4, 0.16), 0.04, 0.3)
    # The stem bends a little and ends upright at (0, 1, 0), scaled to its height
    path = np.array([[0, -0.02, 0], [0.05, 0.4, 0.03], [0.02, 0.8, 0.02], [0, 1, 0]])
    b.add(tube(path, [0.075, 0.06, 0.05], 7, 10), green, place(foot, yaw, stretched))
    for turn in (20.0, 190.0):
        blade = place(foot, yaw + turn) @ place([0, 0.25, 0.06], pitch=-62)
        b.add(leaf(2.6, 0.42, 0.25, 4, 9), green, blade, optional=turn > 100)
    colors = ((0.62, 0.06, 0.05), (0.75, 0.55, 0.06), (0.68, 0.26, 0.36), (0.4, 0.07, 0.25))
    blossom = place(foot + [0, 1, 0] * stem[:, None], yaw, pitch=rng.uniform(-9, 9, n))
    for k, color in enumerate(colors):
        petals = np.arange(6)
        inner = np.stack([place(yaw=60.0 * p, scale=1 - 0.05 * (p % 2)) for p in petals])
        some = blossom[k :: len(colors)]
        material = b.glossy(f"tulips {k}", color, 0.04, 0.25)
        b.add(PETAL, material, some[:, None] @ inner)


def _petal(u: Array, v: Array) -> Array:
    """One of six, around y: widest (half of TULIP) at two fifths of its height of 1."""
    radius = TULIP / 2 * (0.15 + 0.85 * np.sin(np.pi * (0.08 + 0.78 * v)) ** 0.8)
    angle = (2 * u - 1) * 0.68 * np.sqrt(np.clip(1 - v**4, 0.02, 1))
    cup = radius * (1 - 0.06 * (2 * u - 1) ** 2)
    y = 1.0 * v - 0.05 * (2 * u - 1) ** 2 * v
    return np.stack([cup * np.sin(angle), y, cup * np.cos(angle)], axis=-1)


PETAL = surface(_petal, 5, 7, least=(2, 3))


def _grass(b: Builder, rng: np.random.Generator, triangles: int) -> None:
    segments = int(np.clip(round(SEGMENTS * (triangles / FULL) ** 0.25), 3, SEGMENTS))
    each = 4 * segments - 2
    n = -(-(triangles - b.placed) // each)
    full = (1 - SHARE) * FULL / (4 * SEGMENTS - 2)
    # Fewer blades are wider, so that the grass stays about as dense
    width = BLADE_WIDTH * min(6.0, max(1.0, (full / n) ** 0.7))
    vertices = _blades(rng, n, segments, width)
    faces = _strips(segments)
    paints = (("grass", (0.13, 0.33, 0.07)), ("light grass", (0.27, 0.45, 0.12)))
    for k, (name, color) in enumerate(paints):
        part = vertices[k::2]
        starts = np.arange(len(part), dtype=np.uint32)[:, None, None] * np.uint32(part.shape[1])
        material = b.glossy(name, color, 0.04, 0.3)
        b.add_mesh(part.reshape(-1, 3), (faces[None] + starts).reshape(-1, 3), material, name=name)


def _blades(rng: np.random.Generator, n: int, segments: int, width: float) -> Array:
    """Vertices (n, 3·segments + 1, 3) of folded, twisted, bent blades in tufts."""
    spare = n + n // 8 + 64
    tuft = rng.uniform(-HALF, HALF, (spare // 12 + 1, 2))
    root = tuft[np.arange(spare) % len(tuft)] + rng.normal(0, 0.33, (spare, 2))
    root = np.clip(root, -0.95 * HALF, 0.95 * HALF)
    tall = GRASS * np.clip(rng.normal(1, 0.13, spare), 0.6, 1.4)
    turn, reach = rng.uniform(0, 2 * np.pi, spare), tall * rng.uniform(0.08, 0.42, spare)
    t = np.append(np.arange(segments) / segments, 1.0)
    bend = reach[:, None] * t**2
    x = root[:, :1] + bend * np.sin(turn)[:, None]
    z = root[:, 1:] + bend * np.cos(turn)[:, None]
    foot = height(root[:, 0], root[:, 1])[:, None]
    y = foot + tall[:, None] * (1.25 * t - 0.25 * t**2)
    spine = np.stack([x, y, z], -1)
    chosen = np.flatnonzero(_out_of_the_way(spine, FREE).all(axis=1))[:n]
    spine, turn = spine[chosen], turn[chosen]
    # Across the blade, twisting by up to 70° on the way; the middle is folded down
    twist = turn[:, None] + np.pi / 2 + rng.uniform(-1.2, 1.2, (n, 1)) * t
    across = np.stack([np.sin(twist), 0 * twist, np.cos(twist)], -1)
    down = np.stack([-np.cos(twist), -0.4 + 0 * twist, np.sin(twist)], -1)
    half = 0.5 * width * (1 - t**2) * (0.75 + 0.5 * t)
    left, right = spine - across * half[:, None], spine + across * half[:, None]
    middle = spine + down * (0.35 * half)[:, None]
    rows = np.stack([left, middle, right], axis=2)[:, :segments].reshape(n, -1, 3)
    return np.concatenate([rows, spine[:, -1:]], axis=1)


def _strips(segments: int) -> Indices:
    """Triangles (4·segments − 2, 3) of one blade."""
    row = 3 * np.arange(segments - 1)[:, None]
    a, b = (row + np.arange(2)).ravel(), (row + np.arange(1, 3)).ravel()
    quads = np.stack([a, b, a + 3, b, b + 3, a + 3], axis=-1).reshape(-1, 3)
    last, tip = 3 * (segments - 1), 3 * segments
    fan = [[last, last + 1, tip], [last + 1, last + 2, tip]]
    return np.concatenate([quads, fan]).astype(np.uint32)
