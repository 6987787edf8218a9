"""The apartment: seven furnished rooms, 24 lamps, windows to the sky.

Seen from above (x to the right, z down)::

    living and dining      | bedroom A | bedroom B
    -----------+-- hall ---------------------------
    kitchen    | bath      | study     | child's room
"""

from __future__ import annotations

from typing import Annotated

import numpy as np

from viscache.scenes import decor, fixtures, furniture
from viscache.scenes.builder import Builder
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import (
    Array,
    bumpy_sphere,
    curtain,
    cylinder,
    knots,
    place,
    quad,
    revolve,
    soft_box,
    tube,
)
from viscache.scenes.walls import door, wall

SEED = 2406
LEAST = 2_000
HEIGHT = 2.7
WEST, EAST, NORTH, SOUTH = -7.0, 7.0, -4.5, 4.5
HALL_NORTH, HALL_SOUTH = 0.8, 2.1
INTENSITY = 7.0  # W/sr per lamp
WARM = np.array([1.0, 0.88, 0.7])


@scene()
def apartment(triangles: Annotated[int, Range(LEAST, MOST_TRIANGLES)] = 750_000) -> Builder:
    """Furnished flat of seven rooms, 14 x 2.7 x 9 m, with 24 lamps and windows to the sky.

    Parameters
    ----------
    triangles : int
        Placed triangles; the scene has this many to 1.25 times as many. At least 2000.
    """
    b, rng = Builder("apartment"), np.random.Generator(np.random.PCG64(SEED))
    _shell(b)
    _living(b, rng)
    _kitchen(b, rng)
    _bath(b)
    _hall(b, rng)
    _study(b, rng)
    _bedroom_a(b, rng)
    _bedroom_b(b, rng)
    _child(b, rng)
    b.fit(triangles)
    b.description.set_environment((1.1, 1.25, 1.45))
    b.camera((-0.1, 1.65, 0.35), (-4.6, 0.85, -3.2), 56.0, name="living")
    b.camera((-3.25, 1.65, 4.1), (-5.7, 0.9, 1.2), 62.0, name="kitchen")
    b.camera((3.2, 1.65, 0.55), (1.3, 0.75, -3.0), 60.0, name="bedroom")
    b.camera((2.85, 1.65, 2.3), (0.5, 0.85, 3.7), 66.0, name="study")
    b.camera((6.1, 1.6, 1.75), (-3.0, 1.2, 1.35), 55.0, name="hall")
    return b


