"""Furniture with real-world proportions. Each function adds one piece at the given transforms.

Pieces stand on y = 0 around the origin; seats, shelves and screens face +z.
"""

from __future__ import annotations

import numpy as np

from viscache.scenes.builder import Builder
from viscache.scenes.palette import BOOK_COLORS
from viscache.scenes.shapes import (
    Array,
    Warp,
    cloth,
    cylinder,
    place,
    revolve,
    rod,
    soft_box,
    surface,
    tube,
)

LEG = np.array([[0.016, 0], [0.02, 0.03], [0.017, 0.1], [0.024, 0.35], [0.02, 0.5]])
LEG = np.concatenate([LEG, [[0.03, 0.6], [0.032, 0.7], [0.022, 0.76], [0.03, 0.84], [0.03, 1.0]]])


def turned_leg(height: float, thickness: float = 1.0, detail: float = 1.0) -> Array:
    """Profile of a turned leg, thicker towards the top."""
    return LEG * [thickness * (0.6 + 0.4 * detail), height]


def wrinkles(depth: float, rate: float) -> Warp:
    """Warp that adds creases running across a cushion."""

    def warp(p: Array) -> Array:
        x, y, z = p.T
        crease = np.sin(rate * x + 2.2 * np.sin(0.7 * rate * z)) * np.sin(0.8 * rate * z + y * rate)
        creased: Array = p * (1 + depth * crease)[:, None]
        return creased

    return warp


def corners(x: float, z: float, y: float = 0.0) -> Array:
    """Transforms of the four corners (+-x, y, +-z)."""
    return place([[sx * x, y, sz * z] for sx in (-1, 1) for sz in (-1, 1)])


def chair(b: Builder, at: Array, wood: str = "oak", *, cushion: str | None = None) -> None:
    """Spindle-back chair, 0.46 m seat."""
    m = b.paint(wood)
    at = at.reshape(-1, 4, 4)

    def saddle(p: Array) -> Array:
        return p + np.stack([0 * p[:, 0], -0.25 * (0.03 - p[:, 0] ** 2 * 0.4), 0 * p[:, 0]], 1)

    shape = soft_box((0.46, 0.04, 0.44), (6, 2, 6), power=7, warp=saddle)
    b.add(shape, m, at @ place([0, 0.45, 0]))
    for x, z in ((-0.18, 0.17), (0.18, 0.17), (-0.17, -0.17), (0.17, -0.17)):
        lean = place([x, 0, z * 1.08], pitch=-np.sign(z) * 3.0)
        b.add(revolve(turned_leg(0.445, 0.75), 8, 10), m, at @ lean)
    for z in (-0.175, 0.175):
        b.add(rod([-0.175, 0.2, z], [0.175, 0.2, z], 0.010), m, at, optional=True)
    for x in (-0.172, 0.172):
        b.add(rod([x, 0.15, -0.175], [x, 0.15, 0.175], 0.010), m, at, optional=True)
    for x in (-0.19, 0.19):
        path = [[x, 0.45, -0.19], [x, 0.68, -0.205], [x * 1.02, 0.93, -0.28]]
        b.add(tube(path, [0.018, 0.016, 0.012], 7, 8), m, at)
    for x in np.linspace(-0.125, 0.125, 5):
        path = [[x, 0.45, -0.19], [x, 0.68, -0.225], [x, 0.9, -0.285]]
        b.add(tube(path, [0.007, 0.010, 0.006], 6, 7), m, at, optional=True)
    rail = [[-0.22, 0.92, -0.26], [0, 0.935, -0.305], [0.22, 0.92, -0.26]]
    b.add(tube(rail, [0.02, 0.028, 0.02], 8, 10), m, at)
    if cushion is not None:
        pad = soft_box((0.4, 0.05, 0.38), (6, 3, 6), power=4, bulge=0.1, warp=wrinkles(0.02, 40))
        b.add(pad, cushion, at @ place([0, 0.487, 0]))


