"""Scenes for measurements and tests: few shapes, known proportions."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from viscache.scenes.builder import Builder
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import Array, box, bumpy_sphere, place, quad, rod

GREY = (0.5, 0.5, 0.5)


@scene(shown={"edge": 0.01})
def random_triangles(
    triangles: Annotated[int, Range(1, MOST_TRIANGLES)] = 100_000,
    edge: Annotated[float | None, Range(0, 1, open=True)] = None,
    seed: Annotated[int, Range(0, 2**64 - 1)] = 1,
    edge_factor: Annotated[float | None, Range(1e-6, 1e6)] = None,
) -> Builder:
    """Equilateral triangles at random places and orientations in the unit cube.

    Parameters
    ----------
    triangles : int
        Exact number, at least 1.
    edge : float
        Length of their edges, 0.01 by default; 2 triangles^(-1/3) is dense.
    seed : int
        Seed of the random numbers.
    edge_factor : float
        Replaces `edge`: edges have the length edge_factor * triangles^(-1/3), for a density that
        does not depend on the number.
    """
    if edge_factor is not None:
        if edge is not None:
            raise ValueError(f"edge must be left out with edge_factor, got {edge}")
        edge = min(edge_factor * triangles ** (-1 / 3), 0.9)
    edge = 0.01 if edge is None else edge
    rng = np.random.Generator(np.random.Philox(seed))
    r = edge / np.sqrt(3)
    centers = rng.uniform(r, 1 - r, (triangles, 3))
    a = _directions(rng, triangles)
    b = np.cross(a, _directions(rng, triangles))
    b /= np.maximum(np.linalg.norm(b, axis=1, keepdims=True), 1e-12)
    angles = 2 * np.pi / 3 * np.arange(3)[:, None]
    around = np.cos(angles) * a[:, None] + np.sin(angles) * b[:, None]
    scene_ = Builder("random_triangles")
    vertices = (centers[:, None] + r * around).reshape(-1, 3)
    indices = np.arange(3 * triangles, dtype=np.uint32).reshape(-1, 3)
    scene_.add_mesh(vertices, indices, scene_.diffuse("grey", GREY), name="triangles")
    scene_.point_light((0.5, 1.6, 1.4), 2.5)
    scene_.description.set_environment((0.25, 0.28, 0.32))
    scene_.camera((1.6, 1.3, 2.0), (0.5, 0.48, 0.5), 32.0)
    return scene_


def _directions(rng: np.random.Generator, n: int) -> Array:
    z, p = rng.uniform(-1, 1, n), rng.uniform(0, 2 * np.pi, n)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(p), r * np.sin(p), z], axis=1)


@scene()
def bumpy_spheres(
    triangles: Annotated[int, Range(200, MOST_TRIANGLES)] = 15_000,
    spheres: Annotated[int, Range(1, 10_000)] = 36,
) -> Builder:
    """Grid of bumpy spheres over a ground plane, 2 m wide, under a bright sky.

    Parameters
    ----------
    triangles : int
        Placed triangles; the scene has this many to 1.25 times as many. At least 200;
        below about 500 there are fewer spheres.
    spheres : int
        Number of spheres, on the smallest square grid that holds them.
    """
    b = Builder("bumpy_spheres")
    g = int(np.ceil(np.sqrt(spheres)))
    colors = [(0.62, 0.29, 0.17), (0.30, 0.45, 0.55), (0.72, 0.60, 0.35), (0.45, 0.52, 0.38)]
    ground = quad([-1.2, 0, 1.2], [1.2, 0, 1.2], [1.2, 0, -1.2], [-1.2, 0, -1.2])
    b.add(ground, b.diffuse("ground", (0.6, 0.58, 0.55)))
    radius = 0.85 / g
    for k in range(spheres):
        i, j = divmod(k, g)
        height = 0.6 / g * (1 + ((i * 7 + j * 3) % 4) * 0.6) + 0.35 / g
        spot = place([-1 + (2 * i + 1) / g, height, -1 + (2 * j + 1) / g])
        shape = bumpy_sphere(radius, 6, phase=0.37 * k)
        b.add(shape, b.diffuse(f"clay {k % 4}", colors[k % 4]), spot)
    b.fit(triangles)
    b.description.set_environment((0.8, 0.9, 1.0))
    b.point_light((1.5, 2.5, 1.0), 4.0)
    b.camera((1.5, 1.25, 2.2), (0.0, 0.1, 0.0), 36.0)
    return b


@scene()
def cornell_box() -> Builder:
    """Cornell box as measured at Cornell, in metres, with its ceiling light."""
    b = Builder("cornell_box")
    white, red, green = (0.73, 0.71, 0.68), (0.57, 0.043, 0.044), (0.11, 0.41, 0.15)
    w, r, g = (b.diffuse(n, c) for n, c in (("white", white), ("red", red), ("green", green)))

    def add(material: int, *mm: tuple[float, float, float]) -> None:
        # The published coordinates (mm, x to the left seen from the camera, z away from it).
        b.add(quad(*(np.array([-x, y, -z]) / 1000 for x, y, z in mm)), material)

    add(w, (552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2))
    add(w, (556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0))
    add(w, (549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2))
    add(g, (0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2))
    add(r, (552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0))
    low = ((130, 65), (82, 225), (240, 272), (290, 114))
    high = ((423, 247), (265, 296), (314, 456), (472, 406))
    for base, h in ((low, 165.0), (high, 330.0)):
        top = [(float(x), h, float(z)) for x, z in base]
        add(w, *top)
        for k in range(4):
            p, q = top[k], top[(k + 1) % 4]
            add(w, p, (p[0], 0, p[2]), (q[0], 0, q[2]), q)
    light = [(343, 548.7, 227), (343, 548.7, 332), (213, 548.7, 332), (213, 548.7, 227)]
    corners = [np.array([-x, y, -z]) / 1000 for x, y, z in light]
    b.add(quad(*corners), b.diffuse("light", (0.78, 0.78, 0.78)), emission=(18.4, 15.6, 8.0))
    b.write(1.0)
    b.camera((-0.278, 0.273, 0.8), (-0.278, 0.273, 0.0), 39.3077, size=(512, 512))
    return b


@scene()
def window_room() -> Builder:
    """Closed room 8 x 8 x 4 (z up), albedo 0.5, lit by a sky of 1 through one 1 x 1 window."""
    b = Builder("window_room")
    m = b.diffuse("grey", GREY)
    x, y, z = 8.0, 8.0, 4.0
    b.add(quad([0, 0, 0], [x, 0, 0], [x, y, 0], [0, y, 0]), m)
    b.add(quad([0, 0, z], [0, y, z], [x, y, z], [x, 0, z]), m)
    b.add(quad([0, 0, 0], [0, y, 0], [0, y, z], [0, 0, z]), m)
    b.add(quad([0, 0, 0], [0, 0, z], [x, 0, z], [x, 0, 0]), m)
    b.add(quad([0, y, 0], [x, y, 0], [x, y, z], [0, y, z]), m)
    # The wall x = 8 around the window.
    for y0, y1, z0, z1 in ((0, 8, 0, 1.5), (0, 8, 2.5, 4), (0, 3.5, 1.5, 2.5), (4.5, 8, 1.5, 2.5)):
        b.add(quad([x, y0, z0], [x, y0, z1], [x, y1, z1], [x, y1, z0]), m)
    b.write(1.0)
    b.description.set_environment((1.0, 1.0, 1.0))
    b.camera((1.0, 1.0, 1.6), (5.0, 5.0, 0.8), 60.0, up=(0.0, 0.0, 1.0), size=(640, 480))
    return b


@scene()
def cube_on_plane(size: Annotated[float, Range(1e-6, 1e9)] = 1.0) -> Builder:
    """One cube on a large plane under a point light; `size` is the cube's edge."""
    b = Builder("cube_on_plane")
    _ground(b, 8 * size)
    h = size / 2
    turned = place(yaw=20)
    b.add(box([-h, 0, -h], [h, size, h]), b.diffuse("cube", (0.6, 0.35, 0.2)), turned)
    b.write(1.0)
    b.point_light((2.2 * size, 3.0 * size, 1.2 * size), 12.0 * size**2)
    b.camera((-1.2 * size, 2.6 * size, 4.2 * size), (0.0, 0.35 * size, 0.0), 38.0)
    return b


