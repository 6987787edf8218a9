"""A classroom for walks: desks in rows, four lamps, and a path between the rows."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from viscache import _core
from viscache.scenes import decor, fixtures, furniture, walls
from viscache.scenes.builder import Builder
from viscache.scenes.registry import MOST_TRIANGLES, Range, scene
from viscache.scenes.shapes import Array, box, cylinder, place, smooth_path, tube
from viscache.settings.checks import is_whole, require

SEED = 2007
LEAST = 1000
#: Half the room's width and length, and its height, in metres.
WIDTH, HEIGHT, LENGTH = 4.6, 3.2, 5.0
COLUMNS, ROWS = (-3.3, -1.45, 1.45, 3.3), (-2.2, -0.8, 0.6, 2.0, 3.4)
FRAMES = 420
#: From the door up the middle, along the board, down between the outer rows and back.
PATH = ((0.1, 1.65, 4.5), (0.0, 1.6, 2.4), (0.05, 1.55, -0.6), (-0.2, 1.6, -3.0),
        (-2.35, 1.65, -3.4), (-2.38, 1.6, -1.0), (-2.36, 1.55, 1.6), (-2.3, 1.65, 4.3))  # fmt: skip
TARGETS = ((0.0, 1.1, -4.0), (0.4, 1.0, -4.0), (1.6, 0.9, -3.0), (3.0, 0.9, -0.5), (1.0, 0.8, 1.5),
           (0.5, 0.8, 2.6), (1.2, 0.9, 3.2), (1.8, 1.0, -1.0))  # fmt: skip


@scene()
def classroom_like(triangles: Annotated[int, Range(LEAST, MOST_TRIANGLES)] = 51_208) -> Builder:
    """Classroom of 9.2 x 3.2 x 10 m with twenty desks under four point lights.

    Parameters
    ----------
    triangles : int
        Exact number; what shapes leave over becomes paper on the floor. At least 1000.
    """
    b, rng = Builder("classroom_like"), np.random.Generator(np.random.PCG64(SEED))
    walls.shell(b, (WIDTH, HEIGHT, LENGTH), "floor_oak", ("cream", "plaster", "sage", "plaster"))
    _pupils(b, rng)
    _front(b, rng)
    _walls(b, rng)
    for x in (-2.3, 2.3):
        for z in (-2.2, 2.2):
            b.add(cylinder(0.2, 0.08, 20), "porcelain", place([x, HEIGHT - 0.13, z]))
            rod = [[x, HEIGHT - 0.06, z], [x, HEIGHT, z]]
            b.add(tube(rod, 0.01, 6, 3), "black_metal", optional=True)
            b.point_light((x, HEIGHT - 0.32, z), 11.0 * np.array([1.0, 0.95, 0.86]))
    _scraps(b, rng, b.fit_below(triangles))
    b.camera(PATH[0], TARGETS[0], 60.0, name="door", size=(256, 256))
    b.camera((-3.9, 2.3, -4.2), (0.8, 0.7, 1.2), 66.0, name="board", size=(256, 256))
    return b


def classroom_camera(frame: int, frames: int = FRAMES) -> _core.Camera:
    """A camera of the walk through `classroom_like`.

    Parameters
    ----------
    frame : int in [0, frames)
    frames : int >= 2
        Number of frames of the whole walk.

    Examples
    --------
    >>> import viscache as vc
    >>> vc.scenes.classroom_camera(0).origin[2] > vc.scenes.classroom_camera(200).origin[2]
    True
    """
    Range(2, 1_000_000).check("frames", frames, whole=True)
    require(is_whole(frame) and 0 <= frame < frames, f"frame must be in [0, {frames})", frame)
    origin, target = (smooth_path(points, frames)[frame].tolist() for points in (PATH, TARGETS))
    return _core.look_at(tuple(origin), tuple(target), (0.0, 1.0, 0.0), 60.0)


def _pupils(b: Builder, rng: np.random.Generator) -> None:
    """Two seats per desk, slightly rotated."""
    for x in COLUMNS:
        for z in ROWS:
            desk = place([x, 0, z])
            furniture.table(b, desk, (1.25, 0.55), "beech", 0.73)
            seats = place([[-0.32, 0, 0.5], [0.32, 0, 0.52]], yaw=180 + rng.uniform(-14, 14, 2))
            furniture.chair(b, desk @ seats, "oak")
            if rng.random() < 0.6:
                turn = rng.uniform(-30, 30)
                spot = desk @ place([rng.uniform(-0.4, 0.4), 0.732, -0.05], yaw=turn)
                decor.book_pile(b, spot, rng, int(rng.integers(1, 4)))


def _front(b: Builder, rng: np.random.Generator) -> None:
    board = box([-2.0, 0.9, -LENGTH + 0.01], [2.0, 2.2, -LENGTH + 0.04])
    b.add(board, b.glossy("board", (0.02, 0.06, 0.04), 0.06, 0.2))
    ledge = [[-2.0, 0.88, -LENGTH + 0.08], [0, 0.88, -LENGTH + 0.085], [2.0, 0.88, -LENGTH + 0.08]]
    b.add(tube(ledge, 0.02, 8, 16), "oak")
    desk = place([2.9, 0, -3.7], yaw=180)
    furniture.table(b, desk, (1.5, 0.7), "walnut", 0.75)
    furniture.desk_chair(b, place([2.9, 0, -4.3]), "petrol")
    decor.book_pile(b, desk @ place([-0.5, 0.752, 0]), rng, 5)
    fixtures.laptop(b, desk @ place([0.1, 0.752, 0.05]))
    decor.cup(b, desk @ place([0.5, 0.752, 0.1]), "brick_red")


def _walls(b: Builder, rng: np.random.Generator) -> None:
    furniture.bookshelf(b, place([WIDTH - 0.03, 0, 3.2], yaw=-90), rng, height=1.9, shelves=4)
    furniture.cabinet(b, place([-3.4, 0, LENGTH - 0.03], yaw=180), (1.6, 1.0, 0.45), "oak")
    decor.plant(b, place([3.9, 0, 4.5]), rng, height=1.5, leaves=160)
    for z in (-2.0, 0.0, 2.0):
        fixtures.radiator(b, place([-WIDTH + 0.02, 0, z], yaw=90), 1.1)
        frame = place([-WIDTH + 0.004, 1.9, z], yaw=90)
        decor.picture(b, frame, (1.0, 0.75), "navy petrol sky cream", z)


def _scraps(b: Builder, rng: np.random.Generator, count: int) -> None:
    """`count` triangles of torn paper on the floor."""
    if count == 0:
        return
    reach = np.array([WIDTH - 0.2, 0, LENGTH - 0.2])
    centers = rng.uniform(-1, 1, (count, 3)) * reach + [0, 0.004, 0]
    turns = rng.uniform(0, 2 * np.pi, (count, 1)) + np.array([0, 2.1, 4.2])
    lift = rng.uniform(0, 0.02, (count, 3))
    corners: Array = np.stack([0.03 * np.cos(turns), lift, 0.03 * np.sin(turns)], axis=-1)
    triangles = np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)
    vertices = (centers[:, None] + corners).reshape(-1, 3)
    b.add_mesh(vertices, triangles, b.diffuse("paper", (0.75, 0.74, 0.7)), name="paper")