def table(
    b: Builder, at: Array, size: tuple[float, float], wood: str, height: float = 0.75
) -> None:
    """Table with turned legs and an apron; the top is at `height`."""
    m, (x, z) = b.paint(wood), size
    top = soft_box((x, 0.035, z), (10, 2, 8), power=24, bulge=0.004)
    b.add(top, m, at @ place([0, height - 0.0175, 0]))
    legs = at.reshape(-1, 1, 4, 4) @ corners(x / 2 - 0.09, z / 2 - 0.09)
    b.add(revolve(turned_leg(height - 0.03, 1.25), 12, 18), m, legs)
    for side in (-1, 1):
        for length, turn, offset in ((x, 0, z / 2 - 0.1), (z, 90, x / 2 - 0.1)):
            rail = soft_box((length - 0.2, 0.09, 0.022), (6, 2, 2), power=14)
            shift = (
                (0, height - 0.08, side * offset)
                if turn == 0
                else (side * offset, height - 0.08, 0)
            )
            b.add(rail, m, at @ place(shift, yaw=turn))


def round_table(b: Builder, at: Array, radius: float, height: float, wood: str) -> None:
    """Pedestal table with a moulded edge."""
    m = b.paint(wood)
    edge = [[radius * 0.2, -0.02], [radius * 0.9, -0.018], [radius, -0.008]]
    edge += [[radius, 0.002], [radius * 0.97, 0.012], [radius * 0.5, 0.013], [radius * 0.06, 0.014]]
    shape = revolve(edge, 40, 14, caps=(True, True), dome=0.02)
    b.add(shape, m, at @ place([0, height - 0.0145, 0]))
    column = [[0.05, 0.06], [0.07, 0.1], [0.045, 0.18], [0.06, 0.3], [0.035, 0.45], [0.06, 0.6]]
    column = [[r, y / 0.6 * (height - 0.03)] for r, y in column]
    b.add(revolve(column, 18, 18), m, at)
    h = height * 0.28
    for turn in (0, 120, 240):
        foot = [[0, h, 0.03], [0, h * 0.75, radius * 0.35], [0, 0.02, radius * 0.62]]
        b.add(tube(foot, [0.035, 0.03, 0.02], 9, 12), m, at @ place(yaw=turn))


def sofa(
    b: Builder, at: Array, cloth_name: str, *, width: float = 2.2, seats: int = 3, pillows: str = ""
) -> None:
    """Upholstered sofa, 0.9 m deep; `seats` = 1 is an armchair."""
    m, wood = b.paint(cloth_name), b.paint("walnut")
    frame = soft_box((width, 0.2, 0.86), (14, 4, 8), power=9, bulge=0.02)
    b.add(frame, m, at @ place([0, 0.21, 0]))
    legs = at.reshape(-1, 1, 4, 4) @ corners(width / 2 - 0.08, 0.36)
    b.add(revolve([[0.018, 0], [0.03, 0.12]], 10, 3), wood, legs)
    rest = soft_box((width, 0.56, 0.2), (14, 8, 4), power=6, bulge=0.03, warp=wrinkles(0.004, 19))
    b.add(rest, m, at @ place([0, 0.54, -0.35], pitch=-6))
    for side in (-1, 1):
        arm = soft_box((0.19, 0.42, 0.86), (5, 7, 9), power=5, bulge=0.04, warp=wrinkles(0.006, 23))
        b.add(arm, m, at @ place([side * (width / 2 - 0.09), 0.42, 0]))
    step = (width - 0.38) / seats
    seat = soft_box(
        (step * 0.995, 0.19, 0.68), (12, 5, 12), power=5, bulge=0.12, warp=wrinkles(0.012, 21)
    )
    back = soft_box(
        (step * 0.98, 0.44, 0.18), (12, 9, 5), power=4, bulge=0.16, warp=wrinkles(0.015, 17)
    )
    middles = (np.arange(seats) - (seats - 1) / 2) * step
    for x in middles:
        b.add(seat, m, at @ place([x, 0.375, 0.09]))
        b.add(back, m, at @ place([x, 0.64, -0.19], pitch=-12))
    if pillows:
        for k, color in enumerate(pillows.split()):
            x = -width / 2 + 0.38 + k * (width - 0.76) / max(1, len(pillows.split()) - 1)
            throw_pillow(b, at @ place([x, 0.655, 0.02], yaw=14 - 11 * k, pitch=-22), color)


