"""Dynamics: cubes at rest, stacked, and falling."""

from __future__ import annotations

import numpy as np

from viscache.scenes.builder import Builder
from viscache.scenes.registry import scene
from viscache.scenes.shapes import Array, box, place, quad
from viscache.scenes.sky import sky

EDGE = 5.0  # units, as in the visibility-map paper
GROUND = 39.0
#: Upright cubes: x, z and yaw of their centres; number of cubes below them.
UPRIGHT = (
    (-12.0, -12.5, 12.0, 0),
    (3.5, -13.0, 34.0, 0),
    (-4.0, -3.0, -21.0, 0),
    (11.0, -3.0, -8.0, 0),
    (-13.5, 5.5, 27.0, 0),
    (1.5, 9.0, 41.0, 0),
    (14.0, 12.0, 5.0, 0),
    (10.6, -3.3, 16.0, 1),
)
#: Falling cubes: centre, yaw, pitch, roll.
FALLING = ((2.0, 10.5, 1.0, 20.0, 31.0, 12.0),)


@scene()
def dynamics() -> Builder:
    """Flat cubes with edges of 5 units, scattered and falling on a plane, under a sky.

    A stand-in for the scene of the same name in the visibility-map paper, where "mostly flat
    surfaces" are the point: every triangle lies in one plane with a neighbour.
    """
    b = Builder("dynamics")
    w, h = GROUND / 2, EDGE / 2
    ground = b.glossy("ground", (0.52, 0.5, 0.46), 0.04, 0.35)
    b.add(quad([-w, 0, w], [w, 0, w], [w, 0, -w], [-w, 0, -w]), ground)
    paints = [
        b.glossy("red cubes", (0.6, 0.14, 0.1), 0.05, 0.2),
        b.glossy("blue cubes", (0.12, 0.26, 0.5), 0.05, 0.2),
        b.diffuse("white cubes", (0.76, 0.74, 0.7)),
    ]
    cube = box([-h, -h, -h], [h, h, h])
    for k, at in enumerate(cubes()):
        b.add(cube, paints[k % 3], at)
    b.write(1.0)
    b.description.set_environment(image=b.description.add_image(sky((0.5, 0.62, 0.6))))
    b.camera((13.0, 16.5, 31.0), (0.0, 3.0, -1.0), 40.0, size=(640, 480))
    return b


def cubes() -> list[Array]:
    """Transforms (4, 4) of the cubes."""
    upright = [place([x, EDGE * (below + 0.5), z], yaw=yaw) for x, z, yaw, below in UPRIGHT]
    falling = [place([x, y, z], yaw=a, pitch=p, roll=r) for x, y, z, a, p, r in FALLING]
    return [np.asarray(at) for at in upright + falling]
