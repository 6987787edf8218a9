"""Small things: vases, bowls, crockery, plants, lamps, pictures, blinds, screens.

Each stands on y = 0 around the origin unless it says otherwise.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from viscache.scenes.builder import Builder
from viscache.scenes.palette import BOOK_COLORS
from viscache.scenes.shapes import (
    Array,
    bumpy_sphere,
    knots,
    leaf,
    place,
    revolve,
    rod,
    soft_box,
    sphere,
    surface,
    tube,
)

_Border = Callable[[Array, int], Array]

VASES = (
    knots("0.05 0, 0.09 0.05, 0.11 0.14, 0.07 0.24, 0.035 0.3, 0.045 0.34, 0.05 0.345"),
    knots("0.06 0, 0.065 0.08, 0.075 0.2, 0.05 0.3, 0.055 0.4, 0.07 0.42"),
    knots("0.07 0, 0.13 0.06, 0.14 0.12, 0.1 0.19, 0.055 0.21, 0.06 0.235"),
    knots("0.04 0, 0.045 0.02, 0.025 0.05, 0.06 0.16, 0.085 0.28, 0.08 0.3"),
)


def vase(b: Builder, at: Array, kind: int, color: str, *, flutes: int = 0) -> None:
    """One of four turned vases, 0.23 to 0.42 m high, open and hollow at the top."""
    outer = VASES[kind % len(VASES)]
    inner = np.array(
        [[outer[-1, 0] - 0.012, outer[-1, 1]], [outer[-2, 0] * 0.8, outer[-1, 1] * 0.8]]
    )
    depth = 0.05 if flutes else 0.0
    shape = revolve(np.concatenate([outer, inner]), 26, 26, flutes=(flutes, depth))
    b.add(shape, color, at)


def bouquet(b: Builder, at: Array, rng: np.random.Generator, color: str, n: int = 14) -> None:
    """Stems with blossoms and leaves rising from y = 0 (put it into a vase's neck)."""
    angle, reach = rng.uniform(0, 360, n), rng.uniform(0.05, 0.2, n)
    for k in range(n):
        h = rng.uniform(0.2, 0.4)
        stem = tube([[0, -0.15, 0], [0, 0.06, 0.01], [0, h, reach[k]]], 0.0025, 4, 6)
        here = at @ place(yaw=angle[k])
        b.add(stem, "leaf", here, optional=k > 3)
        part = sphere(0.02, 3, _petals)
        b.add(part, color, here @ place([0, h + 0.012, reach[k]]), optional=k > 3)
        shape = leaf(0.09, 0.03)
        b.add(
            shape, "leaf_light", here @ place([0, h * 0.5, reach[k] * 0.4], yaw=40), optional=True
        )


def _petals(p: Array) -> Array:
    angle = np.arctan2(p[:, 2], p[:, 0])
    open_: Array = p * (1.1 + 0.4 * np.cos(6 * angle) * (1 - (p[:, 1] / 0.02) ** 2))[:, None]
    return open_


def bowl(b: Builder, at: Array, radius: float, color: str, *, fruit: bool = False) -> None:
    """Bowl of `radius`, optionally with fruit."""
    r = radius
    profile = [
        [0.35 * r, 0],
        [0.4 * r, 0.03 * r],
        [0.8 * r, 0.28 * r],
        [r, 0.55 * r],
        [0.98 * r, 0.57 * r],
    ]
    profile += [[0.93 * r, 0.54 * r], [0.7 * r, 0.3 * r], [0.3 * r, 0.12 * r], [0.03 * r, 0.1 * r]]
    b.add(revolve(profile, 28, 22, caps=(True, True), dome=0.05), color, at)
    if fruit:
        kinds = ("orange", "apple", "lemon", "apple", "orange", "leaf_light", "lemon")
        for k, name in enumerate(kinds):
            ring, turn = (0.42 * r, k * 60.0) if k < 6 else (0.0, 0.0)
            spot = place(
                [
                    ring * np.sin(np.radians(turn)),
                    0.40 * r if k < 6 else 0.70 * r,
                    ring * np.cos(np.radians(turn)),
                ]
            )
            size = 0.23 * r * (1 + 0.1 * np.sin(5.0 * k))
            b.add(bumpy_sphere(size, 6, float(k), 0.03), name, at @ spot)


def crockery(b: Builder, at: Array, color: str = "porcelain") -> None:
    """A place setting: plate, smaller plate, cup with handle, fork and knife."""
    m = b.paint(color)
    rim = knots("0.06 0, 0.08 0.004, 0.125 0.018, 0.132 0.02, 0.124 0.022, 0.08 0.009, 0.01 0.008")
    b.add(revolve(rim, 26, 12, caps=(True, True), dome=0.02), m, at)
    shape = revolve(rim * [0.72, 1], 22, 10, caps=(True, True), dome=0.02)
    b.add(shape, m, at @ place([0, 0.011, 0]), optional=True)
    cup(b, at @ place([0.17, 0, -0.14], yaw=35), color)
    for x, w in ((-0.165, 0.022), (0.165, 0.016)):
        bar = soft_box((w, 0.004, 0.2), (2, 1, 7), power=4, bulge=0.1, warp=_cutlery)
        b.add(bar, "steel", at @ place([x, 0.006, 0]), optional=True)


def _cutlery(p: Array) -> Array:
    z = p[:, 2] / 0.1
    return p * np.stack([0.45 + 0.55 * np.clip(z, 0, 1), 1 + 0 * z, 1 + 0 * z], 1) + np.stack(
        [0 * z, 0.004 * z * z, 0 * z], 1
    )


def cup(b: Builder, at: Array, color: str) -> None:
    """Cup with a handle, 0.08 m high."""
    m = b.paint(color)
    profile = knots(
        "0.025 0, 0.028 0.005, 0.04 0.04, 0.042 0.08, 0.039 0.081, 0.036 0.04, 0.006 0.012"
    )
    b.add(revolve(profile, 18, 16, caps=(True, True), dome=0.05), m, at)
    handle = [[0.038, 0.066, 0], [0.062, 0.062, 0], [0.064, 0.035, 0], [0.036, 0.022, 0]]
    b.add(tube(handle, 0.0045, 6, 10), m, at, optional=True)


def bottle(b: Builder, at: Array, color: str) -> None:
    """Bottle, 0.3 m high."""
    profile = knots(
        "0.033 0, 0.037 0.01, 0.037 0.17, 0.03 0.205, 0.014 0.235, 0.013 0.285, 0.015 0.3"
    )
    b.add(revolve(profile, 18, 18, caps=(True, True)), color, at)


def book_pile(b: Builder, at: Array, rng: np.random.Generator, n: int = 5) -> None:
    """Books lying on each other."""
    y = 0.0
    for _ in range(n):
        thick, x, z = rng.uniform(0.018, 0.045), rng.uniform(0.14, 0.22), rng.uniform(0.2, 0.29)
        spot = place(
            [rng.uniform(-0.01, 0.01), y + thick / 2, rng.uniform(-0.01, 0.01)],
            yaw=rng.uniform(-25, 25),
        )
        shape = soft_box((x, thick, z), (4, 3, 4), power=22, bulge=0.04)
        b.add(shape, str(rng.choice(BOOK_COLORS)), at @ spot, optional=True)
        y += thick * 0.985


def candlestick(b: Builder, at: Array, height: float = 0.3) -> None:
    """Turned brass stick with a candle."""
    h = height * 0.6
    profile = knots(
        "0.05 0, 0.05 0.03, 0.02 0.08, 0.012 0.3, 0.025 0.4, 0.012 0.5, 0.014 0.9, 0.03 1.0"
    )
    b.add(revolve(profile * [1, h], 16, 22, caps=(True, True)), "brass", at)
    shape = revolve(
        [[0.011, h], [0.0105, height * 0.97], [0.004, height]], 10, 6, caps=(True, True)
    )
    b.add(shape, "cream", at)


def ornament(b: Builder, at: Array, radius: float, color: str, phase: float) -> None:
    """Bumpy ceramic ball on a small ring."""
    b.add(bumpy_sphere(radius, 14, phase, 0.07), color, at @ place([0, radius * 1.03, 0]))
    ring = revolve(
        [[0.5 * radius, 0], [0.55 * radius, 0.1 * radius], [0.42 * radius, 0.2 * radius]], 18, 5
    )
    b.add(ring, "walnut", at)


def plant(
    b: Builder,
    at: Array,
    rng: np.random.Generator,
    *,
    height: float = 1.5,
    leaves: int = 160,
    pot: str = "terracotta",
) -> None:
    """Potted plant with arching stems and broad leaves."""
    r = 0.13 + 0.05 * height
    profile = np.array(
        [[0.62, 0], [0.7, 0.05], [0.92, 0.9], [1.04, 0.93], [1.04, 1.12], [0.9, 1.12], [0.86, 1.0]]
    ) * [r, 1.25 * r]
    b.add(revolve(profile, 26, 18), pot, at)
    earth = revolve(
        [[0.88 * r, 1.26 * r], [0.5 * r, 1.29 * r], [0.1 * r, 1.31 * r]],
        16,
        5,
        caps=(False, True),
        flutes=(5, 0.03),
    )
    b.add(earth, "soil", at)
    n = max(3, leaves // 14)
    foot = 1.25 * r
    spots: list[Array] = []
    for k in range(n):
        turn, reach = 360 * ((k * 0.618) % 1), rng.uniform(0.12, 0.42) * height * 0.6
        top = foot + (height - foot) * rng.uniform(0.55, 1.0)
        path = np.array(
            [[0, foot, 0.03], [0, foot + 0.55 * (top - foot), 0.3 * reach], [0, top, reach]]
        )
        here = place(yaw=turn)
        b.add(tube(path, [0.009, 0.006, 0.003], 5, 9), "leaf", at @ here, optional=k > 5)
        for j in range(leaves // n):
            t = 0.35 + 0.65 * (j + rng.uniform(0, 1)) / (leaves // n)
            y = foot + (top - foot) * (0.25 + 0.75 * t) if t > 0.3 else foot
            point = [0, y, reach * (0.12 + 0.88 * t**1.4)]
            spots.append(
                here
                @ place(
                    point,
                    yaw=rng.uniform(-130, 130),
                    pitch=rng.uniform(-35, 25),
                    scale=rng.uniform(0.7, 1.25),
                )
            )
    blade = leaf(0.12 + 0.07 * height, 0.045 + 0.03 * height, 0.4, 4, 6)
    half = len(spots) // 3
    b.add(blade, "leaf_light", at @ np.stack(spots[:half]), optional=True)
    b.add(blade, "leaf", at @ np.stack(spots[half:]), optional=True)


def pleated_shade(
    b: Builder, at: Array, low: float, high: float, height: float, color: str = "shade"
) -> None:
    """Lamp shade of pleated cloth, open at both ends, its lower rim at y = 0."""
    shape = revolve(
        [[low, 0], [0.5 * (low + high) * 1.02, height / 2], [high, height]],
        64,
        6,
        caps=(False, False),
        flutes=(24, 0.02),
    )
    b.add(shape, color, at)


def floor_lamp(b: Builder, at: Array, height: float = 1.65, metal: str = "black_metal") -> None:
    """Standing lamp; the bulb's place is at `height` - 0.1."""
    stand = [
        [0.15, 0],
        [0.15, 0.015],
        [0.06, 0.03],
        [0.014, 0.06],
        [0.012, height * 0.5],
        [0.02, height * 0.52],
        [0.012, height * 0.54],
        [0.01, height - 0.22],
    ]
    b.add(revolve(stand, 18, 40, caps=(True, True)), metal, at)
    pleated_shade(b, at @ place([0, height - 0.27, 0]), 0.24, 0.17, 0.3)
    for turn in (0, 120, 240):
        shape = rod([0, height - 0.225, 0.005], [0, height - 0.235, 0.232], 0.003, 4)
        b.add(shape, metal, at @ place(yaw=turn), optional=True)


def table_lamp(b: Builder, at: Array, color: str) -> None:
    """Ceramic table lamp, 0.52 m high; the bulb's place is at 0.42."""
    foot = knots("0.06 0, 0.075 0.01, 0.1 0.08, 0.08 0.17, 0.03 0.22, 0.02 0.25, 0.01 0.29")
    b.add(revolve(foot, 22, 20, caps=(True, True), flutes=(9, 0.03)), color, at)
    pleated_shade(b, at @ place([0, 0.29, 0]), 0.17, 0.11, 0.23)
    for turn in (0, 120, 240):
        shape = rod([0, 0.288, 0], [0, 0.3, 0.165], 0.003, 4)
        b.add(shape, "brass", at @ place(yaw=turn), optional=True)


def pendant(b: Builder, at: Array, drop: float, color: str = "black_metal") -> None:
    """Lamp hanging from the ceiling at the origin; its shade's rim is `drop` below.

    The bulb's place is 0.08 m above the rim, in the open shade (0.2 m radius).
    """
    shape = revolve([[0.05, -0.03], [0.055, -0.01], [0.05, 0.0]], 12, 4, caps=(True, False))
    b.add(shape, color, at)
    b.add(rod([0, -drop + 0.2, 0], [0, -0.02, 0], 0.004, 5), color, at)
    shade = [[0.2, 0], [0.19, 0.05], [0.12, 0.14], [0.05, 0.19], [0.03, 0.24], [0.012, 0.25]]
    b.add(revolve(shade, 30, 16, caps=(False, True)), color, at @ place([0, -drop, 0]))


def picture(b: Builder, at: Array, size: tuple[float, float], colors: str, phase: float) -> None:
    """Framed relief of hills, its back at z = 0, centred; `colors` from the bottom upwards."""
    x, y = size
    wood = b.paint("walnut")
    for side in (-1, 1):
        flat = soft_box((x + 0.06, 0.045, 0.03), (6, 2, 2), power=8, bulge=0.1)
        b.add(flat, wood, at @ place([0, side * (y / 2), 0.016]))
        upright = soft_box((0.045, y + 0.03, 0.03), (2, 6, 2), power=8, bulge=0.1)
        b.add(upright, wood, at @ place([side * (x / 2), 0, 0.016]))
    names = colors.split()
    for k, name in enumerate(names):

        def border(u: Array, i: int) -> Array:
            hills = 0.09 * np.sin(6 * u + phase + 2.1 * i) + 0.04 * np.sin(13 * u + 3 * phase + i)
            return np.clip(i / len(names) + (0 < i < len(names)) * hills, 0, 1)

        def relief(u: Array, v: Array, k: int = k, border: _Border = border) -> Array:
            low, high = border(u, k), border(u, k + 1)
            w = low + (high - low) * v
            z = 0.012 + 0.004 * np.sin(9 * u + phase + 3 * np.sin(7 * w)) * np.sin(
                11 * w + 2 * phase
            )
            return np.stack([(u - 0.5) * x, (w - 0.5) * y, z], axis=-1)

        b.add(surface(relief, 16, 16 / len(names)), name, at)


def basket(b: Builder, at: Array, radius: float, color: str) -> None:
    """Wicker basket of woven canes."""
    profile = [[0.8 * radius, 0.0], [0.95 * radius, 0.6 * radius], [radius, 1.1 * radius]]
    b.add(revolve(profile, 30, 10, flutes=(15, 0.02)), color, at)
    angle = np.linspace(0, 2 * np.pi, 25)
    for k in range(9):
        r = radius * (0.82 + 0.2 * k / 8) * (1 + 0.02 * (-1) ** k * np.cos(12 * angle))
        hoop = np.stack(
            [r * np.sin(angle), 0 * r + radius * (0.06 + 1.05 * k / 8), r * np.cos(angle)], 1
        )
        shape = tube(hoop, 0.035 * radius, 5, 44, caps=(False, False))
        b.add(shape, color, at, optional=k % 2 == 1)
