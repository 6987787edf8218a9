"""Walls with openings, window frames and doors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscache.scenes.builder import Builder
from viscache.scenes.shapes import Array, box, place, quad, revolve, rod, soft_box

Opening = tuple[float, float, float, float]  # from, to along the wall; bottom, top


def run(start: tuple[float, float], end: tuple[float, float]) -> tuple[Array, float]:
    """Frame (4, 4) of a wall on the floor from `start` to `end` (x, z), and its length.

    In the frame x runs along the wall, y up and z to its left seen from above (x to z clockwise).
    """
    a, b = np.asarray(start, float), np.asarray(end, float)
    along = b - a
    yaw = float(np.degrees(np.arctan2(-along[1], along[0])))
    return place([a[0], 0.0, a[1]], yaw=yaw), float(np.hypot(*along))


def wall(
    b: Builder,
    start: tuple[float, float],
    end: tuple[float, float],
    height: float,
    color: str,
    openings: Sequence[Opening] = (),
    thickness: float = 0.16,
) -> None:
    """Wall of plain boxes around its openings; openings that reach the floor are doors."""
    frame, length = run(start, end)
    m, h = b.paint(color), thickness / 2
    x = 0.0
    for left, right, bottom, top in sorted(openings):
        b.add(box([x, 0, -h], [left, height, h]), m, frame)
        if bottom > 0:
            b.add(box([left, 0, -h], [right, bottom, h]), m, frame)
        b.add(box([left, top, -h], [right, height, h]), m, frame)
        if bottom > 0:
            _window(b, frame, left, right, bottom, top)
        else:
            _casing(b, frame, left, right, top, h)
        x = right
    b.add(box([x, 0, -h], [length, height, h]), m, frame)


def shell(
    b: Builder, size: tuple[float, float, float], floor: str, walls: tuple[str, str, str, str]
) -> None:
    """A closed box of quads, seen from inside; walls at -z, +z, -x and +x."""
    x, y, z = size
    b.add(quad([-x, 0, z], [x, 0, z], [x, 0, -z], [-x, 0, -z]), floor)
    b.add(quad([-x, y, -z], [x, y, -z], [x, y, z], [-x, y, z]), "ceiling")
    corners = [[-x, -z], [x, -z], [x, z], [-x, z]]
    for (a, c), color in zip(((0, 1), (2, 3), (3, 0), (1, 2)), walls, strict=True):
        (ax, az), (cx, cz) = corners[a], corners[c]
        b.add(quad([ax, 0, az], [cx, 0, cz], [cx, y, cz], [ax, y, az]), color)


def _bar(
    b: Builder, at: Array, size: tuple[float, float, float], color: str = "white_paint"
) -> None:
    cells = tuple(max(2.0, min(8.0, 5 * s)) for s in size)
    b.add(soft_box(size, (cells[0], cells[1], cells[2]), power=12, bulge=0.2), color, at)


def _window(b: Builder, at: Array, left: float, right: float, bottom: float, top: float) -> None:
    wide, high = right - left, top - bottom
    cx, cy = (left + right) / 2, (bottom + top) / 2
    panes = max(2, round(wide / 0.8))
    for k in range(panes + 1):
        _bar(b, at @ place([left + wide * k / panes, cy, 0]), (0.06, high, 0.07))
    for y in (bottom + 0.03, top - 0.03):
        _bar(b, at @ place([cx, y, 0]), (wide, 0.06, 0.07))
    _bar(b, at @ place([cx, bottom + 0.68 * high, 0]), (wide, 0.03, 0.03))
    _bar(b, at @ place([cx, bottom - 0.015, 0]), (wide + 0.1, 0.03, 0.34))


def _casing(b: Builder, at: Array, left: float, right: float, top: float, half: float) -> None:
    for side in (-1, 1):
        z = side * (half + 0.008)
        for x in (left - 0.03, right + 0.03):
            _bar(b, at @ place([x, top / 2, z]), (0.075, top, 0.024))
        _bar(
            b, at @ place([(left + right) / 2, top + 0.035, z]), (right - left + 0.14, 0.075, 0.024)
        )


def door(
    b: Builder, at: Array, *, width: float = 0.86, height: float = 2.06, open_deg: float = 0
) -> None:
    """Panelled door hinged at the origin, closed along +x, opened by `open_deg` towards +z."""
    leaf = at @ place(yaw=-open_deg) @ place([width / 2, height / 2 + 0.01, 0])
    m, x = b.paint("white_paint"), width / 2
    b.add(soft_box((width, height, 0.04), (5, 8, 2), power=30, bulge=0.1), m, leaf)
    panel = soft_box((width * 0.34, height * 0.34, 0.016), (5, 6, 2), power=9, bulge=0.4)
    for px in (-0.22, 0.22):
        for py in (-0.22, 0.22):
            for z in (-0.02, 0.02):
                b.add(panel, m, leaf @ place([px * width, py * height, z]), optional=True)
    brass = b.paint("brass")
    for z in (-1, 1):
        spot = leaf @ place([x - 0.06, -0.02, z * 0.02])
        shape = revolve([[0.022, 0], [0.02, 0.006], [0.008, 0.01], [0.008, 0.04]], 10, 6)
        b.add(shape, brass, spot @ place(pitch=z * 90))
        b.add(rod([0, 0, z * 0.04], [-0.1, 0, z * 0.04], 0.008, 8), brass, spot)
