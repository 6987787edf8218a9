"""Scenes for the tests of bidirectional path tracing."""

from dataclasses import replace

from render.mitsuba_scene import Look, Model, ball, box, quad

WALLS = box((-1, 0, -1), (1, 2, 1), look=Look(base_color=(0.7, 0.6, 0.5))).reversed()
LAMP = quad((-0.4, 1.95, -0.4), (0.8, 0, 0), (0, 0, 0.8), emission=(8, 7, 6))
BLOCK = box((-0.7, 0, -0.6), (-0.1, 1.1, -0.1), look=Look(base_color=(0.3, 0.5, 0.7)))
GLOBE = ball((0.45, 0.35, 0.2), 0.35, look=Look(base_color=(0.8, 0.3, 0.2)))

#: A closed room with an area light.
ROOM = Model((WALLS, LAMP, BLOCK, GLOBE), origin=(0, 1, 0.95), target=(0, 0.8, -1), fov_deg=70)
MIRROR = replace(BLOCK, look=Look(kind="mirror", specular=(0.9, 0.8, 0.7)))
GLASS = ball((0.45, 0.4, 0.2), 0.35, 16, smooth=True, look=Look(kind="dielectric"))
#: The same with a mirror and a glass ball: caustics.
CAUSTICS = replace(ROOM, parts=(WALLS, LAMP, MIRROR, GLASS))
#: With a thin plate across the room, and a wide lamp.
PLATE = quad(
    (-1, 0.2, 0.3), (2, 0, 0.1), (0, 1.5, 0.1), look=Look(kind="dielectric", eta=1.8, thin=True)
)
WIDE = quad((-0.9, 1.95, -0.9), (1.8, 0, 0), (0, 0, 1.8), emission=(2, 1.8, 1.5))
PLATES = replace(ROOM, parts=(WALLS, WIDE, BLOCK, PLATE))
#: With a rough metal.
METAL = replace(BLOCK, look=Look(kind="glossy", base_color=(0, 0, 0), roughness=0.3))
GLOSSY = replace(ROOM, parts=(WALLS, LAMP, METAL, GLOBE))
#: Interpolated normals.
PEARL = ball((-0.4, 0.5, -0.2), 0.45, 24, smooth=True)
BALL = ball((0.45, 0.35, 0.2), 0.35, 24, smooth=True, look=GLOBE.look)
SMOOTH = replace(ROOM, parts=(WALLS, LAMP, PEARL, BALL))
FLOOR = quad((-3, 0, -3), (0, 0, 6), (6, 0, 0), look=Look(base_color=(0.6, 0.5, 0.4)))
OUTSIDE = Model((FLOOR, BLOCK, GLOBE), origin=(0.3, 1.2, 3.5), target=(0, 0.5, 0))
#: A point light, a sun and a sky.
OPEN = replace(
    OUTSIDE,
    points=(((1.5, 2.0, 1.5), (8, 6, 4)),),
    directions=(((0.48, 0.6, 0.64), (0.4, 0.5, 0.3)),),
    env=(0.3, 0.4, 0.5),
)
LAMPS = (
    quad((-0.5, 2, -0.5), (1, 0, 0), (0, 0, 1), emission=(6, 5, 4)),
    quad((2, 0.2, -1), (0, 0, 1.5), (0, 1, 0), emission=(1, 2, 5)).reversed(),
)
SPHERE = ((-1.6, 1.4, 0.8), 0.3, (3, 6, 9))
#: Every kind of light.
LIGHTS = replace(OPEN, parts=(FLOOR, BLOCK, GLOBE, *LAMPS), spheres=(SPHERE,))
