"""Things fixed to a building, and screens: slats, blinds, radiators, skirting boards.

Each stands on y = 0 around the origin unless it says otherwise.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from viscache.scenes.builder import Builder
from viscache.scenes.shapes import Array, cylinder, place, revolve, rod, soft_box, tube


def slats(
    b: Builder,
    at: Array,
    n: int,
    pitch: float,
    size: tuple[float, float, float],
    wood: str,
    sag: float = 0.01,
) -> None:
    """`n` rounded bars of `size` along z, one every `pitch` along x, centred, sagging a little."""
    half = size[2] / 2

    def bend(p: Array) -> Array:
        wave = 0.3 * np.sin(14 * p[:, 2] / half)
        drop = -sag * (1 - (p[:, 2] / half) ** 2 + wave)
        return p + np.stack([0.2 * sag * np.sin(3 * p[:, 2]), drop, 0 * drop], 1)

    x = (np.arange(n) - (n - 1) / 2) * pitch
    bar = soft_box(size, (2, 2, 22), power=10, bulge=0.06, warp=bend)
    b.add(bar, wood, at @ place(np.stack([x, 0 * x, 0 * x], 1)))


def blind(
    b: Builder,
    at: Array,
    width: float,
    height: float,
    *,
    tilt: float = 35,
    color: str = "white_paint",
) -> None:
    """Venetian blind in the plane z = 0, x centred, hanging from y = `height` to 0."""
    n = max(3, int(height / 0.045))

    def curve(p: Array) -> Array:
        return p + np.stack(
            [0 * p[:, 0], -6 * p[:, 2] ** 2 - 0.004 * (2 * p[:, 0] / width) ** 2, 0 * p[:, 0]], 1
        )

    slat = soft_box((width, 0.0025, 0.045), (7, 1, 3), power=9, bulge=0.3, warp=curve)
    y = 0.02 + np.arange(n) * (height - 0.06) / n
    b.add(slat, color, at @ place(np.stack([0 * y, y, 0 * y], 1), pitch=tilt), optional=True)
    shape = soft_box((width, 0.04, 0.05), (6, 2, 2), power=8)
    b.add(shape, color, at @ place([0, height - 0.01, 0]))
    for x in (-0.35 * width, 0.35 * width):
        b.add(rod([x, 0.0, 0.027], [x, height, 0.027], 0.0012, 4), color, at, optional=True)


def radiator(b: Builder, at: Array, width: float = 1.0, height: float = 0.55) -> None:
    """Ribbed radiator standing on feet, its back at z = 0."""
    m = b.paint("white_paint")
    x = np.arange(-width / 2 + 0.03, width / 2, 0.06)
    rib = soft_box((0.05, height, 0.1), (3, 7, 4), power=5, bulge=0.1)
    b.add(rib, m, at @ place(np.stack([x, 0 * x + 0.1 + height / 2, 0 * x + 0.08], 1)))
    for y in (0.15, 0.05 + height):
        b.add(rod([-width / 2, y, 0.08], [width / 2, y, 0.08], 0.018, 8), m, at)
    for side in (-0.4, 0.4):
        b.add(cylinder(0.015, 0.13, 8), m, at @ place([side * width, 0, 0.08]))


def screen(b: Builder, at: Array, width: float = 0.55) -> None:
    """Monitor on a foot, facing +z."""
    m, h = b.paint("screen"), width * 0.6
    panel = soft_box((width, h, 0.025), (6, 5, 2), power=20, bulge=0.15)
    b.add(panel, m, at @ place([0, 0.12 + h / 2, 0]))
    b.add(tube([[0, 0.01, -0.06], [0, 0.1, -0.06], [0, 0.25, -0.02]], [0.02, 0.016], 8, 7), m, at)
    shape = revolve([[0.12, 0], [0.115, 0.008], [0.02, 0.014]], 18, 5, caps=(True, True))
    b.add(shape, m, at @ place([0, 0, -0.04]))


def laptop(b: Builder, at: Array) -> None:
    """Open laptop facing +z, with single keys."""
    m = b.paint("steel")
    part = soft_box((0.32, 0.014, 0.22), (5, 2, 5), power=14, bulge=0.03)
    b.add(part, m, at @ place([0, 0.008, 0]))
    shape = soft_box((0.32, 0.21, 0.007), (5, 5, 2), power=18, bulge=0.15)
    b.add(shape, m, at @ place([0, 0.105, -0.145], pitch=-18))
    glass = soft_box((0.3, 0.185, 0.004), (4, 4, 1), power=24, bulge=0.3)
    b.add(glass, "screen", at @ place([0, 0.107, -0.140], pitch=-18))
    x, z = np.meshgrid(np.linspace(-0.13, 0.13, 13), np.linspace(-0.07, 0.02, 5))
    keys = np.stack([x.ravel(), 0 * x.ravel() + 0.0162, z.ravel()], 1)
    key = soft_box((0.016, 0.005, 0.016), (2, 1.4, 2), power=7, bulge=0.1)
    b.add(key, "screen", at @ place(keys), optional=True)


def skirting(b: Builder, points: npt.ArrayLike, color: str = "white_paint") -> None:
    """Moulded skirting board along straight runs (K, 2, 3), standing against walls."""
    for start, end in np.asarray(points, float):
        b.add(tube(np.linspace(start, end, 3), [0.022, 0.026, 0.022], 6, 8, smooth=False), color)