@scene()
def stairs(steps: Annotated[int, Range(1, 2_000)] = 9) -> Builder:
    """A flight of stairs with a railing in hard sunlight."""
    b = Builder("stairs")
    _ground(b, 12.0)
    stone, metal = b.diffuse("stone", (0.62, 0.58, 0.5)), b.diffuse("metal", (0.12, 0.13, 0.15))
    rise, tread, wide = 0.17, 0.29, 1.6
    for k in range(steps):
        low = [-wide / 2, 0, -(k + 1) * tread]
        b.add(box(low, [wide / 2, (k + 1) * rise, -k * tread]), stone)
        for x in (-wide / 2 + 0.06, wide / 2 - 0.06):
            foot = [x, (k + 1) * rise, -(k + 0.5) * tread]
            b.add(rod(foot, np.add(foot, [0, 0.95, 0]), 0.012, 8), metal)
    run = [[0, 0.95 + rise, -0.5 * tread], [0, 0.95 + steps * rise, -(steps - 0.5) * tread]]
    for x in (-wide / 2 + 0.06, wide / 2 - 0.06):
        b.add(rod(np.add(run[0], [x, 0, 0]), np.add(run[1], [x, 0.001, 0]), 0.022, 10), metal)
    b.write(1.0)
    b.description.add_directional_light((0.55, 0.75, 0.42), (3.0, 2.85, 2.6))
    b.camera((-2.6, 1.7, 2.4), (0.1, 0.55, -1.0), 40.0)
    return b