def throw_pillow(b: Builder, at: Array, color: str, size: float = 0.42) -> None:
    """Square cushion standing on its edge, centred."""

    def pinch(p: Array) -> Array:
        x, y, _ = p.T / (size / 2)
        corner = 1 + 0.10 * (x * y) ** 2
        crease = 1 + 0.12 * np.sin(9 * x + 3 * y) * np.sin(8 * y - 2 * x)
        thin = 1 - 0.75 * np.clip(np.maximum(np.abs(x), np.abs(y)), 0, 1) ** 3
        pinched: Array = p * np.stack([corner, corner, crease * thin], axis=1)
        return pinched

    b.add(soft_box((size, size, 0.2), (14, 14, 3), power=5, bulge=0.25, warp=pinch), color, at)


def throw_blanket(b: Builder, at: Array, color: str, width: float = 0.55) -> None:
    """Blanket over a sofa's arm: hangs down on both sides of x = 0."""

    def position(u: Array, v: Array) -> Array:
        s = (v - 0.5) * 1.15
        over = np.clip(s / 0.13, -1, 1) * 0.115
        fall = np.maximum(np.abs(s) - 0.13, 0)
        ripple = 0.018 * np.sin(16 * u + 4 * v) * np.minimum(1, 5 * fall)
        x = over + np.sign(s) * (0.01 + 0.5 * np.abs(ripple))
        y = 0.02 * (1 - (over / 0.115) ** 2) - 0.82 * fall + 0.004 * np.sin(23 * u)
        return np.stack([x, y, (u - 0.5) * width * (1 + 0.05 * np.sin(7 * s))], axis=-1)

    b.add(surface(position, 22, 40), color, at)


def bookshelf(
    b: Builder,
    at: Array,
    rng: np.random.Generator,
    *,
    width: float = 0.95,
    height: float = 2.2,
    depth: float = 0.3,
    shelves: int = 6,
    wood: str = "oak",
    fill: float = 0.9,
) -> None:
    """Shelf unit with its back at z = 0, filled with books; one place per unit stays free."""
    m = b.paint(wood)
    side = soft_box((0.025, height, depth), (2, 8, 3), power=30, bulge=0.02)
    for x in (-width / 2, width / 2):
        b.add(side, m, at @ place([x, height / 2, depth / 2]))
    gap = (height - 0.1) / shelves
    levels = 0.08 + gap * np.arange(shelves + 1)
    board = soft_box((width - 0.02, 0.024, depth), (6, 2, 3), power=30, bulge=0.03)
    b.add(board, m, at @ place([[0, y, depth / 2] for y in levels]))
    back = soft_box((width, height - 0.02, 0.008), (6, 10, 1), power=40, bulge=0.3)
    b.add(back, m, at @ place([0, height / 2, 0.004]))
    # Books: upright, the last of each row leaning.
    books: dict[str, list[Array]] = {}
    for y in levels[:-1]:
        x, end = (
            -width / 2 + 0.03,
            -width / 2 + 0.03 + (width - 0.06) * rng.uniform(0.55, 1.0) * fill,
        )
        tall = gap - 0.03
        while True:
            thick, high, deep = (
                rng.uniform(0.016, 0.05),
                tall * rng.uniform(0.6, 0.95),
                rng.uniform(0.15, 0.24),
            )
            if x + thick > end:
                break
            center = [
                x + thick / 2,
                y + 0.011 + high / 2,
                depth - 0.03 - deep / 2 - rng.uniform(0, 0.015),
            ]
            color = str(rng.choice(BOOK_COLORS))
            books.setdefault(color, []).append(place(center, scale=[thick * 0.97, high, deep]))
            x += thick + 0.0008
        if x + 0.12 < width / 2 - 0.03:
            high = tall * 0.8
            lean = place([x + 0.055, y + 0.006 + high / 2, depth - 0.13], roll=17) @ place(
                scale=[0.03, high, 0.19]
            )
            books.setdefault(str(rng.choice(BOOK_COLORS)), []).append(lean)
    for color, transforms in books.items():
        shape = soft_box((1, 1, 1), (2.6, 3, 2.6), power=22, bulge=0.05)
        b.add(shape, color, at @ np.stack(transforms), optional=True)


