"""The garage: 12 x 3 x 8 m, lit by a sun and three lamps that stand outside, mostly hidden."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import numpy.typing as npt

from viscache.scenes import furniture, workshop
from viscache.scenes.builder import Builder
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import box, cylinder, place, quad, soft_box, tube
from viscache.scenes.sky import Disc, sky_with
from viscache.scenes.vehicles import bicycle, car, tyre_stack
from viscache.scenes.walls import wall

SEED = 1126
FULL = 350_000
LEAST = 1_000
LENGTH, HEIGHT, DEPTH = 12.0, 3.0, 8.0  # along x, y and z
GATE = (0.8, 7.2, 2.6)  # in the east wall: from z, to z, height
# Windows of the south wall: from x, to x; from y, to y.
WINDOWS, WINDOW_Y = ((1.0, 3.0), (4.8, 6.8), (8.6, 10.6)), (1.2, 2.2)
ROOF_LIGHTS, ROOF_LIGHT_Z = ((3.1, 4.1), (7.9, 8.9)), (2.8, 5.2)  # from x, to x; from z, to z
COLUMNS = tuple((x, z) for x in (4.2, 9.0) for z in (2.35, 5.75))
ROWS = 224  # rows of the sky's image: the finest that needs at most 256 x 256 texels
#: The sun and a lamp shine through the gate, one lamp through the windows, one through the roof.
SUN = Disc((0.85, 0.33, 0.25), 2.5, (900.0, 810.0, 675.0))
LAMPS = (
    Disc((0.95, 0.2, -0.2), 4.0, (210.0, 150.0, 75.0)),
    Disc((-0.35, 0.35, 0.85), 4.0, (150.0, 160.0, 170.0)),
    Disc((0.2, 0.8, 0.5), 4.0, (210.0, 150.0, 75.0)),
)


@scene()
def garage(triangles: Annotated[int, Range(LEAST, MOST_TRIANGLES)] = FULL) -> Builder:
    """Garage, 12 x 3 x 8 m, with cars, pipes and shelves; a sun and three lamps outside.

    A stand-in for the garage of the visibility-map paper: most of the light comes from a few bright
    sources that the building hides. All light is in the environment map.

    Parameters
    ----------
    triangles : int
        Placed triangles; the scene has this many to 1.25 times as many. At least 1000.
    """
    b, rng = Builder("garage"), np.random.Generator(np.random.PCG64(SEED))
    _shell(b)
    _structure(b)
    _gate(b)
    workshop.pipes(b, LENGTH, HEIGHT, DEPTH)
    _vehicles(b)
    _south_side(b, rng)
    _corners(b, rng)
    b.fit(triangles)
    b.description.set_environment(image=b.description.add_image(sky_image()))
    b.camera((11.7, 1.85, 5.6), (4.0, 0.4, 3.3), 54.0, size=(640, 480))
    return b


def sky_image() -> npt.NDArray[np.float32]:
    """The environment: lat-long radiance (224, 448, 3)."""
    return sky_with((SUN, *LAMPS), ROWS)


def _shell(b: Builder) -> None:
    x, y, z = LENGTH, HEIGHT, DEPTH
    concrete = b.glossy("concrete", (0.42, 0.41, 0.38), 0.04, 0.3)
    b.add(quad([0, 0, z], [x, 0, z], [x, 0, 0], [0, 0, 0]), concrete)
    shape = quad([x, -0.02, z + 2], [x + 5, -0.02, z + 2], [x + 5, -0.02, -2], [x, -0.02, -2])
    b.add(shape, "stone")
    _roof(b)
    wall(b, (0, 0), (x, 0), y, "plaster")
    wall(b, (0, 0), (0, z), y, "sage")
    wall(b, (0, z), (x, z), y, "plaster", [(*across, *WINDOW_Y) for across in WINDOWS])
    wall(b, (x, 0), (x, z), y, "plaster", [(GATE[0], GATE[1], 0.0, GATE[2])])


def _roof(b: Builder) -> None:
    """A slab with the openings of the roof lights, with a bar across each."""
    white, edge, start = b.paint("ceiling"), 0.08, -0.08
    near, far = ROOF_LIGHT_Z
    for left, right in (*ROOF_LIGHTS, (LENGTH + edge, LENGTH + edge)):
        b.add(box([start, HEIGHT, -edge], [left, HEIGHT + 0.2, DEPTH + edge]), white)
        if left < right:
            b.add(box([left, HEIGHT, -edge], [right, HEIGHT + 0.2, near]), white)
            b.add(box([left, HEIGHT, far], [right, HEIGHT + 0.2, DEPTH + edge]), white)
            for z in (near, (near + far) / 2, far):
                bar = soft_box((right - left, 0.08, 0.06), (6, 3, 3), power=9, bulge=0.1)
                b.add(bar, "steel", place([(left + right) / 2, HEIGHT + 0.1, z]))
        start = right


def _structure(b: Builder) -> None:
    """Columns on plinths with guards, and the joists of the ceiling."""
    column = soft_box((0.36, HEIGHT, 0.36), (7, 24, 7), power=9, bulge=0.02)
    plinth = soft_box((0.5, 0.3, 0.5), (8, 4, 8), power=7, bulge=0.05)
    b.add(column, "limestone", place([[x, HEIGHT / 2, z] for x, z in COLUMNS]))
    b.add(plinth, "mustard", place([[x, 0.12, z] for x, z in COLUMNS]))
    joist = soft_box((0.12, 0.24, DEPTH - 0.1), (4, 5, 40), power=14, bulge=0.03)
    x = np.arange(0.6, LENGTH, 1.2)
    b.add(joist, "beech", place(np.stack([x, 0 * x + 2.885, 0 * x + DEPTH / 2], -1)))


def _gate(b: Builder) -> None:
    """The sectional door, pushed up under the ceiling, with rails and rollers."""
    middle, width = (GATE[0] + GATE[1]) / 2, GATE[1] - GATE[0]
    white, steel = b.paint("white_paint"), b.paint("steel")
    for k in range(4):
        section = soft_box((0.58, 0.05, width - 0.1), (8, 3, 40), power=16, bulge=0.25)
        b.add(section, white, place([11.3 - 0.62 * k, 2.6, middle], roll=-1.5))
    for z in (GATE[0] - 0.04, GATE[1] + 0.04):
        rail = [[11.8, 0.1, z], [11.8, 2.2, z], [11.7, 2.5, z], [11.4, 2.56, z], [8.6, 2.6, z]]
        b.add(tube(rail, 0.035, 8, 60), steel)
        roller = cylinder(0.05, 0.06, 14)
        x = np.arange(8.9, 11.5, 0.62)
        b.add(roller, steel, place(np.stack([x, 0 * x + 2.58, 0 * x + z], -1), pitch=90))


def _vehicles(b: Builder) -> None:
    car(b, place([6.6, 0, 3.9], yaw=-3), b.glossy("red car", (0.42, 0.05, 0.04), 0.06, 0.2))
    car(b, place([6.0, 0, 1.15], yaw=182), b.glossy("blue car", (0.08, 0.16, 0.32), 0.06, 0.2))
    bicycle(b, place([5.3, 0.0, 7.45], yaw=8, pitch=9), "petrol")
    bicycle(b, place([11.4, 0.0, 6.9], yaw=95, pitch=7), "mustard")


def _south_side(b: Builder, rng: np.random.Generator) -> None:
    """What stands along the wall with the windows: racks, a workbench, tyres."""
    for k, x in enumerate((7.9, 9.0)):
        workshop.rack(b, place([x, 0, 7.62], yaw=180), rng, phase=k)
    bench = place([3.4, 0, 7.55], yaw=180)
    furniture.table(b, bench, (2.0, 0.62), "oak", 0.88)
    workshop.tools(b, bench @ place([0, 0.88, 0]))
    tyre_stack(b, place([6.5, 0, 7.5]), 4)
    tyre_stack(b, place([10.3, 0, 7.45]), 3)
    workshop.ladder(b, place([4.6, 0, 7.3], pitch=12), 2.4)


def _corners(b: Builder, rng: np.random.Generator) -> None:
    workshop.crates(b, place([10.9, 0, 0.75]), rng)
    workshop.crates(b, place([1.1, 0, 6.6], yaw=70), rng)
    workshop.barrel(b, place([9.75, 0, 2.9]), "brick_red")
    workshop.barrel(b, place([9.35, 0, 6.35]), "petrol")
    workshop.barrel(b, place([3.7, 0, 4.6]), "navy")
    workshop.hose(b, place([3.55, 0, 2.7]))
    workshop.rack(b, place([2.0, 0, 0.38]), rng, phase=2)
    b.add(cylinder(0.08, 0.5, 18, 6), "brick_red", place([4.2, 0.9, 5.47]))