def _shell(b: Builder) -> None:
    w, e, n, s, h = WEST, EAST, NORTH, SOUTH, HEIGHT
    b.add(quad([w, 0, s], [0.5, 0, s], [0.5, 0, n], [w, 0, n]), "floor_oak")
    b.add(quad([0.5, 0, s], [e, 0, s], [e, 0, n], [0.5, 0, n]), "beech")
    tiles = quad([-3, 0.004, s], [0, 0.004, s], [0, 0.004, HALL_SOUTH], [-3, 0.004, HALL_SOUTH])
    b.add(tiles, "floor_tile")
    b.add(quad([w, h, n], [e, h, n], [e, h, s], [w, h, s]), "ceiling")
    window = (0.9, 2.25)
    # Outer walls; distances run along each wall.
    views = [(1.2, 3.2), (4.4, 6.4), (8.6, 10.2), (11.9, 13.3)]
    wall(b, (w, n), (e, n), h, "plaster", [(*v, *window) for v in views])
    views = [(1.2, 2.8), (5.1, 5.9), (8.0, 9.6), (11.4, 13.0)]
    wall(b, (w, s), (e, s), h, "plaster", [(*v, 1.05 if v[0] < 6 else 0.9, 2.25) for v in views])
    wall(b, (w, n), (w, s), h, "sage", [(1.6, 3.4, 0.25, 2.3)])
    wall(b, (e, n), (e, s), h, "plaster", [(1.4, 2.8, *window)])
    # Inner walls with door openings 0.9 m wide.
    wall(b, (0.5, n), (0.5, HALL_NORTH), h, "rose_wall", [(4.1, 5.0, 0.0, 2.1)], 0.12)
    wall(b, (4.0, n), (4.0, HALL_NORTH), h, "blue_wall", (), 0.12)
    wall(b, (0.5, HALL_NORTH), (e, HALL_NORTH), h, "plaster", [(5.0, 5.9, 0.0, 2.1)], 0.12)
    wall(b, (-3.0, HALL_SOUTH), (e, HALL_SOUTH), h, "plaster", _doors(1.0, 4.4, 7.6), 0.12)
    wall(b, (w, HALL_NORTH), (-3.0, HALL_NORTH), h, "plaster", [(0.9, 3.3, 0.0, 2.3)], 0.12)
    wall(b, (-3.0, HALL_SOUTH), (-3.0, s), h, "plaster", (), 0.12)
    wall(b, (0.0, HALL_SOUTH), (0.0, s), h, "plaster", (), 0.12)
    wall(b, (3.5, HALL_SOUTH), (3.5, s), h, "blue_wall", (), 0.12)
    for x, z, yaw, opened in (
        (-1.98, HALL_SOUTH, 0, 70),
        (1.42, HALL_SOUTH, 0, 12),
        (4.62, HALL_SOUTH, 0, 80),
    ):
        door(b, place([x, 0, z + 0.03], yaw=yaw), open_deg=opened)
    door(b, place([5.52, 0, HALL_NORTH - 0.02], yaw=0), open_deg=-75)
    runs = [[[w + 0.09, 0.04, n], [w + 0.09, 0.04, s]], [[w, 0.04, n + 0.09], [e, 0.04, n + 0.09]]]
    runs += [[[w, 0.04, s - 0.09], [e, 0.04, s - 0.09]], [[e - 0.09, 0.04, n], [e - 0.09, 0.04, s]]]
    fixtures.skirting(b, runs)


def _doors(*starts: float) -> list[tuple[float, float, float, float]]:
    return [(x, x + 0.9, 0.0, 2.1) for x in starts]


def _pendant(b: Builder, x: float, z: float, drop: float, color: str = "brass") -> None:
    decor.pendant(b, place([x, HEIGHT, z]), drop, color)
    b.point_light((x, HEIGHT - drop + 0.08, z), INTENSITY * WARM)


def _floor_lamp(b: Builder, x: float, z: float, height: float = 1.65) -> None:
    decor.floor_lamp(b, place([x, 0, z]), height)
    b.point_light((x, height - 0.12, z), 0.6 * INTENSITY * WARM)


def _table_lamp(b: Builder, at: Array, color: str) -> None:
    decor.table_lamp(b, at, color)
    b.point_light(at[:3, 3] + [0, 0.42, 0], 0.4 * INTENSITY * WARM)


def _drapes(b: Builder, at: Array, width: float, color: str) -> None:
    """A pair of curtains on a rail; `at` is the window's middle on the floor, facing +z."""
    for side in (-1, 1):
        cloth = curtain(0.42, 2.38, 5, 0.045)
        b.add(cloth, color, at @ place([side * (width / 2 + 0.18), 0.05, 0.2]))
    x = width / 2 + 0.5
    rail = tube([[-x, 2.45, 0.2], [0, 2.455, 0.2], [x, 2.45, 0.2]], 0.013, 8, 12)
    b.add(rail, "brass", at)