@scene()
def slats(count: Annotated[int, Range(1, 10_000)] = 16) -> Builder:
    """Thin slats over a floor with a few objects, under four point lights.

    Parameters
    ----------
    count : int
        Number of slats, each 2 cm thick and 3 m long, one every 15 cm.
    """
    b = Builder("slats")
    _ground(b, 6.0)
    wood = b.diffuse("wood", (0.5, 0.35, 0.2))
    for k in range(count):
        x = (k - (count - 1) / 2) * 0.15
        b.add(box([x - 0.01, 1.6, -1.5], [x + 0.01, 1.62, 1.5]), wood)
    for x in (-1.0, 1.0):
        shape = box(
            [0.15 * count / 2 * x - 0.02, 1.62, -1.5], [0.15 * count / 2 * x + 0.02, 1.66, 1.5]
        )
        b.add(shape, wood)
    b.add(bumpy_sphere(0.3, 16), b.diffuse("ball", (0.35, 0.42, 0.55)), place([0.5, 0.3, 0.2]))
    b.add(box([-0.7, 0, -0.4], [-0.2, 0.5, 0.1]), b.diffuse("block", (0.6, 0.3, 0.25)))
    b.write(1.0)
    for x, z in ((-1.0, -0.8), (1.0, -0.8), (-1.0, 0.8), (1.0, 0.8)):
        b.point_light((x, 2.6, z), 3.0)
    b.camera((0.6, 1.35, 3.6), (0.0, 0.35, 0.0), 40.0)
    return b


@scene()
def slits(count: Annotated[int, Range(1, 10_000)] = 12) -> Builder:
    """A wall with thin slits between a point light and a floor.

    Parameters
    ----------
    count : int
        Number of slits, each 2 cm wide, one every 20 cm.
    """
    b = Builder("slits")
    _ground(b, 8.0)
    wall = b.diffuse("wall", (0.6, 0.55, 0.5))
    pitch, gap, height = 0.2, 0.02, 1.5
    left = -(count + 1) * pitch / 2
    for k in range(count + 1):
        x = left + k * pitch
        b.add(box([x + gap / 2, 0, -0.02], [x + pitch - gap / 2, height, 0.02]), wall)
    far = 4.0
    b.add(box([-far, 0, -0.02], [left + gap / 2, height, 0.02]), wall)
    b.add(box([-left - gap / 2, 0, -0.02], [far, height, 0.02]), wall)
    b.add(box([-far, height, -0.02], [far, 2.5, 0.02]), wall)
    b.write(1.0)
    b.point_light((0.3, 1.4, -1.6), 6.0)
    b.camera((0.0, 1.5, 3.6), (0.0, 0.4, 0.4), 42.0)
    return b


@scene()
def thin_wall(thickness: Annotated[float, Range(0, 1, open=True)] = 1e-3) -> Builder:
    """A wall `thickness` times its width thick, with the light behind it."""
    b = Builder("thin_wall")
    _ground(b, 8.0)
    width = 3.0
    t = thickness * width / 2
    b.add(box([-width / 2, 0, -t], [width / 2, 2.0, t]), b.diffuse("wall", (0.7, 0.6, 0.5)))
    b.write(1.0)
    b.point_light((0.2, 1.1, -0.9), 5.0)
    b.camera((0.9, 1.5, 4.6), (0.0, 0.7, 0.0), 42.0)
    return b


def _ground(b: Builder, width: float) -> None:
    w = width / 2
    shape = quad([-w, 0, w], [w, 0, w], [w, 0, -w], [-w, 0, -w])
    b.add(shape, b.diffuse("ground", (0.55, 0.55, 0.52)))