def bed(
    b: Builder, at: Array, *, width: float = 1.6, cover: str = "sky", wood: str = "oak"
) -> None:
    """Bed 2.05 m long, head at -z, with mattress, duvet and pillows."""
    m = b.paint(wood)
    b.add(soft_box((width + 0.08, 0.16, 2.08), (6, 3, 8), power=20), m, at @ place([0, 0.24, 0]))
    head = soft_box((width + 0.1, 0.75, 0.06), (10, 8, 2), power=9, bulge=0.08)
    b.add(head, m, at @ place([0, 0.58, -1.05]))
    legs = at.reshape(-1, 1, 4, 4) @ corners(width / 2 - 0.06, 0.95)
    b.add(revolve([[0.025, 0], [0.035, 0.17]], 10, 3), m, legs)
    mattress = soft_box(
        (width, 0.2, 2.0), (14, 4, 16), power=9, bulge=0.03, warp=wrinkles(0.003, 14)
    )
    b.add(mattress, "porcelain", at @ place([0, 0.41, 0]))

    def duvet(u: Array, v: Array) -> Array:
        x, z = (u - 0.5) * (width + 0.5), v * 1.5
        hang = np.maximum(np.abs(x) - width / 2 - 0.01, 0)
        puff = 0.035 + 0.014 * np.sin(9 * x + 3 * np.sin(4 * z)) * np.sin(7 * z + 2 * x)
        y = 0.515 + np.where(hang > 0, 0.01, puff) - 1.1 * hang
        bent = np.sign(x) * (
            np.minimum(np.abs(x), width / 2 + 0.01)
            + 0.03 * np.sin(9 * z) * hang / 0.24
            + 0.12 * hang
        )
        return np.stack([bent, y, z - 0.46], axis=-1)

    b.add(surface(duvet, 40, 36), cover, at)
    pillow = soft_box((0.66, 0.17, 0.42), (14, 5, 10), power=4, bulge=0.22, warp=wrinkles(0.02, 16))
    for x in (-width / 4, width / 4) if width > 1.2 else (0.0,):
        b.add(pillow, "linen", at @ place([x, 0.585, -0.74], pitch=-9, yaw=6 * np.sign(x)))