def _living(b: Builder, rng: np.random.Generator) -> None:
    for x in (-4.8, -1.6):
        _drapes(b, place([x, 0, NORTH + 0.08]), 2.0, "linen")
        fixtures.radiator(b, place([x, 0, NORTH + 0.1]), 1.5, 0.5)
    furniture.rug(b, place([-4.6, 0, -2.3]), (3.0, 2.3), "rug_red")
    couch = place([-4.6, 0, -3.65])
    furniture.sofa(b, couch, "petrol", width=2.4, pillows="mustard cream rug_red navy")
    furniture.throw_blanket(b, couch @ place([-1.11, 0.645, 0.1]), "cream")
    chair = place([-6.1, 0, -1.55], yaw=105)
    furniture.sofa(b, chair, "grey_cloth", width=0.98, seats=1)
    furniture.throw_pillow(b, chair @ place([0, 0.65, 0], pitch=-20), "terracotta", 0.4)
    low = place([-4.6, 0.012, -2.2])
    furniture.round_table(b, low, 0.5, 0.43, "walnut")
    decor.bowl(b, low @ place([0.1, 0.43, 0.14]), 0.15, "sky", fruit=True)
    decor.book_pile(b, low @ place([-0.2, 0.43, 0.02], yaw=20), rng, 4)
    decor.cup(b, low @ place([0.14, 0.43, -0.22], yaw=80), "porcelain")
    # Dining corner.
    center = place([-1.7, 0, -2.5])
    furniture.rug(b, center, (3.0, 2.4), "rug_beige")
    furniture.table(b, center @ place([0, 0.012, 0]), (1.9, 0.95), "oak")
    seats = [
        (-0.5, 0.74, 176),
        (0.5, 0.76, 186),
        (-0.5, -0.74, 4),
        (0.5, -0.75, -6),
        (1.24, 0.05, -88),
        (-1.22, 0, 92),
    ]
    spots = place([[x, 0.012, z] for x, z, _ in seats], yaw=[t for *_, t in seats])
    furniture.chair(b, center @ spots, "walnut", cushion="sage")
    top = center @ place([0, 0.764, 0])
    for x, z, _ in seats[:4]:
        decor.crockery(b, top @ place([x, 0, np.sign(z) * 0.28], yaw=0 if z > 0 else 180))
    decor.vase(b, top, 2, "mustard", flutes=11)
    decor.bouquet(b, top @ place([0, 0.2, 0]), rng, "apple", 18)
    decor.candlestick(b, top @ place([-0.35, 0, 0.03]), 0.32)
    decor.candlestick(b, top @ place([0.36, 0, -0.04]), 0.26)
    # Shelves along the inner wall, a low board along the kitchen's wall.
    for k in range(2):
        unit = place([0.42, 0, -3.9 + 0.98 * k], yaw=-90)
        furniture.bookshelf(b, unit, rng, wood="oak", height=2.1)
    board = place([-6.85, 0, -0.35], yaw=90)
    furniture.cabinet(b, board, (1.7, 0.6, 0.42), "walnut", doors=3)
    fixtures.screen(b, board @ place([0, 0.6, 0.2]), 1.1)
    decor.ornament(b, board @ place([0.7, 0.6, 0.2]), 0.09, "brick_red", 1.0)
    decor.picture(b, place([0.437, 1.55, -1.6], yaw=-90), (1.0, 0.7), "navy petrol sky cream", 0.4)
    decor.plant(b, place([-6.45, 0, -3.95]), rng, height=1.9, leaves=240, pot="cream")
    decor.plant(b, place([-0.1, 0, 0.45]), rng, height=1.1, leaves=120)
    _pendant(b, -2.15, -2.5, 1.05)
    _pendant(b, -1.25, -2.5, 1.05)
    _pendant(b, -4.6, -2.2, 0.55, "black_metal")
    _floor_lamp(b, -3.05, -3.95)
    _floor_lamp(b, -6.3, -2.55, 1.6)


