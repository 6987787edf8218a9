"""What fills a garage: pipes, racks, crates, barrels, tools.

Each stands on y = 0 around the origin unless it says otherwise.
"""

from __future__ import annotations

import numpy as np

from viscache.scenes import decor, fixtures
from viscache.scenes.builder import Builder
from viscache.scenes.palette import COLORS
from viscache.scenes.shapes import (
    Array,
    cylinder,
    knots,
    place,
    revolve,
    rod,
    soft_box,
    surface,
    tube,
)

TIN_COLORS = ("brick_red", "navy", "forest", "mustard", "steel", "sky")


def pipes(b: Builder, length: float, height: float, depth: float) -> None:
    """Ducts, pipes, a cable tray and lamps under the ceiling of a room from 0 to its sizes."""
    steel, copper = b.paint("steel"), b.paint("terracotta")
    duct = np.linspace([0.1, height - 0.45, 0.6], [length - 0.2, height - 0.45, 0.6], 5)
    b.add(tube(duct, 0.2, 26, 120), steel)
    for x in np.arange(0.8, length, 1.2):
        ring = revolve(
            [[0.2, -0.03], [0.225, -0.02], [0.225, 0.02], [0.2, 0.03]], 30, 6, caps=(False, False)
        )
        b.add(ring, steel, place([x, height - 0.45, 0.6], roll=90))
    for k, z in enumerate((depth - 0.3, depth - 0.45, depth - 0.56)):
        y, end = height - 0.38 - 0.02 * k, length - 0.3 - 0.25 * k
        path = [[0.1, y, z], [0.5 * length, y - 0.02, z], [end - 0.2, y, z]]
        drop = [[end, y - 0.05, z], [end, y - 0.4, z], [end, 0.05, z]]
        b.add(tube([*path, *drop], 0.045 - 0.01 * k, 12, 110), copper if k else steel)
    for x in np.arange(1.2, length - 1, 2.4):
        hanger = [[x, height - 0.27, depth - 0.2], [x, height - 0.46, depth - 0.3]]
        b.add(tube([*hanger, [x, height - 0.44, depth - 0.6]], 0.012, 6, 10), steel, optional=True)
    _tray(b, length, height)
    fixture = soft_box((1.3, 0.07, 0.14), (14, 3, 5), power=6, bulge=0.1)
    spots = [[x, height - 0.3, z] for x in (2.4, 6.0, 9.6) for z in (2.6, 5.4)]
    b.add(fixture, "white_paint", place(spots))
    for side in (-0.035, 0.035):
        b.add(rod([-0.6, -0.045, side], [0.6, -0.045, side], 0.014, 9), "porcelain", place(spots))


def _tray(b: Builder, length: float, height: float) -> None:
    """Two rails with rungs along x, and cables in them."""
    steel, z = b.paint("steel"), 4.0
    for side in (-0.15, 0.15):
        path = np.linspace([0.1, height - 0.34, z + side], [length - 4, height - 0.34, z + side], 3)
        b.add(tube(path, 0.016, 6, 40), steel)
    x = np.arange(0.3, length - 4, 0.25)
    rung = rod([0, 0, -0.15], [0, 0, 0.15], 0.009, 6)
    b.add(rung, steel, place(np.stack([x, 0 * x + height - 0.34, 0 * x + z], -1)), optional=True)
    for k in range(5):
        t = np.linspace(0.1, length - 4.1, 24)
        sway = z - 0.1 + 0.05 * k + 0.02 * np.sin(1.7 * t + 2 * k)
        cable = np.stack([t, height - 0.318 + 0.006 * np.sin(2.3 * t + k), sway], -1)
        b.add(tube(cable, 0.011, 6, 120), ("screen", "navy")[k % 2], optional=True)


def rack(b: Builder, at: Array, rng: np.random.Generator, *, phase: int = 0) -> None:
    """Steel rack, 1 x 1.5 x 0.45 m, its back at -z, full of tins, bottles and boxes."""
    steel = b.paint("steel")
    for x in (-0.48, 0.48):
        for z in (-0.2, 0.2):
            b.add(rod([x, 0, z], [x, 1.5, z], 0.018, 7), steel, at)
    levels = (0.12, 0.58, 1.04, 1.46)
    board = soft_box((0.98, 0.025, 0.44), (10, 2, 6), power=20, bulge=0.1)
    b.add(board, steel, at @ place([[0, y, 0] for y in levels]))
    for k, y in enumerate(levels):
        row = at @ place([0, y + 0.013, 0])
        kind = (k + phase) % 3
        if kind == 0:
            _tins(b, row, rng)
        elif kind == 1:
            _boxes(b, row, rng)
        else:
            for i in range(9):
                spot = row @ place([-0.4 + 0.1 * i, 0, 0.06 * np.sin(5.0 * i)])
                decor.bottle(b, spot, ("forest", "plum", "petrol")[i % 3])


def _tins(b: Builder, at: Array, rng: np.random.Generator) -> None:
    tin = revolve(
        [[0.07, 0], [0.075, 0.01], [0.072, 0.02], [0.072, 0.17], [0.076, 0.18], [0.07, 0.19]],
        22,
        16,
        caps=(True, True),
        smooth=False,
    )
    for i in range(6):
        for z in (-0.1, 0.1):
            spot = place([-0.4 + 0.16 * i, 0, z], scale=[1, rng.uniform(0.7, 1.6), 1])
            b.add(tin, str(rng.choice(TIN_COLORS)), at @ spot, optional=True)