def cabinet(
    b: Builder, at: Array, size: tuple[float, float, float], wood: str, *, doors: int = 2
) -> None:
    """Cupboard with `doors` bulged fronts and turned knobs; its back at z = 0."""
    (x, y, z), m = size, b.paint(wood)
    body = soft_box((x, y - 0.08, z), (5, 5, 3), power=30, bulge=0.005)
    b.add(body, m, at @ place([0, (y + 0.08) / 2, z / 2]))
    b.add(
        cylinder(0.022, 0.1, 9),
        m,
        at.reshape(-1, 1, 4, 4) @ place([0, 0, z / 2]) @ corners(x / 2 - 0.06, z / 2 - 0.05),
    )
    step = x / doors
    front = soft_box((step - 0.02, y - 0.12, 0.02), (5, 6, 2), power=24, bulge=0.25)
    panel = soft_box((step - 0.16, y - 0.28, 0.016), (4, 5, 2), power=12, bulge=0.5)
    knob = revolve(
        [[0.006, 0], [0.006, 0.012], [0.016, 0.022], [0.012, 0.032], [0.003, 0.034]], 9, 8
    )
    for k in range(doors):
        cx = -x / 2 + (k + 0.5) * step
        b.add(front, m, at @ place([cx, (y + 0.08) / 2, z + 0.008]))
        b.add(panel, m, at @ place([cx, (y + 0.08) / 2, z + 0.018]))
        offset = (step / 2 - 0.05) * (1 if k % 2 == 0 else -1)
        b.add(knob, "brass", at @ place([cx + offset, y * 0.55, z + 0.017], pitch=90))


def desk_chair(b: Builder, at: Array, color: str = "grey_cloth") -> None:
    """Swivel chair on a five-star base."""
    metal, seat_cloth = b.paint("black_metal"), b.paint(color)
    seat = soft_box((0.5, 0.09, 0.48), (9, 4, 9), power=5, bulge=0.1, warp=wrinkles(0.01, 25))
    b.add(seat, seat_cloth, at @ place([0, 0.47, 0]))

    def curved(p: Array) -> Array:
        return p + np.stack([0 * p[:, 0], 0 * p[:, 0], 0.9 * p[:, 0] ** 2 + 0.12 * p[:, 1] ** 2], 1)

    back = soft_box((0.46, 0.58, 0.07), (9, 10, 3), power=5, bulge=0.1, warp=curved)
    b.add(back, seat_cloth, at @ place([0, 0.83, -0.25], pitch=-8))
    b.add(tube([[0, 0.42, -0.1], [0, 0.46, -0.27], [0, 0.72, -0.29]], 0.02, 7, 8), metal, at)
    b.add(revolve([[0.03, 0.09], [0.03, 0.25], [0.02, 0.26], [0.02, 0.43]], 10, 8), metal, at)
    arm = [[0.25, 0.45, 0.0], [0.3, 0.52, 0.0], [0.3, 0.66, 0.02], [0.28, 0.67, 0.16]]
    for mirror in (1, -1):
        b.add(tube(np.array(arm) * [mirror, 1, 1], [0.014, 0.014, 0.018], 7, 10), metal, at)
    for turn in range(0, 360, 72):
        leg = at @ place(yaw=turn)
        shape = tube([[0, 0.11, 0.02], [0, 0.1, 0.16], [0, 0.065, 0.29]], [0.02, 0.013], 7, 6)
        b.add(shape, metal, leg)
        wheel = revolve(
            [[0.01, -0.02], [0.027, -0.016], [0.03, 0], [0.027, 0.016], [0.01, 0.02]],
            10,
            6,
            caps=(True, True),
        )
        b.add(wheel, metal, leg @ place([0, 0.031, 0.29], roll=90), optional=True)


def rug(b: Builder, at: Array, size: tuple[float, float], color: str) -> None:
    """Piled rug with fringes along both ends of z."""
    b.add(cloth(size), color, at)
    n = int(size[0] * 40)
    x = np.linspace(-size[0] / 2 + 0.01, size[0] / 2 - 0.01, n)
    wobble = 0.012 * np.sin(np.arange(n) * 2.4)
    for end in (-1, 1):
        z = end * (size[1] / 2 - 0.01)
        fringe = tube(
            [[0, 0.008, 0], [0.004, 0.006, 0.03], [0, 0.004, 0.075]], [0.003, 0.004, 0.002], 4, 4
        )
        turns = place(np.stack([x, 0 * x, 0 * x + z], 1), yaw=90 - 90 * end + 900 * wobble)
        b.add(fringe, "cream", at @ turns, optional=True)
