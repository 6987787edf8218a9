"""Cars, bicycles and their tyres: each stands on y = 0, its length along x, its front at +x."""

from __future__ import annotations

import numpy as np

from viscache.scenes.builder import Builder
from viscache.scenes.shapes import Array, place, revolve, rod, soft_box, sphere, surface, tube

CAR_LENGTH, CAR_WIDTH, CAR_HEIGHT = 4.3, 1.74, 1.43
WHEEL_RADIUS, WHEELBASE = 0.32, 2.6

# Along a car from its tail (0) to its nose (1): upper and lower edge and half width of the body.
ALONG = (0.0, 0.03, 0.12, 0.35, 0.66, 0.74, 0.93, 0.985, 1.0)
UPPER = (0.66, 0.84, 0.93, 0.95, 0.93, 0.89, 0.74, 0.62, 0.5)
LOWER = (0.45, 0.34, 0.24, 0.2, 0.2, 0.2, 0.22, 0.27, 0.36)
HALF_WIDTH = (0.62, 0.76, 0.84, 0.87, 0.87, 0.86, 0.82, 0.7, 0.58)
# Of the cabin: x in metres, and the height of its roof.
CABIN_X = (-1.78, -1.5, -1.15, -0.5, 0.1, 0.42, 0.8, 1.12)
CABIN_Y = (0.9, 1.12, 1.33, CAR_HEIGHT, 1.42, 1.34, 1.1, 0.88)

TYRE = [[0.2, -0.09], [0.27, -0.1], [0.31, -0.085], [0.32, -0.03], [0.32, 0.03], [0.31, 0.085]]
TYRE += [[0.27, 0.1], [0.2, 0.09]]


def car(b: Builder, at: Array, body: int) -> None:
    """Hatchback, 4.3 x 1.74 x 1.43 m, painted with the material `body`."""
    window = b.glossy("windows", (0.03, 0.035, 0.04), 0.06, 0.2)
    trim, steel = b.paint("black_metal"), b.paint("steel")
    b.add(surface(_body, 44, 60, closed=True, caps=(True, True)), body, at)
    b.add(surface(_cabin, 40, 36, closed=True, caps=(True, True)), window, at)
    roof = soft_box((1.35, 0.07, 1.16), (12, 3, 12), power=5, bulge=0.35)
    b.add(roof, body, at @ place([-0.42, CAR_HEIGHT - 0.02, 0]))
    for side in (-1, 1):
        for foot, top in (
            ((1.08, 0.9), (0.3, 1.39)),
            ((-0.45, 0.93), (-0.5, 1.4)),
            ((-1.72, 0.93), (-1.05, 1.37)),
        ):
            post = [[foot[0], foot[1], side * 0.76], [top[0], top[1], side * 0.565]]
            b.add(rod(post[0], post[1], 0.035, 8), body, at)
        b.add(rod([-1.6, 0.5, side * 0.87], [1.4, 0.5, side * 0.87], 0.025, 7), trim, at)
        for x in (-0.65, 0.4):
            b.add(rod([x, 0.78, side * 0.875], [x + 0.14, 0.78, side * 0.875], 0.014, 6), trim, at)
        mirror = soft_box((0.1, 0.13, 0.2), (6, 6, 6), power=3)
        b.add(mirror, body, at @ place([0.72, 0.98, side * 0.95], yaw=10 * side))
        lamp = sphere(0.1, 6)
        b.add(lamp, steel, at @ place([1.96, 0.63, side * 0.58], scale=[1, 0.8, 1.5]))
        tail = soft_box((0.08, 0.22, 0.2), (4, 6, 5), power=4)
        b.add(tail, "brick_red", at @ place([-2.07, 0.74, side * 0.62]))
    for x, y in ((2.07, 0.4), (-2.07, 0.47)):
        bumper = [[0, 0, -0.62], [0.06 * np.sign(x), 0, -0.3], [0.06 * np.sign(x), 0, 0.3]]
        b.add(tube([*bumper, [0, 0, 0.62]], 0.055, 9, 18), trim, at @ place([x, y, 0]))
    spots = [[x, WHEEL_RADIUS, z] for x in (-WHEELBASE / 2, WHEELBASE / 2) for z in (-0.76, 0.76)]
    wheel(b, at @ place(spots, pitch=[-90, 90, -90, 90]))


def _around(u: Array, power: float) -> tuple[Array, Array]:
    """Cosine and sine on a rounded square."""
    c, s = np.cos(2 * np.pi * u), np.sin(2 * np.pi * u)
    return np.sign(c) * np.abs(c) ** power, np.sign(s) * np.abs(s) ** power


def _body(u: Array, v: Array) -> Array:
    c, s = _around(u, 0.45)
    x = (v - 0.5) * CAR_LENGTH
    from_axle = x - np.where(x < 0, -WHEELBASE / 2, WHEELBASE / 2)
    arch = 0.46 * np.sqrt(np.maximum(1 - (from_axle / 0.39) ** 2, 0))
    low, high = np.interp(v, ALONG, LOWER) + arch, np.interp(v, ALONG, UPPER)
    y = low + (0.5 + 0.5 * s) * (high - low)
    crease = 1 - 0.07 * np.maximum(s, 0) - 0.05 * np.maximum(-s, 0)
    return np.stack([x + 0 * u, y, np.interp(v, ALONG, HALF_WIDTH) * crease * c], axis=-1)


