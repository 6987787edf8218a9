"""A church's nave: rows of columns, vaults between them, light from above."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from viscache.scenes.builder import Builder
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import place, quad, revolve, soft_box, surface, tube

LEAST = 1000
BAYS, BAY = 7, 3.0
WALL, AISLE, SPRING, CROWN = 5.0, 2.6, 4.6, 7.4


@scene()
def church(triangles: Annotated[int, Range(LEAST, MOST_TRIANGLES)] = 16_000) -> Builder:
    """Nave of a church, 10 x 7.4 x 21 m, with two rows of columns, vaults and pews.

    Parameters
    ----------
    triangles : int
        Placed triangles; the scene has this many to 1.25 times as many. At least 1000.
    """
    b = Builder("church")
    length = BAYS * BAY / 2
    stone = b.paint("limestone")
    floor = quad([-WALL, 0, length], [WALL, 0, length], [WALL, 0, -length], [-WALL, 0, -length])
    b.add(floor, "cream")
    _columns(b, stone, length)
    _vaults(b, stone, length)
    _walls(b, stone, length)
    _pews(b, length)
    b.fit(triangles)
    for z in (-6.0, 0.0, 6.0):
        b.point_light((0.0, 5.6, z), np.array([42.0, 38.0, 30.0]))
    b.description.set_environment((0.5, 0.55, 0.62))
    b.camera((0.0, 1.7, length - 1.0), (0.0, 2.7, -length), 60.0, name="nave", size=(256, 256))
    b.camera((-3.8, 1.7, 8.0), (1.0, 2.4, -4.0), 58.0, name="aisle", size=(256, 256))
    return b


def _columns(b: Builder, stone: int, length: float) -> None:
    profile = [[0.42, 0], [0.45, 0.1], [0.36, 0.2], [0.4, 0.3], [0.27, 0.42], [0.29, 2.0]]
    profile += [[0.26, 3.9], [0.3, 4.0], [0.27, 4.08], [0.42, 4.4], [0.46, SPRING]]
    column = revolve(profile, 26, 34, caps=(False, True))
    z = -length + BAY * np.arange(BAYS + 1)
    for x in (-AISLE, AISLE):
        spots = place(np.stack([0 * z + x, 0 * z, z], axis=1))
        b.add(column, stone, spots)


def _vaults(b: Builder, stone: int, length: float) -> None:
    """A pointed barrel over the nave with cells cut in, half barrels over the aisles, ribs."""

    def nave(u, v):  # type: ignore[no-untyped-def]
        x = AISLE * np.cos(np.pi * u)
        bay = 0.5 - 0.5 * np.cos(2 * np.pi * BAYS * v)
        side = np.abs(np.cos(np.pi * u)) ** 3
        y = SPRING + (CROWN - SPRING) * np.sin(np.pi * u) ** 0.8 + 1.2 * side * bay
        return np.stack([x, y, length * (1 - 2 * v)], axis=-1)

    b.add(surface(nave, 24, 70), stone)
    for side in (-1, 1):

        def aisle(u, v, side=side):  # type: ignore[no-untyped-def]
            x = side * (AISLE + (WALL - AISLE) * u)
            y = SPRING + 0.9 * np.sin(np.pi * u) + 0.15 * np.cos(2 * np.pi * BAYS * v)
            return np.stack([x, y, length * (1 - 2 * v)], axis=-1)

        b.add(surface(aisle, 10, 56), stone)
    arch = np.linspace(0, np.pi, 17)
    rise = (CROWN - SPRING) * np.sin(arch) ** 0.8
    z = -length + BAY * np.arange(BAYS + 1)
    rib = np.stack([AISLE * np.cos(arch), SPRING + rise - 0.05, 0 * arch], axis=1)
    b.add(tube(rib, 0.09, 7, 22), stone, place(np.stack([0 * z, 0 * z, z], axis=1)))


def _walls(b: Builder, stone: int, length: float) -> None:
    for side in (-1, 1):
        wall = soft_box((0.3, SPRING, 2 * length), (1, 5, 14), power=12, bulge=0.08)
        b.add(wall, stone, place([side * (WALL + 0.15), SPRING / 2, 0]))
        for k in range(BAYS):
            z = -length + BAY * (k + 0.5)
            frame = [[0, 1.4, z - 0.6], [0, 3.2, z - 0.6], [0, 4.0, z], [0, 3.2, z + 0.6]]
            path = np.array([*frame, [0, 1.4, z + 0.6]])
            path[:, 0] = side * (WALL - 0.03)
            b.add(tube(path, 0.07, 6, 18), "oak", optional=True)
    far = soft_box((2 * WALL, CROWN, 0.3), (6, 5, 1), power=12, bulge=0.08)
    b.add(far, stone, place([0, CROWN / 2, -length - 0.15]))
    altar = soft_box((2.0, 1.0, 0.9), (6, 4, 4), power=12, bulge=0.03)
    b.add(altar, "porcelain", place([0, 0.5, -length + 1.6]))


def _pews(b: Builder, length: float) -> None:
    z = -length + 4.2 + 1.05 * np.arange(11)
    for x in (-1.3, 1.3):
        spots = place(np.stack([0 * z + x, 0 * z, z], axis=1))
        seat = soft_box((1.7, 0.06, 0.42), (4, 1, 2), power=6, bulge=0.2)
        back = soft_box((1.7, 0.5, 0.05), (4, 3, 1), power=6, bulge=0.2)
        b.add(seat, "walnut", spots @ place([0, 0.45, 0]))
        b.add(back, "walnut", spots @ place([0, 0.72, 0.22], pitch=8))
        for end in (-0.82, 0.82):
            leg = soft_box((0.05, 0.95, 0.45), (1, 3, 1), power=4, bulge=0.3)
            b.add(leg, "walnut", spots @ place([end, 0.475, 0.05]))