def _kitchen(b: Builder, rng: np.random.Generator) -> None:
    top, stone = 0.9, b.paint("stone")
    south = place([-4.95, 0, SOUTH - 0.09], yaw=180)
    furniture.cabinet(b, south, (3.6, 0.86, 0.58), "white_paint", doors=6)
    shape = soft_box((3.66, 0.04, 0.64), (14, 2, 6), power=26, bulge=0.02)
    b.add(shape, stone, south @ place([0, 0.88, 0.31]))
    sink = [[0.2, 0.004], [0.22, 0.012], [0.19, 0.006], [0.17, -0.1], [0.04, -0.14]]
    part = revolve(sink, 28, 16, caps=(False, True))
    b.add(part, "steel", south @ place([0.3, top + 0.004, 0.3]))
    tap = [[0.0, 0, 0], [0, 0.24, 0], [0, 0.31, 0.07], [0, 0.27, 0.16], [0, 0.24, 0.165]]
    b.add(tube(tap, [0.018, 0.012, 0.012, 0.011], 10, 26), "steel", south @ place([0.3, top, 0.06]))
    for k in range(4):  # pots on the hob
        spot = south @ place([-0.9 + 0.27 * (k % 2), top, 0.2 + 0.25 * (k // 2)])
        pot = [
            [0.1, 0],
            [0.115, 0.01],
            [0.115, 0.11 + 0.03 * k],
            [0.12, 0.115 + 0.03 * k],
            [0.11, 0.11 + 0.03 * k],
            [0.1, 0.02],
        ]
        b.add(revolve(pot, 24, 18, caps=(True, True)), "steel", spot)
        grip = tube([[0, 0.1, 0.11], [0, 0.12, 0.2], [0, 0.125, 0.3]], [0.008, 0.011, 0.009], 7, 8)
        b.add(grip, "black_metal", spot @ place(yaw=150 + 40 * k))
    for k in range(7):
        decor.bottle(
            b,
            south @ place([1.1 + 0.09 * k, top, 0.1 + 0.05 * (k % 2)], scale=0.9),
            ("forest", "plum", "cream")[k % 3],
        )
    decor.bowl(b, south @ place([-0.35, top, 0.3]), 0.16, "mustard", fruit=True)
    west = place([WEST + 0.09, 0, 2.45], yaw=90)
    furniture.cabinet(b, west, (2.2, 0.86, 0.58), "white_paint", doors=4)
    shape = soft_box((2.2, 0.04, 0.62), (10, 2, 6), power=26, bulge=0.02)
    b.add(shape, stone, west @ place([0, 0.88, 0.3]))
    for k in range(3):
        decor.vase(
            b,
            west @ place([-0.8 + 0.25 * k, top, 0.2], scale=0.75),
            k,
            ("cream", "sky", "terracotta")[k],
        )
    for y in (1.45, 1.8):  # open shelves with crockery
        board = soft_box((2.0, 0.03, 0.26), (8, 2, 3), power=26, bulge=0.03)
        b.add(board, "oak", west @ place([0, y, 0.14]))
        for k in range(11):
            spot = west @ place([-0.9 + 0.18 * k, y + 0.015, 0.13], yaw=33 * k)
            decor.cup(b, spot, ("porcelain", "sky", "mustard", "brick_red")[(k * 3) % 4])
    _island(b, rng)
    decor.plant(b, place([-3.35, 0, 1.25]), rng, height=1.3, leaves=140, pot="navy")
    for x in (-5.5, -4.5):
        _pendant(b, x, 2.45, 0.95, "black_metal")
    _pendant(b, -5.9, 3.75, 0.5)
    _pendant(b, -3.9, 1.4, 0.5)


def _island(b: Builder, rng: np.random.Generator) -> None:
    island = place([-5.0, 0, 2.45])
    furniture.cabinet(b, island @ place([0, 0, -0.35]), (1.7, 0.86, 0.7), "petrol", doors=3)
    shape = soft_box((1.9, 0.045, 0.95), (12, 2, 8), power=20, bulge=0.02)
    b.add(shape, "oak", island @ place([0, 0.885, 0]))
    decor.bowl(b, island @ place([-0.5, 0.905, 0.1]), 0.2, "porcelain", fruit=True)
    decor.book_pile(b, island @ place([0.5, 0.905, -0.1], yaw=15), rng, 3)
    decor.crockery(b, island @ place([0.2, 0.905, 0.2]), "sky")
    for k in range(3):
        stool = island @ place([-0.6 + 0.6 * k, 0, -0.72])
        seat = [[0.02, 0.66], [0.17, 0.665], [0.18, 0.69], [0.16, 0.705], [0.03, 0.695]]
        b.add(revolve(seat, 26, 12, caps=(True, True), dome=0.05), "oak", stool)
        for turn in (45, 135, 225, 315):
            leg = tube([[0, 0, 0.2], [0, 0.35, 0.15], [0, 0.67, 0.1]], [0.013, 0.017, 0.015], 8, 8)
            b.add(leg, "black_metal", stool @ place(yaw=turn))


def _bath(b: Builder) -> None:
    white = b.paint("porcelain")
    rim = knots(
        "0.02 0.13, 0.5 0.14, 0.72 0.3, 0.8 0.55, 0.86 0.57, 0.87 0.52, 0.8 0.3, 0.6 0.02, 0.1 0.0"
    )
    tub = revolve(rim, 56, 34, caps=(True, True))
    b.add(tub, white, place([-1.15, 0.02, 4.02], scale=[1.0, 1.0, 0.42]))
    basin = knots("0.1 0, 0.09 0.3, 0.1 0.62, 0.26 0.78, 0.29 0.82, 0.25 0.82, 0.05 0.7")
    shape = revolve(basin, 34, 26, caps=(True, True))
    b.add(shape, white, place([-2.65, 0, 3.1], scale=[1.0, 1.0, 1.15]))
    tap = tube([[0.0, 0, 0], [0, 0.14, 0], [0.08, 0.18, 0], [0.14, 0.13, 0]], 0.011, 8, 18)
    b.add(tap, "steel", place([-2.86, 0.8, 3.1]))
    bowl = knots("0.11 0, 0.13 0.2, 0.2 0.36, 0.22 0.4, 0.17 0.41, 0.1 0.25, 0.03 0.2")
    part = revolve(bowl, 30, 22, caps=(True, True))
    b.add(part, white, place([-0.45, 0, 2.9], scale=[1.25, 1, 1]))
    cistern = soft_box((0.2, 0.38, 0.4), (5, 7, 7), power=7, bulge=0.1)
    b.add(cistern, white, place([-0.18, 0.6, 2.9]))
    for k, color in enumerate(("sky", "cream", "terracotta")):
        cloth = curtain(0.4, 0.6, 4, 0.02)
        b.add(
            cloth,
            color,
            place([-2.85, 0.85, 3.75 + 0.0 * k], yaw=90) @ place([-0.15 * k, 0.05 * k, 0.02 * k]),
        )
    b.add(tube([[-2.86, 1.5, 3.5], [-2.855, 1.5, 3.9], [-2.86, 1.5, 4.3]], 0.01, 8, 8), "steel")
    furniture.rug(b, place([-1.4, 0.004, 3.1]), (1.0, 0.6), "sky")
    decor.basket(b, place([-2.6, 0, 2.45]), 0.2, "rug_beige")
    drape = curtain(1.0, 1.75, 8, 0.04)
    b.add(drape, "linen", place([-0.62, 0.6, 3.58]))
    part = tube([[-2.1, 2.36, 3.58], [-1.1, 2.362, 3.58], [-0.08, 2.36, 3.58]], 0.012, 8, 10)
    b.add(part, "steel")
    _pendant(b, -1.9, 2.9, 0.45, "steel")
    _pendant(b, -1.0, 3.2, 0.45, "steel")


def _hall(b: Builder, rng: np.random.Generator) -> None:
    furniture.rug(b, place([1.2, 0, 1.42], yaw=90), (0.8, 4.6), "rug_red")
    board = place([2.6, 0, HALL_NORTH + 0.08])
    furniture.cabinet(b, board, (1.2, 0.82, 0.3), "oak", doors=2)
    _table_lamp(b, board @ place([-0.35, 0.82, 0.15]), "terracotta")
    decor.ornament(b, board @ place([0.3, 0.82, 0.15]), 0.09, "navy", 2.0)
    decor.picture(
        b, place([1.2, 1.6, HALL_NORTH + 0.063]), (0.8, 0.6), "plum rose_wall cream sky", 2.2
    )
    decor.picture(
        b, place([4.2, 1.6, HALL_NORTH + 0.063]), (0.6, 0.8), "forest leaf_light mustard sky", 3.1
    )
    stand = revolve(
        [[0.2, 0], [0.2, 0.03], [0.03, 0.06], [0.025, 1.0], [0.03, 1.8], [0.01, 1.85]], 18, 40
    )
    spot = place([6.6, 0, 1.15])
    b.add(stand, "walnut", spot)
    for turn in range(0, 360, 60):
        hook = tube([[0, 1.7, 0.02], [0, 1.66, 0.1], [0, 1.75, 0.16]], 0.01, 7, 9)
        b.add(hook, "walnut", spot @ place(yaw=turn))
    for yaw, color in ((10.0, "navy"), (125.0, "mustard"), (250.0, "grey_cloth")):
        coat = curtain(0.34, 1.05, 4, 0.06)
        b.add(coat, color, spot @ place(yaw=yaw) @ place([0, 0.62, 0.17]))
    decor.plant(b, place([-2.6, 0, 1.75]), rng, height=1.3, leaves=110, pot="terracotta")
    for x in (-1.2, 4.8):
        _pendant(b, x, 1.45, 0.4)


def _study(b: Builder, rng: np.random.Generator) -> None:
    _drapes(b, place([1.8, 0, SOUTH - 0.08], yaw=180), 1.6, "navy")
    furniture.table(b, place([0.5, 0, 3.3], yaw=90), (1.5, 0.7), "oak", 0.74)
    desk = place([0.5, 0.742, 3.3], yaw=90)
    fixtures.screen(b, desk @ place([0.0, 0, -0.12]), 0.6)
    fixtures.laptop(b, desk @ place([0.5, 0, 0.05], yaw=-15))
    decor.book_pile(b, desk @ place([-0.55, 0, 0.05]), rng, 6)
    decor.cup(b, desk @ place([-0.3, 0, 0.2], yaw=30), "mustard")
    _table_lamp(b, desk @ place([-0.58, 0, -0.22]), "petrol")
    furniture.desk_chair(b, place([1.25, 0, 3.35], yaw=-80), "navy")
    for k in range(2):
        furniture.bookshelf(b, place([3.42, 0, 2.72 + 0.99 * k], yaw=-90), rng, wood="walnut")
    furniture.rug(b, place([1.7, 0, 3.2]), (1.7, 1.6), "rug_beige")
    decor.plant(b, place([0.35, 0, 4.05]), rng, height=1.0, leaves=90)
    decor.picture(b, place([0.063, 1.6, 3.3], yaw=90), (0.9, 0.6), "navy sky cream", 1.3)
    _pendant(b, 1.75, 3.2, 0.45)
    _floor_lamp(b, 2.75, 4.1, 1.55)


def _bedroom_a(b: Builder, rng: np.random.Generator) -> None:
    _drapes(b, place([2.4, 0, NORTH + 0.08]), 1.6, "plum")
    furniture.rug(b, place([2.1, 0, -1.9]), (2.4, 2.4), "rug_beige")
    furniture.bed(b, place([1.7, 0.0, -2.6], yaw=90), width=1.6, cover="blue_wall")
    for z, color in ((-3.75, "mustard"), (-1.5, "terracotta")):
        stand = place([0.57, 0, z], yaw=90)
        furniture.cabinet(b, stand, (0.45, 0.5, 0.38), "oak", doors=1)
        _table_lamp(b, stand @ place([0, 0.5, 0.18]), color)
    decor.book_pile(b, place([0.85, 0.5, -1.36]), rng, 2)
    furniture.cabinet(b, place([3.93, 0, -2.5], yaw=-90), (2.2, 2.2, 0.58), "white_paint", doors=4)
    furniture.bookshelf(
        b, place([1.75, 0, 0.72], yaw=180), rng, wood="beech", height=1.1, shelves=3
    )
    decor.vase(b, place([1.6, 1.06, 0.55]), 0, "sky")
    decor.bouquet(b, place([1.6, 1.36, 0.55]), rng, "lemon", 12)
    decor.picture(b, place([0.563, 1.7, -2.6], yaw=90), (1.2, 0.7), "petrol sky cream mustard", 0.8)
    decor.plant(b, place([3.5, 0, -3.95]), rng, height=1.4, leaves=130, pot="cream")
    _pendant(b, 2.3, -2.0, 0.5)


def _bedroom_b(b: Builder, rng: np.random.Generator) -> None:
    _drapes(b, place([5.6, 0, NORTH + 0.08]), 1.4, "terracotta")
    furniture.bed(b, place([5.75, 0, -2.4], yaw=-90), width=1.4, cover="mustard", wood="walnut")
    stand = place([6.9, 0, -3.5], yaw=-90)
    furniture.cabinet(b, stand, (0.45, 0.5, 0.38), "walnut", doors=1)
    _table_lamp(b, stand @ place([0, 0.5, 0.18]), "sage")
    furniture.rug(b, place([5.3, 0, -0.8]), (2.0, 1.3), "rug_red")
    furniture.cabinet(b, place([4.07, 0, -3.2], yaw=90), (1.6, 2.1, 0.55), "oak", doors=3)
    chair = place([4.75, 0, -0.3], yaw=150)
    furniture.sofa(b, chair, "linen", width=0.95, seats=1)
    furniture.throw_pillow(b, chair @ place([0, 0.65, 0], pitch=-20), "petrol", 0.4)
    decor.plant(b, place([6.5, 0, 0.2]), rng, height=1.5, leaves=130)
    _pendant(b, 5.5, -1.4, 0.5)


def _child(b: Builder, rng: np.random.Generator) -> None:
    _drapes(b, place([5.2, 0, SOUTH - 0.08], yaw=180), 1.6, "leaf_light")
    furniture.bed(b, place([6.35, 0, 3.25], yaw=180), width=0.95, cover="brick_red", wood="beech")
    furniture.rug(b, place([4.9, 0, 3.2]), (1.7, 1.5), "navy")
    shelf = place([3.57, 0, 3.55], yaw=90)
    furniture.bookshelf(b, shelf, rng, wood="beech", height=1.3, shelves=3)
    decor.ornament(b, shelf @ place([-0.2, 1.25, 0.15]), 0.12, "sky", 3.3)
    for k in range(14):  # balls and blocks on the rug
        p = [4.35 + 0.085 * ((k * 5) % 13), 0.0, 2.75 + 0.075 * ((k * 7) % 12)]
        color = ("brick_red", "lemon", "sky", "leaf_light", "orange")[k % 5]
        if k % 2:
            r = 0.05 + 0.012 * (k % 4)
            b.add(bumpy_sphere(r, 8, float(k), 0.05), color, place(p) @ place([0, r + 0.014, 0]))
        else:
            block = soft_box((0.08, 0.08, 0.08), (5, 5, 5), power=9, bulge=0.05)
            b.add(block, color, place(p) @ place([0, 0.054, 0], yaw=31 * k))
    decor.basket(b, place([4.0, 0, 4.1]), 0.24, "rug_beige")
    b.add(cylinder(0.19, 0.4, 24), "sky", place([5.6, 0, 4.05]))
    _pendant(b, 4.9, 3.2, 0.5, "brick_red")
    _table_lamp(b, shelf @ place([0.25, 1.25, 0.15]), "lemon")