def _boxes(b: Builder, at: Array, rng: np.random.Generator) -> None:
    x = -0.46
    while x < 0.3:
        wide, high = rng.uniform(0.14, 0.3), rng.uniform(0.12, 0.36)
        shape = soft_box((wide, high, 0.34), (7, 7, 7), power=14, bulge=0.06)
        spot = place([x + wide / 2, high / 2, 0], yaw=rng.uniform(-4, 4))
        b.add(shape, ("beech", "oak", "linen")[int(10 * x) % 3], at @ spot)
        x += wide + 0.03


def crates(b: Builder, at: Array, rng: np.random.Generator) -> None:
    """Five slatted crates, three on the floor and two above."""
    spots = ((0, 0, -0.45), (0, 0, 0.1), (-0.55, 0, 0.0), (0.02, 0.34, -0.4), (-0.05, 0.34, 0.12))
    slat = soft_box((0.5, 0.085, 0.014), (8, 3, 2), power=10, bulge=0.1)
    post = soft_box((0.03, 0.33, 0.03), (3, 6, 3), power=8)
    for x, y, z in spots:
        here = at @ place([x, y, z], yaw=rng.uniform(-7, 7))
        for turn in range(0, 360, 90):
            side = here @ place(yaw=turn)
            b.add(slat, "beech", side @ place([[0, h, 0.25] for h in (0.05, 0.16, 0.27)]))
            b.add(post, "oak", side @ place([0.235, 0.165, 0.235]))
        floor = soft_box((0.49, 0.015, 0.49), (5, 1, 5), power=20, bulge=0.2)
        b.add(floor, "beech", here @ place([0, 0.02, 0]))


def barrel(b: Builder, at: Array, color: str) -> None:
    """Steel drum, 0.58 x 0.88 m, with two ribs."""
    profile = knots(
        "0.27 0, 0.29 0.01, 0.285 0.04, 0.28 0.27, 0.295 0.3, 0.28 0.33, "
        "0.28 0.56, 0.295 0.59, 0.28 0.62, 0.285 0.84, 0.29 0.87, 0.27 0.88"
    )
    shape = revolve(profile, 48, 44, caps=(True, True), smooth=False, dome=0.03)
    b.add(shape, b.glossy(f"{color} drum", COLORS[color], 0.05, 0.25), at)
    b.add(cylinder(0.035, 0.03, 12), "steel", at @ place([0.14, 0.885, 0.05]))


def hose(b: Builder, at: Array, turns: int = 9) -> None:
    """Garden hose coiled on the floor, 0.62 m wide."""

    def coil(u: Array, v: Array) -> Array:
        around, turn = 2 * np.pi * u, turns * v
        layer = np.mod(turn / 3, 2)  # three turns outwards, three back
        radius = 0.2 + 0.09 * np.minimum(layer, 2 - layer) + 0.011 * np.cos(around)
        y = 0.014 + 0.0075 * turn + 0.004 * np.sin(5 * turn) + 0.011 * np.sin(around)
        angle = 2 * np.pi * turn
        return np.stack([radius * np.sin(angle), y, radius * np.cos(angle)], -1)

    b.add(surface(coil, 9, 260, closed=True, caps=(True, True)), "forest", at)


def ladder(b: Builder, at: Array, height: float) -> None:
    """Ladder of round bars, its rungs along x, upright in the plane z = 0."""
    wood = b.paint("oak")
    for x in (-0.2, 0.2):
        b.add(rod([x, 0, 0], [0.85 * x, height, 0], 0.024, 9), wood, at)
    for y in np.arange(0.25, height, 0.28):
        reach = 0.2 * (1 - 0.15 * y / height)
        b.add(rod([-reach, y, 0], [reach, y, 0], 0.015, 7), wood, at)


def tools(b: Builder, at: Array) -> None:
    """On a workbench: a vice, a lamp, tins, a laptop."""
    steel, dark = b.paint("steel"), b.paint("black_metal")
    jaw = soft_box((0.16, 0.09, 0.06), (8, 6, 5), power=5)
    b.add(jaw, steel, at @ place([[-0.7, 0.12, 0.1], [-0.7, 0.12, 0.2]]))
    b.add(soft_box((0.14, 0.08, 0.22), (7, 5, 8), power=4), dark, at @ place([-0.7, 0.04, 0.12]))
    b.add(rod([-0.7, 0.1, 0.15], [-0.7, 0.1, 0.36], 0.014, 9), steel, at)
    b.add(rod([-0.8, 0.1, 0.35], [-0.6, 0.1, 0.35], 0.008, 7), steel, at)
    decor.table_lamp(b, at @ place([0.75, 0, -0.1]), "petrol")
    fixtures.laptop(b, at @ place([0.25, 0, 0.05], yaw=15))
    hammer = at @ place([-0.2, 0.02, 0.12], yaw=40)
    b.add(rod([-0.15, 0, 0], [0.15, 0, 0], 0.013, 8), "oak", hammer)
    b.add(soft_box((0.035, 0.035, 0.11), (4, 4, 7), power=4), steel, hammer @ place([0.15, 0, 0]))
    for k in range(6):
        wrench = at @ place([-0.35 + 0.05 * k, 0.008, -0.12], yaw=4 * np.sin(3.0 * k))
        b.add(rod([0, 0, -0.09], [0, 0, 0.09], 0.007, 7), steel, wrench)
        ring = revolve([[0.011, -0.005], [0.02, 0.0], [0.011, 0.005]], 16, 6, caps=(False, False))
        b.add(ring, steel, wrench @ place([0, 0, 0.1]))
