"""A hall under many strip lights, made by numbers."""

import numpy as np

import viscache as vc
from render.mitsuba_scene import Part, box, quad
from viscache._core import MaterialKind

SIZE = 20.0
HEIGHT = 4.0


def strip_lights(
    strips: int = 1000, *, seed: int = 0, glossy: bool = False, blocks: int = 30
) -> vc.Scene:
    """Strips of .6 × .04 under a ceiling, of powers that differ by up to 20, over blocks."""
    random = np.random.default_rng(seed)
    d = vc.SceneDescription()
    grey = d.add_material(base_color=(0.6, 0.6, 0.6))
    floor = grey
    if glossy:
        floor = d.add_material(
            MaterialKind.GLOSSY, base_color=(0.3, 0.3, 0.3), specular=(0.5, 0.5, 0.5), roughness=0.1
        )

    def add(part: Part, material: int = grey) -> None:
        d.add_mesh(part.vertices, part.triangles, material=material, emission=part.emission)

    add(quad((0, 0, 0), (0, 0, SIZE), (SIZE, 0, 0)), floor)
    add(quad((0, HEIGHT, 0), (SIZE, 0, 0), (0, 0, SIZE)))
    for wall in range(4):
        turn = np.pi / 2 * wall
        c, s = np.cos(turn), np.sin(turn)
        corner = np.array([0.5 - 0.5 * c - 0.5 * s, 0, 0.5 + 0.5 * s - 0.5 * c]) * SIZE
        add(quad(corner, (SIZE * c, 0, -SIZE * s), (0, HEIGHT, 0)))
    for _ in range(blocks):
        x, z = random.uniform(1, SIZE - 1, 2)
        w, h = random.uniform(0.2, 0.6), random.uniform(0.3, 2.5)
        add(box((x - w, 0, z - w), (x + w, h, z + w)))
    rows = int(np.ceil(np.sqrt(strips / 2.5)))
    columns = int(np.ceil(strips / rows))
    for i in range(strips):
        x = (i % columns + 0.5) / columns * SIZE
        z = (i // columns + 0.5) / rows * SIZE
        power = 20 ** random.random()
        colour = tuple(random.uniform(0.5, 1, 3) * power)
        y = HEIGHT - 0.05 - 0.5 * random.random()
        add(quad((x - 0.02, y, z - 0.3), (0.04, 0, 0), (0, 0, 0.6), emission=colour))
    d.add_camera((1.5, 1.7, 1.5), (SIZE * 0.6, 0.8, SIZE * 0.7), up=(0, 1, 0), fov_deg=60)
    return vc.Scene.from_description(d)
