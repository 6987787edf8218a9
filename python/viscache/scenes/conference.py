"""The conference room: tables, swivel chairs and light panels in the ceiling."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from viscache.scenes import decor, fixtures, furniture, walls
from viscache.scenes.builder import Builder
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import (
    Array,
    curtain,
    place,
    quad,
    revolve,
    rod,
    soft_box,
    surface,
    tube,
)

SEED = 4242
HEIGHT = 3.2
TABLES = ((-2.1, 0.0), (2.1, 0.0))


@scene()
def conference(triangles: Annotated[int, Range(200, MOST_TRIANGLES)] = 280_000) -> Builder:
    """Conference room, 13 x 3.2 x 9 m, lit by ten light panels in the ceiling.

    Parameters
    ----------
    triangles : int
        Placed triangles; the scene has this many to 1.25 times as many. At least 200.
    """
    b, rng = Builder("conference"), np.random.Generator(np.random.PCG64(SEED))
    _shell(b)
    for k, (x, z) in enumerate(TABLES):
        _meeting_table(b, rng, x, z, k)
    _walls(b, rng)
    _ceiling(b)
    b.fit(triangles)
    b.camera((-6.0, 1.75, 3.95), (1.2, 0.75, -0.9), 52.0, name="door")
    b.camera((5.9, 1.6, 3.6), (-2.0, 0.8, -1.5), 52.0, name="screen")
    return b


def _shell(b: Builder) -> None:
    x, y, z = 6.5, HEIGHT, 4.5
    walls.shell(b, (x, y, z), "grey_cloth", ("plaster", "plaster", "blue_wall", "plaster"))
    ring = [[-x, 0.05, -z], [x, 0.05, -z], [x, 0.05, z], [-x, 0.05, z], [-x, 0.05, -z]]
    fixtures.skirting(b, [[ring[k], ring[k + 1]] for k in range(4)])


def _meeting_table(b: Builder, rng: np.random.Generator, x: float, z: float, k: int) -> None:
    center = place([x, 0, z])
    top = soft_box((3.7, 0.04, 1.5), (26, 2, 12), power=5, bulge=0.02)
    b.add(top, "walnut", center @ place([0, 0.72, 0]))
    column = [[0.3, 0], [0.3, 0.02], [0.12, 0.06], [0.09, 0.35], [0.13, 0.66], [0.24, 0.70]]
    b.add(revolve(column, 30, 20), "steel", center @ place([[-1.1, 0, 0], [1.1, 0, 0]]))
    board = center @ place([0, 0.742, 0])
    seats = [(sx, side) for side in (-1, 1) for sx in (-1.25, -0.42, 0.42, 1.25)]
    for n, (sx, side) in enumerate(seats):
        out = 1.05 + 0.09 * np.sin(7.0 * n + 3 * k)
        turn = (180 if side > 0 else 0) + 14 * np.sin(5.0 * n + k)
        furniture.desk_chair(
            b, center @ place([sx, 0, side * out], yaw=turn), "navy" if k else "grey_cloth"
        )
        place_mat = board @ place([sx, 0, side * 0.42], yaw=180 if side < 0 else 0)
        if (n + k) % 3 != 2:
            fixtures.laptop(b, place_mat)
        else:
            _papers(b, rng, n, place_mat)
        decor.cup(
            b,
            place_mat @ place([0.25, 0, -0.06], yaw=50 * n),
            ("porcelain", "sky", "brick_red")[n % 3],
        )
        if n % 2:
            decor.bottle(b, place_mat @ place([-0.24, 0, -0.16]), "forest")
    decor.bowl(b, board @ place([-0.35, 0, 0]), 0.16, "cream", fruit=True)
    decor.vase(b, board @ place([0.3, 0, 0]), 2 * k, ("mustard", "petrol")[k])
    decor.bouquet(b, board @ place([0.3, 0.2 + 0.14 * (1 - k), 0]), rng, ("apple", "lemon")[k], 16)


def _papers(b: Builder, rng: np.random.Generator, n: int, at: Array) -> None:
    def sheet(u: Array, v: Array) -> Array:
        x, z = (u - 0.5) * 0.21, (v - 0.5) * 0.297
        y = 0.003 + 0.004 * (1 + np.sin(4 * u + 3 * v + n) * np.sin(5 * v + 2 * u))
        return np.stack([x, y, z], axis=-1)

    for k in range(4):
        spot = place(
            [rng.uniform(-0.08, 0.08), 0.001 * k, rng.uniform(-0.04, 0.04)],
            yaw=rng.uniform(-25, 25),
        )
        b.add(surface(sheet, 6, 8), "paper", at @ spot, optional=k > 0)
    pen = tube(
        [[0, 0.012, -0.07], [0, 0.0125, 0], [0, 0.012, 0.07]], [0.002, 0.005, 0.005, 0.004], 6, 6
    )
    b.add(pen, "navy", at @ place([0.05, 0.008, 0.02], yaw=35), optional=True)


def _walls(b: Builder, rng: np.random.Generator) -> None:
    # Screen wall (x = 6.5) with a lectern, window wall (z = -4.5) with blinds and curtains.
    screen = soft_box((2.6, 1.5, 0.06), (12, 8, 2), power=30, bulge=0.1)
    b.add(screen, "screen", place([6.44, 1.75, 0], yaw=-90))
    board = place([6.47, 0, 2.9], yaw=-90)
    furniture.cabinet(b, board, (1.7, 0.78, 0.45), "oak", doors=3)
    fixtures.screen(b, board @ place([0.3, 0.78, 0.2], yaw=15))
    decor.book_pile(b, board @ place([-0.5, 0.78, 0.2]), rng, 5)
    for k, x in enumerate((-4.4, -1.5, 1.5, 4.4)):
        fixtures.blind(b, place([x, 1.0, -4.42]), 1.8, 1.75, tilt=30 + 8 * k)
        furniture_frame = ((0, 0.97, 1.9, 0.05), (0, 2.78, 1.9, 0.05))
        for dx, y, wide, high in furniture_frame:
            bar = soft_box((wide, high, 0.08), (7, 2, 2), power=10, bulge=0.1)
            b.add(bar, "white_paint", place([x + dx, y, -4.46]))
        fixtures.radiator(b, place([x, 0.02, -4.48]), 1.4, 0.6)
        for side in (-1, 1):
            spot = place([x + side * 1.18, 0.04, -4.3])
            b.add(curtain(0.46, 2.9, 5, 0.05), "linen", spot)
    b.add(tube([[-6.3, 2.98, -4.3], [0, 2.985, -4.3], [6.3, 2.98, -4.3]], 0.014, 8, 24), "steel")
    # Back wall (x = -6.5): shelves; long wall (z = 4.5): pictures, sideboard, coat stand.
    for k in range(3):
        unit = place([-6.47, 0, -2.9 + 1.0 * k], yaw=90)
        furniture.bookshelf(b, unit, rng, wood="beech", height=2.1, fill=0.8)
    for k, colors in enumerate(
        ("navy petrol sky cream", "plum rose_wall cream", "forest sage cream sky")
    ):
        decor.picture(b, place([-2.5 + 2.6 * k, 1.75, 4.497], yaw=180), (1.5, 1.0), colors, 1.7 * k)
    long = place([0.3, 0, 4.47], yaw=180)
    furniture.cabinet(b, long, (3.2, 0.85, 0.5), "oak", doors=5)
    for k in range(8):
        decor.cup(
            b, long @ place([-1.3 + 0.13 * k, 0.85, 0.2 + 0.1 * (k % 2)], yaw=40 * k), "porcelain"
        )
    for k in range(5):
        decor.bottle(
            b, long @ place([0.1 + 0.12 * k, 0.85, 0.2 + 0.05 * (k % 3)]), ("forest", "plum")[k % 2]
        )
    decor.bowl(b, long @ place([1.05, 0.85, 0.25]), 0.18, "sky", fruit=True)
    for x, z, h, pot in (
        (-5.9, -3.85, 1.9, "cream"),
        (5.9, -3.8, 1.7, "terracotta"),
        (4.2, 4.0, 1.5, "navy"),
    ):
        decor.plant(b, place([x, 0, z]), rng, height=h, leaves=170, pot=pot)
    for k in range(4):  # a row of chairs for listeners
        furniture.chair(
            b,
            place([-2.2 + 0.75 * k, 0, 3.25 + 0.05 * np.sin(9.0 * k)], yaw=176 + 4 * k),
            "oak",
            cushion="petrol",
        )


def _ceiling(b: Builder) -> None:
    panel = b.diffuse("panel", (0.5, 0.5, 0.5))
    corner = [[-0.6, 0, -0.3], [0.6, 0, -0.3], [0.6, 0, 0.3], [-0.6, 0, 0.3]]
    for x in (-4.8, -2.4, 0.0, 2.4, 4.8):
        for z in (-1.5, 1.5):
            b.add(quad(*corner), panel, place([x, HEIGHT - 0.03, z]), emission=(9.0, 9.0, 8.7))
            for dz in (-0.33, 0.33):
                bar = soft_box((1.32, 0.05, 0.05), (6, 2, 2), power=9, bulge=0.1)
                b.add(bar, "steel", place([x, HEIGHT - 0.03, z + dz]))
            for dx in (-0.63, 0.63):
                bar = soft_box((0.05, 0.05, 0.6), (2, 2, 4), power=9, bulge=0.1)
                b.add(bar, "steel", place([x + dx, HEIGHT - 0.03, z]))
    # Acoustic baffles hang between the panels.
    for z in (0.0, -3.4, 3.4):
        fixtures.slats(b, place([0, HEIGHT - 0.28, z]), 30, 0.4, (0.05, 0.22, 1.3), "beech", 0.004)
        for dz in (-0.5, 0.5):
            shape = rod([-6.3, HEIGHT - 0.14, z + dz], [6.3, HEIGHT - 0.14, z + dz], 0.012, 8)
            b.add(shape, "black_metal")
    # Projector.
    b.add(rod([0.9, HEIGHT - 0.02, 0.75], [0.9, HEIGHT - 0.35, 0.75], 0.02, 10), "black_metal")
    body = soft_box((0.36, 0.13, 0.3), (7, 4, 7), power=7, bulge=0.1)
    b.add(body, "white_paint", place([0.9, HEIGHT - 0.41, 0.75]))
