"""The furnished room: 10 x 4 x 10 m, with many occluders below its ceiling lamps."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from viscache.scenes import decor, fixtures, furniture, walls
from viscache.scenes.builder import Builder
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import (
    Array,
    bumpy_sphere,
    curtain,
    cylinder,
    place,
    quad,
    revolve,
    rod,
    tube,
)

SEED = 20130
LEAST = 100
TOTAL_INTENSITY = 75.0  # W/sr over all point lights
PENDANTS = ((-2.2, -1.0), (-1.0, -1.0), (2.4, -1.7))
HIGH_PARTS = ((-4.2, 2.6), (4.3, -4.3))  # tall plants


@scene(shown={"lights": 24})
def room(
    triangles: Annotated[int, Range(LEAST, MOST_TRIANGLES)] = 200_000,
    lights: Annotated[int | None, Range(0, 100_000)] = None,
    panels: bool = False,
    specular: bool = False,
) -> Builder:
    """Furnished closed room, 10 x 4 x 10 m, with point lights under the ceiling.

    Parameters
    ----------
    triangles : int
        Placed triangles; the scene has this many to 1.25 times as many. At least 100.
    lights : int, optional
        Number of point lights, evenly distributed under the ceiling: 24, or none with `panels`.
    panels : bool
        Add six light panels (area lights) in the ceiling.
    specular : bool
        Make some objects glossy, one vase of glass and one picture a mirror.
    """
    count = (0 if panels else 24) if lights is None else lights
    b, rng = Builder("room"), np.random.Generator(np.random.PCG64(SEED))
    if specular:
        b.glossy("walnut", (0.27, 0.16, 0.09), 0.05, 0.15)
        b.glossy("porcelain", (0.75, 0.75, 0.73), 0.05, 0.08)
        b.glossy("brass", (0.30, 0.22, 0.08), 0.5, 0.2)
    _shell(b)
    _dining(b, rng)
    _lounge(b, rng)
    _shelves(b, rng)
    _corners(b, rng)
    _overhead(b)
    if specular:
        glass = decor.VASES[1]
        b.add(revolve(glass, 40, 40), b.glass("glass"), place([-0.35, 0.75, -0.85]))
        frame = [[-0.55, -0.8, 0], [0.55, -0.8, 0], [0.55, 0.8, 0], [-0.55, 0.8, 0]]
        b.add(quad(*frame), b.mirror("mirror"), place([-4.985, 1.75, 0.2], yaw=90))
    if panels:
        _panels(b)
    b.fit(triangles)
    for p in light_spots(count):
        b.point_light(p, TOTAL_INTENSITY / count * np.array([1.0, 0.93, 0.82]))
    b.camera((0.2, 2.0, 4.8), (0.0, 1.2, -1.0), 63.0, name="door")
    b.camera((-4.3, 1.7, 4.2), (1.2, 0.9, -2.0), 55.0, name="corner")
    return b


def light_spots(n: int) -> Array:
    """`n` evenly distributed positions (n, 3), 3.25 to 3.8 m high, away from hanging objects."""
    found: list[Array] = []
    k = 0
    while len(found) < n:
        k += 1
        # The R3 sequence: additive recurrence by powers of the root of x^4 = x + 1.
        u = np.mod(0.5 + k * 1.2207440846057596 ** -np.arange(1.0, 4.0), 1.0)
        p = np.array([-4.6 + 9.2 * u[0], 3.25 + 0.55 * u[2], -4.4 + 8.8 * u[1]])
        hanging = [np.hypot(p[0] - x, p[2] - z) for x, z in PENDANTS + CABLES]
        tall = [np.hypot(p[0] - x, p[2] - z) for x, z in HIGH_PARTS]
        if min(hanging) > 0.15 and min(tall) > 0.5:
            found.append(p)
    return np.array(found).reshape(-1, 3)


def _shell(b: Builder) -> None:
    x, y, z = 5.0, 4.0, 5.0
    walls.shell(b, (x, y, z), "floor_oak", ("sage", "plaster", "plaster", "plaster"))
    ring = [[-x, 0.05, -z], [x, 0.05, -z], [x, 0.05, z], [-x, 0.05, z], [-x, 0.05, -z]]
    fixtures.skirting(b, [[ring[k], ring[k + 1]] for k in range(4)])
    cornice = np.add(ring, [0, y - 0.1, 0])
    fixtures.skirting(b, [[cornice[k], cornice[k + 1]] for k in range(4)])


def _dining(b: Builder, rng: np.random.Generator) -> None:
    center = place([-1.6, 0.0, -1.0])
    furniture.rug(b, center, (3.6, 2.6), "rug_beige")
    furniture.table(b, center, (2.2, 1.0), "walnut")
    seats = [
        (-0.7, 0.78, 180),
        (0.0, 0.8, 174),
        (0.7, 0.78, 186),
        (-0.7, -0.78, 0),
        (0.05, -0.8, 8),
    ]
    seats += [(0.72, -0.77, -5), (-1.42, 0.02, 90), (1.5, 0.1, -112)]
    spots = place([[x, 0.012, z] for x, z, _ in seats], yaw=[turn for *_, turn in seats])
    furniture.chair(b, center @ spots, "oak", cushion="terracotta")
    top = center @ place([0, 0.752, 0])
    for x, z, turn in seats[:6]:
        decor.crockery(b, top @ place([x, 0, np.sign(z) * 0.3], yaw=turn - 180))
    decor.vase(b, top @ place([-0.15, 0, 0.02]), 2, "petrol", flutes=11)
    decor.bouquet(b, top @ place([-0.15, 0.2, 0.02]), rng, "mustard", 18)
    decor.bowl(b, top @ place([0.42, 0, 0.0]), 0.17, "cream", fruit=True)
    for x, h in ((-0.5, 0.34), (-0.62, 0.26), (0.78, 0.3)):
        decor.candlestick(b, top @ place([x, 0, 0.05 * np.sin(40 * x)]), h)
    decor.bottle(b, top @ place([0.18, 0, -0.12]), "forest")
    decor.bottle(b, top @ place([0.12, 0, 0.13]), "plum")


def _lounge(b: Builder, rng: np.random.Generator) -> None:
    furniture.rug(b, place([2.5, 0, -0.9], yaw=4), (3.2, 2.6), "rug_red")
    couch = place([4.25, 0.0, -1.0], yaw=-90)
    furniture.sofa(b, couch, "petrol", width=2.5, pillows="mustard rug_red linen mustard")
    furniture.throw_blanket(b, couch @ place([1.16, 0.645, 0.1]), "cream")
    for x, z, turn, pillow in ((1.35, -2.3, 35, "cream"), (1.7, 0.75, 140, "navy")):
        chair = place([x, 0, z], yaw=turn)
        furniture.sofa(b, chair, "grey_cloth", width=0.98, seats=1)
        furniture.throw_pillow(b, chair @ place([0.02, 0.65, 0.0], pitch=-20), pillow, 0.4)
    low = place([2.6, 0.012, -0.9])
    furniture.round_table(b, low, 0.52, 0.44, "oak")
    top = low @ place([0, 0.44, 0])
    decor.bowl(b, top @ place([0.1, 0, 0.16]), 0.15, "sky", fruit=True)
    decor.book_pile(b, top @ place([-0.22, 0, 0.1], yaw=25), rng, 4)
    decor.cup(b, top @ place([0.12, 0, -0.24], yaw=70), "porcelain")
    decor.cup(b, top @ place([-0.2, 0, -0.26], yaw=190), "mustard")
    decor.ornament(b, top @ place([-0.02, 0, -0.1]), 0.075, "terracotta", 1.0)
    decor.floor_lamp(b, place([4.3, 0, 0.95]), 1.7)
    decor.floor_lamp(b, place([0.55, 0, -3.2]), 1.65, "brass")


def _shelves(b: Builder, rng: np.random.Generator) -> None:
    for k in range(4):
        wood = "oak" if k % 2 == 0 else "beech"
        unit = place([-3.9 + 0.99 * k, 0, -4.97])
        furniture.bookshelf(b, unit, rng, wood=wood)
        top = unit @ place([0, 2.12, 0.15])
        if k % 2 == 0:
            decor.vase(b, top @ place([-0.2, 0, 0]), k, ("terracotta", "mustard")[k // 2], flutes=9)
            decor.ornament(b, top @ place([0.2, 0, 0]), 0.11, "porcelain", 2.0 + k)
        else:
            decor.book_pile(b, top @ place([0.1, 0, 0], yaw=90), rng, 3)
    board = place([2.4, 0, -4.95])
    furniture.cabinet(b, board, (1.9, 0.8, 0.45), "walnut", doors=3)
    decor.table_lamp(b, board @ place([-0.7, 0.8, 0.22]), "sky")
    decor.vase(b, board @ place([0.0, 0.8, 0.22]), 1, "porcelain")
    decor.bouquet(b, board @ place([0.0, 1.16, 0.22]), rng, "apple", 16)
    decor.ornament(b, board @ place([0.55, 0.8, 0.24]), 0.14, "brick_red", 5.0)
    decor.ornament(b, board @ place([0.28, 0.8, 0.3]), 0.08, "navy", 6.0)
    scenery = "forest leaf_light mustard sky"
    for x, y, w, h in ((2.0, 2.0, 0.8, 1.0), (2.95, 2.05, 0.6, 0.75)):
        decor.picture(b, place([x, y, -4.997]), (w, h), scenery, x)
    b.add(curtain(1.1, 3.3, 8, 0.05), "terracotta", place([4.25, 0.03, -4.82]))
    rail = tube([[3.6, 3.36, -4.82], [4.2, 3.365, -4.82], [4.9, 3.36, -4.82]], 0.015, 8, 10)
    b.add(rail, "brass")


def _corners(b: Builder, rng: np.random.Generator) -> None:
    decor.plant(b, place([-4.2, 0, 2.6]), rng, height=2.1, leaves=240, pot="navy")
    decor.plant(b, place([4.3, 0, -4.3 + 0.25]), rng, height=1.7, leaves=170)
    decor.plant(b, place([4.2, 0, 2.7]), rng, height=1.2, leaves=130, pot="cream")
    board = place([-4.97, 0, -2.2], yaw=90)
    furniture.cabinet(b, board, (1.6, 0.78, 0.42), "beech", doors=2)
    decor.table_lamp(b, board @ place([0.5, 0.78, 0.2]), "terracotta")
    decor.ornament(b, board @ place([-0.45, 0.78, 0.2]), 0.15, "sky", 0.4)
    decor.plant(b, board @ place([-0.05, 0.78, 0.2], scale=0.35), rng, height=1.4, leaves=90)
    decor.picture(b, place([-4.997, 1.95, -2.2], yaw=90), (1.3, 0.9), "navy petrol sky cream", 0.3)
    decor.picture(
        b, place([4.997, 2.0, -1.0], yaw=-90), (1.5, 0.9), "brick_red terracotta orange cream", 2.3
    )
    fixtures.radiator(b, place([-4.98, 0, 0.7], yaw=90), 1.2)
    furniture.desk_chair(b, place([-3.3, 0, 1.4], yaw=60), "navy")
    furniture.table(b, place([-4.2, 0, 1.05], yaw=90), (1.3, 0.65), "beech", 0.73)
    desk = place([-4.2, 0.732, 1.05], yaw=90)
    fixtures.laptop(b, desk @ place([0.05, 0, 0.06]))
    decor.book_pile(b, desk @ place([-0.42, 0, 0.0]), rng, 6)
    decor.cup(b, desk @ place([0.4, 0, 0.1]), "brick_red")
    _tea(b, rng)
    furniture.bookshelf(
        b, place([4.97, 0, 3.3], yaw=-90), rng, wood="walnut", height=1.6, shelves=4
    )
    decor.ornament(b, place([4.8, 1.53, 3.4]), 0.13, "sage", 8.0)
    # Large bumpy balls: a sculpture on a pillar and two on the floor.
    b.add(cylinder(0.2, 0.9, 24), "limestone", place([3.1, 0, 1.9]))
    b.add(bumpy_sphere(0.3, 22, 0.7), "limestone", place([3.1, 1.18, 1.9]))
    b.add(bumpy_sphere(0.24, 20, 3.0), "mustard", place([0.3, 0.235, 0.3]))
    b.add(bumpy_sphere(0.17, 16, 4.0), "rose_wall", place([0.75, 0.165, 0.05]))


def _tea(b: Builder, rng: np.random.Generator) -> None:
    """Round table with three chairs near the camera, a basket and books beside it."""
    center = place([-1.0, 0.0, 1.9], yaw=-20)
    furniture.rug(b, center, (2.7, 2.3), "navy")
    furniture.round_table(b, center @ place([0, 0.012, 0]), 0.52, 0.74, "oak")
    turns = np.array([20.0, 150.0, 262.0])
    out = np.stack([np.sin(np.radians(turns)), 0 * turns, np.cos(np.radians(turns))], 1)
    spots = place(0.72 * out + [0, 0.012, 0], yaw=turns + 180 + np.array([0, 12, -8]))
    furniture.chair(b, center @ spots, "beech", cushion="sage")
    top = center @ place([0, 0.752, 0])
    decor.vase(b, top, 3, "rose_wall")
    decor.bouquet(b, top @ place([0, 0.28, 0]), rng, "lemon", 12)
    for turn, color in zip(turns, ("sky", "mustard", "porcelain"), strict=True):
        decor.crockery(b, top @ place(yaw=turn) @ place([0.0, 0, 0.34]), color)
    basket = place([1.5, 0, 2.35])
    decor.basket(b, basket, 0.27, "rug_beige")
    for k, color in enumerate(("sky", "brick_red", "lemon", "forest")):
        spot = basket @ place([0.1 * np.sin(1.6 * k), 0.27 + 0.03 * (k % 2), 0.1 * np.cos(1.6 * k)])
        b.add(bumpy_sphere(0.085, 8, 1.3 * k), color, spot)
    decor.book_pile(b, place([2.05, 0, 2.5], yaw=30), rng, 7)


# Where the slatted canopy hangs from the ceiling.
CABLES = tuple((x, z) for x in (-3.6, -1.2, 1.2, 3.6) for z in (-2.6, 1.2))


def _overhead(b: Builder) -> None:
    fixtures.slats(b, place([0, 2.8, -0.7]), 22, 0.2, (0.06, 0.09, 4.6), "beech", 0.012)
    for z in (-2.6, 1.2):
        bearer = rod([-3.9, 2.855, z], [3.9, 2.855, z], 0.02, 8)
        b.add(bearer, "black_metal")
    for x, z in CABLES:
        b.add(rod([x, 2.85, z], [x, 4.0, z], 0.004, 4), "black_metal")
    for x, z in PENDANTS:
        decor.pendant(b, place([x, 4.0, z]), 2.1 if x < 2 else 2.0, "brass")


def _panels(b: Builder) -> None:
    material = b.diffuse("panel", (0.5, 0.5, 0.5))
    for x in (-3.0, 0.0, 3.0):
        for z in (-2.4, 2.2):
            corner = [[-0.6, 0, -0.3], [0.6, 0, -0.3], [0.6, 0, 0.3], [-0.6, 0, 0.3]]
            b.add(quad(*corner), material, place([x, 3.99, z]), emission=(14.0, 13.2, 12.0))
