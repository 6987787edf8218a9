"""The courtyard: arcades, a fountain and trees whose leaves are instanced."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from viscache.scenes import decor, fixtures, furniture
from viscache.scenes.builder import Builder, join
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import (
    Array,
    Indices,
    Shape,
    box,
    knots,
    leaf,
    place,
    quad,
    revolve,
    soft_box,
    surface,
    tube,
)

SEED = 909
FULL = 2_200_000
LEAST = 5_000
INNER, BAY = 9.0, 3.0  # the court's half width and the distance of its columns
TREES = ((-4.6, -4.4), (4.7, -4.6), (-4.8, 4.2), (4.6, 4.7), (-0.4, -6.4), (6.6, 0.4))


@scene()
def courtyard(triangles: Annotated[int, Range(LEAST, MOST_TRIANGLES)] = FULL) -> Builder:
    """Courtyard, 24 m wide, with arcades, fountain, café tables and instanced trees in the sun.

    Parameters
    ----------
    triangles : int
        Placed triangles (those of instances count each time); the scene has this many to 1.25
        times as many. At least 5000.
    """
    b, rng = Builder("courtyard"), np.random.Generator(np.random.PCG64(SEED))
    _arcades(b)
    _fountain(b)
    _furnish(b, rng)
    tips = _trunks(b, rng)
    b.fit(int(0.13 * triangles))
    _paving(b, rng, triangles)
    _foliage(b, rng, tips, triangles)
    b.description.add_directional_light((0.42, 0.8, 0.36), (3.4, 3.2, 2.8))
    b.description.set_environment((0.55, 0.68, 0.9))
    b.camera((-2.6, 2.3, 8.4), (0.7, 1.7, -2.0), 54.0, name="arcade")
    b.camera((8.3, 1.7, 7.2), (-2.0, 1.6, -2.5), 52.0, name="corner")
    return b


def _arcades(b: Builder) -> None:
    stone, wall, w = b.paint("limestone"), b.paint("plaster"), INNER
    out = w + 3.0
    b.add(quad([-out, 0, out], [out, 0, out], [out, 0, -out], [-out, 0, -out]), "stone")
    shaft = knots(
        "0.26 0.0, 0.27 0.06, 0.21 0.1, 0.24 0.16, 0.18 0.22, 0.185 1.0, 0.165 2.2, "
        "0.2 2.26, 0.17 2.3, 0.25 2.46, 0.3 2.5, 0.3 2.58"
    )
    column = revolve(shaft, 40, 46, flutes=(14, 0.025), caps=(False, True))
    arch = surface(_arch, 30, 10, closed=False, least=(5, 3))
    for side in range(4):
        frame = place(yaw=90 * side)
        x = np.arange(-w, w - 0.1, BAY)
        b.add(column, stone, frame @ place(np.stack([x, 0 * x, 0 * x - w], 1)))
        b.add(arch, stone, frame @ place(np.stack([x + BAY / 2, 0 * x + 2.55, 0 * x - w], 1)))
        b.add(box([-w - 0.2, 4.1, -w - 0.22], [w + 0.2, 6.6, -w + 0.22]), wall, frame)
        cornice = tube(
            np.linspace([-w - 0.2, 4.12, -w + 0.22], [w + 0.2, 4.12, -w + 0.22], 5), 0.07, 9, 30
        )
        b.add(cornice, stone, frame)
        b.add(box([-out, 0, -out - 0.2], [out, 6.6, -out]), "rose_wall", frame)
        b.add(box([-out, 4.1, -out], [w, 4.2, -w - 0.2]), wall, frame)
        _roof(b, frame, out)
        # Windows of the upper floor: reveals with shutters.
        for k in np.arange(-w + BAY / 2, w, BAY):
            spot = frame @ place([k, 5.35, -w + 0.23])
            fixtures.blind(b, spot @ place([0, -0.65, 0.03]), 0.9, 1.3, tilt=40, color="forest")
            bar = soft_box((1.1, 0.09, 0.16), (6, 3, 3), power=8, bulge=0.1)
            b.add(bar, stone, spot @ place([[0, -0.72, 0.02], [0, 0.72, 0.02]]))


def _arch(u: Array, v: Array) -> Array:
    """Moulded half ring of 1.5 m radius around z, with spandrel: u around, v across the section."""
    angle = np.pi * (1 - u)
    section = 2 * np.pi * v
    bead = 1 + 0.06 * np.sin(3 * section)
    radius = 1.27 + 0.2 * np.cos(section) * bead
    z = 0.24 * np.sin(section) * bead + 0.01 * np.sin(9 * angle)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=-1)


def _roof(b: Builder, frame: Array, out: float) -> None:
    x = np.arange(-INNER - 0.3, INNER + 0.31, 0.24)

    def tile(u: Array, v: Array) -> Array:
        angle = np.pi * (1 - u)
        r = 0.125 * (1 - 0.12 * v)
        y = 0.55 * (1 - v) + r * np.sin(angle) + 0.03 * np.abs(np.sin(4 * np.pi * v))
        return np.stack([r * np.cos(angle), y, 1.1 * v - 0.65 + 0 * angle], axis=-1)

    row = surface(tile, 6, 8, least=(3, 1))
    b.add(row, "terracotta", frame @ place(np.stack([x, 0 * x + 6.55, 0 * x - INNER], 1)))


def _fountain(b: Builder) -> None:
    stone, water = b.paint("limestone"), b.paint("water")
    rim = knots(
        "1.75 0, 1.8 0.1, 1.68 0.16, 1.68 0.42, 1.82 0.5, 1.8 0.58, 1.6 0.58, 1.55 0.45, 1.5 0.1"
    )
    b.add(revolve(rim, 96, 40, flutes=(8, 0.03), caps=(False, False)), stone)
    post = [[0.45, 0.0], [0.4, 0.2], [0.22, 0.35], [0.3, 0.7], [0.16, 0.95], [0.2, 1.15]]
    bowl = [[0.2, 1.15], [0.75, 1.3], [0.82, 1.38], [0.78, 1.4], [0.7, 1.34], [0.12, 1.3]]
    b.add(revolve(post, 48, 30, flutes=(12, 0.04)), stone)
    b.add(revolve(bowl, 64, 30, flutes=(16, 0.03), caps=(False, False)), stone)
    top = knots("0.12 1.3, 0.1 1.6, 0.14 1.8, 0.4 1.92, 0.43 1.97, 0.38 1.96, 0.05 1.9")
    b.add(revolve(top, 48, 30, flutes=(10, 0.03), caps=(False, True)), stone)
    for radius, y, rings in ((1.56, 0.46, 30.0), (0.74, 1.365, 18.0)):

        def ripples(
            u: Array, v: Array, radius: float = radius, y: float = y, rings: float = rings
        ) -> Array:
            r, a = radius * (1 - 0.97 * v), 2 * np.pi * u
            h = 0.006 * np.sin(rings * r + 3 * np.sin(2 * a)) + 0.003 * np.sin(19 * r * np.cos(a))
            return np.stack([r * np.sin(a), y + h, r * np.cos(a)], axis=-1)

        b.add(surface(ripples, 90, 30, closed=True, caps=(False, True)), water)
    for turn in range(0, 360, 45):
        jet = [[0, 1.97, 0.36], [0, 2.02, 0.5], [0, 1.8, 0.62], [0, 1.38, 0.68]]
        b.add(tube(jet, [0.008, 0.012, 0.018, 0.02], 6, 18), water, place(yaw=turn), optional=True)


def _furnish(b: Builder, rng: np.random.Generator) -> None:
    for k, (x, z) in enumerate(((-5.6, 1.6), (-3.2, 5.9), (1.6, 6.1), (6.2, -2.2), (6.3, 3.0))):
        spot = place([x, 0.03, z], yaw=40.0 * k)
        furniture.round_table(b, spot, 0.42, 0.73, "forest")
        for n in range(3):
            turn = 120.0 * n + 15 * k
            seat = (
                spot
                @ place(yaw=turn)
                @ place([0, 0, 0.72 + 0.06 * np.sin(7.0 * n + k)], yaw=180 + 12 * np.sin(5.0 * n))
            )
            furniture.chair(b, seat, "forest", cushion=("mustard", "brick_red", "cream")[k % 3])
        top = spot @ place([0, 0.73, 0])
        decor.cup(b, top @ place([0.16, 0, 0.1], yaw=30), "porcelain")
        decor.cup(b, top @ place([-0.14, 0, 0.14], yaw=130), "porcelain")
        decor.bottle(b, top @ place([0.02, 0, -0.14]), "forest")
        decor.vase(b, top @ place([-0.05, 0, 0.0], scale=0.6), k, "sky")
    for k in range(16):
        side, along = divmod(k, 4)
        x = (-7.2, -1.6, 1.6, 7.2)[along]
        spot = place(yaw=90 * side) @ place([x, 0.03, -INNER + 0.9])
        kind = ("terracotta", "cream", "terracotta", "navy")[(k * 7) % 4]
        decor.plant(b, spot, rng, height=0.9 + 0.12 * (k % 5), leaves=70, pot=kind)


def _trunks(b: Builder, rng: np.random.Generator) -> Array:
    """Trunks with branches; returns the points (K, 3) around which leaves grow."""
    bark, tips = b.paint("bark"), []
    for x, z in TREES:
        height = rng.uniform(2.3, 2.8)
        lean = rng.uniform(-0.25, 0.25, 2)
        fork = np.array([x + lean[0], height, z + lean[1]])
        trunk = np.array([[x, -0.1, z], [x + 0.3 * lean[0], height * 0.5, z + 0.7 * lean[1]], fork])
        b.add(tube(trunk, [0.24, 0.16, 0.14, 0.13], 14, 30), bark)
        ring = soft_box((1.5, 0.16, 1.5), (14, 2, 14), power=4, bulge=0.3)
        b.add(ring, "soil", place([x, 0.02, z]))
        for n in range(7):
            turn = 2 * np.pi * (n * 0.618 + x)
            reach, rise = rng.uniform(0.9, 1.9), rng.uniform(0.7, 2.2)
            tip = np.add(fork, [reach * np.cos(turn), rise, reach * np.sin(turn)])
            bend = fork + 0.5 * (tip - fork) + [0, 0.15, 0]
            b.add(tube([fork - [0, 0.1, 0], bend, tip], [0.09, 0.055, 0.02], 9, 16), bark)
            for m in range(3):
                start = fork + (tip - fork) * (0.45 + 0.2 * m)
                end = start + rng.normal(0, 0.38, 3) + [0, 0.3, 0]
                middle = 0.5 * (start + end) + [0, 0.1, 0]
                twig = np.array([np.add(start, [0, 0.05, 0]), middle, end])
                b.add(tube(twig, [0.03, 0.018, 0.008], 6, 8), bark, optional=True)
                tips.append(end)
            tips.append(tip)
    return np.array(tips)


def _paving(b: Builder, rng: np.random.Generator, triangles: int) -> None:
    """Cobbles in 2 x 2 m patches, instanced; left out where the budget is small."""
    if triangles < 300_000:
        return
    detail = min(1.0, (triangles / FULL) ** 0.5)
    x, z = (a.ravel() for a in np.meshgrid(np.arange(6), np.arange(6)))
    middle = np.stack([(x + 0.5) / 3 - 1 + 0.04 * (z % 2), 0 * x + 0.0, (z + 0.5) / 3 - 1], 1)
    stones = []
    for p in middle:
        size = (rng.uniform(0.28, 0.315), 0.07, rng.uniform(0.28, 0.315))
        shape = soft_box(size, (4, 2, 4), power=6, bulge=0.25)
        stones.append(
            _moved(
                shape,
                detail,
                place(np.add(p, [0, rng.uniform(-0.006, 0.006), 0]), yaw=rng.uniform(-4, 4)),
            )
        )
    vertices, faces = join(stones)
    patch = b.add_mesh(vertices, faces, b.paint("stone"), name="cobbles", in_world=False)
    for i in np.arange(-8, 9, 2.0):
        for j in np.arange(-8, 9, 2.0):
            if np.hypot(i, j) > 2.3:
                b.add_instance([patch], place([i, 0.0, j], yaw=90.0 * rng.integers(4)))


def _foliage(b: Builder, rng: np.random.Generator, tips: Array, triangles: int) -> None:
    """Instanced leaf clusters: in the crowns, and as ivy on the arcades."""
    leaves = int(np.clip(110 * triangles / FULL, 6, 110))
    clusters = [_cluster(b, rng, leaves, k) for k in range(4)]
    each = b.sizes[clusters[0]]
    n = -(-(triangles - b.placed) // each)
    for k in range(n):
        if k % 5 < 4:
            p = tips[(k * 37 + k // len(tips)) % len(tips)] + rng.normal(0, 0.2, 3) * [1, 0.8, 1]
            size = rng.uniform(0.75, 1.25)
            at = place(p, yaw=rng.uniform(0, 360), pitch=rng.uniform(-40, 40), scale=size)
        else:
            side, along = rng.integers(4), rng.uniform(-INNER, INNER)
            height = 6.4 - abs(rng.normal(0, 1.1)) * (0.6 + np.sin(2.1 * along + side) ** 2)
            spot = [along, float(np.clip(height, 4.3, 6.7)), -INNER + 0.3]
            at = place(yaw=90.0 * side) @ place(
                spot, pitch=75, roll=rng.uniform(0, 360), scale=[0.8, 0.4, 0.8]
            )
        b.add_instance([clusters[k % 4]], at)


def _cluster(b: Builder, rng: np.random.Generator, n: int, k: int) -> int:
    parts = []
    stem = tube([[0, -0.2, 0], [0.03, 0, 0.02], [0, 0.22, 0]], [0.008, 0.005, 0.002], 4, 4)
    parts.append(_moved(stem, 1.0, np.eye(4)))
    blade = leaf(0.11, 0.05, 0.5, 2, 4)
    for _ in range(n):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        p = direction * 0.34 * rng.uniform(0.15, 1.0) ** 0.5 * [1, 0.7, 1]
        turn = np.degrees(np.arctan2(direction[0], direction[2])) + rng.uniform(-50, 50)
        at = place(
            p,
            yaw=turn,
            pitch=rng.uniform(-20, 55),
            roll=rng.uniform(-30, 30),
            scale=rng.uniform(0.75, 1.2),
        )
        parts.append(_moved(blade, 1.0, at))
    vertices, faces = join(parts)
    color = b.paint(("leaf", "leaf_light", "leaf", "leaf_light")[k])
    return b.add_mesh(vertices, faces, color, name=f"leaves {k}", in_world=False)


def _moved(shape: Shape, detail: float, at: Array) -> tuple[Array, Indices]:
    vertices, faces = shape.mesh(detail)
    return vertices @ at[:3, :3].T + at[:3, 3], faces