def _cabin(u: Array, v: Array) -> Array:
    c, s = _around(u, 0.4)
    x = CABIN_X[0] + v * (CABIN_X[-1] - CABIN_X[0])
    top = np.interp(x, CABIN_X, CABIN_Y)
    y = 0.84 + (0.5 + 0.5 * s) * (top - 0.84)
    return np.stack([x + 0 * u, y, (0.78 - 0.36 * (y - 0.84)) * c], axis=-1)


def wheel(b: Builder, at: Array) -> None:
    """Wheels with five spokes around the local y axis; their outer sides look to +y."""
    at = at.reshape(-1, 4, 4)
    tyre = revolve(TYRE, 56, 18, caps=(False, False), flutes=(28, 0.012))
    b.add(tyre, "black_metal", at)
    steel = b.glossy("rims", (0.3, 0.31, 0.32), 0.4, 0.3)
    ring = revolve(
        [[0.205, -0.08], [0.19, 0.0], [0.2, 0.07], [0.212, 0.085]], 36, 10, caps=(False, False)
    )
    b.add(ring, steel, at)
    hub = revolve([[0.075, 0.03], [0.07, 0.06], [0.03, 0.075]], 18, 6, caps=(True, True))
    b.add(hub, steel, at)
    for turn in range(0, 360, 72):
        spoke = soft_box((0.06, 0.03, 0.15), (4, 3, 5), power=4)
        b.add(spoke, steel, at @ place(yaw=turn) @ place([0, 0.05, 0.13]))


def tyre_stack(b: Builder, at: Array, n: int) -> None:
    """`n` tyres without rims lying on each other."""
    tyre = revolve(TYRE, 56, 18, caps=(False, False), flutes=(28, 0.012))
    k = np.arange(n)
    spots = np.stack([0.02 * np.sin(2.0 * k), 0.1 + 0.2 * k, 0.02 * np.cos(3.0 * k)], -1)
    b.add(tyre, "black_metal", at @ place(spots, yaw=40.0 * k))


def bicycle(b: Builder, at: Array, color: str) -> None:
    """Bicycle, 1.75 m long and 1.05 m high, upright in the plane z = 0."""
    frame, dark, steel = b.paint(color), b.paint("black_metal"), b.paint("steel")
    rear, front, crank = (-0.52, 0.34), (0.53, 0.34), (-0.1, 0.29)
    seat, head = (-0.26, 0.82), (0.36, 0.88)
    for start, end in (
        (crank, seat),
        (crank, (0.4, 0.78)),
        (seat, head),
        (seat, rear),
        (crank, rear),
        ((0.37, 0.9), front),
    ):
        b.add(rod([*start, 0], [*end, 0], 0.016, 8), frame, at)
    angle = np.linspace(0, 2 * np.pi, 33)
    for x, y in (rear, front):
        rim = np.stack([x + 0.32 * np.sin(angle), y + 0.32 * np.cos(angle), 0 * angle], 1)
        b.add(tube(rim, 0.019, 8, 64, caps=(False, False)), dark, at)
        _spokes(b, at @ place([x, y, 0]), steel)
    saddle = soft_box((0.27, 0.07, 0.15), (8, 4, 6), power=3)
    b.add(saddle, dark, at @ place([-0.28, 0.93, 0]))
    b.add(rod([*seat, 0], [-0.28, 0.92, 0], 0.012, 7), steel, at)
    bar = [[0.3, 1.02, -0.29], [0.4, 1.04, -0.22], [0.36, 1.02, 0], [0.4, 1.04, 0.22]]
    b.add(tube([*bar, [0.3, 1.02, 0.29]], 0.013, 7, 24), dark, at)
    b.add(rod([*head, 0], [0.35, 1.03, 0], 0.014, 7), steel, at)
    gear = revolve([[0.09, -0.004], [0.095, 0.0], [0.09, 0.004]], 24, 3, caps=(True, True))
    b.add(gear, steel, at @ place([*crank, 0.03], pitch=90))
    for side in (-1, 1):
        pedal = [crank[0] + 0.12 * side, crank[1] - 0.12 * side, 0.06 * side]
        b.add(rod([*crank, 0.06 * side], pedal, 0.009, 6), steel, at)
        plate = soft_box((0.09, 0.02, 0.07), (4, 2, 4), power=6)
        b.add(plate, dark, at @ place(np.add(pedal, [0, 0, 0.04 * side])))


def _spokes(b: Builder, at: Array, material: int) -> None:
    b.add(rod([0, 0, -0.05], [0, 0, 0.05], 0.02, 8), material, at)
    spoke = rod([0, 0.015, 0.03], [0.06, 0.31, 0], 0.0016, 4)
    turns = np.arange(0, 360, 20.0)
    b.add(spoke, material, at @ place(roll=turns), optional=True)
    b.add(spoke, material, at @ place(yaw=180) @ place(roll=turns + 10), optional=True)
