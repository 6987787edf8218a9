"""Builds and frees one structure again and again, and prints by how many bytes the process grew.

python cycles.py STRUCTURE CYCLES MOST
"""

import ctypes
import gc
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import viscache as vc

SIZE = (8, 8)
DIRECT = vc.Direct(n_area=1, n_environment=1, n_brdf=1)
#: Cycles before the first measurement: caches of the allocator and of Python fill.
WARM_UP = 100


def resident() -> int:
    """Bytes of the process in memory, after free pages were given back."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def scene() -> vc.Scene:
    """A scene of its own: 200 triangles and a sky."""
    rng = np.random.default_rng(0)
    vertices = rng.uniform(-1, 1, (600, 3)).astype(np.float32)
    sky = np.ones((4, 8, 3), np.float32)
    return vc.Scene.from_arrays(vertices, np.arange(600).reshape(-1, 3), env=sky)


KEPT = scene()
LEAK: list[bytes] = []


def frame(visibility: object = "exact", integrator: object = DIRECT, **options: object) -> None:
    vc.render(KEPT, integrator, visibility=visibility, size=SIZE, threads=2, **options)


def field() -> None:
    made = vc.VisibilityField(KEPT, settings=vc.Vlf(n_directions=9, n_tiles=8), threads=2)
    made.intersect([[0, 0, 3]], [[0, 0, -1]])


def moving() -> None:
    """A field whose triangles come, move and go."""
    made = vc.vlf.DynamicField(KEPT, vc.Vlf(n_directions=3, n_tiles=4, head_room=2.0))
    number = made.insert([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    made.transform(number, np.eye(4))
    made.delete(number)


def maps() -> None:
    made = vc.VisibilityMapCache(KEPT, vc.MapSettings(m=4, n_startup=10))
    made.update(size=SIZE, threads=2)
    with tempfile.TemporaryDirectory() as folder:
        made.save(Path(folder) / "maps.npz")
        vc.VisibilityMapCache.load(Path(folder) / "maps.npz", KEPT)


def passes() -> None:
    vc.Progressive(KEPT, DIRECT, size=SIZE, threads=2).passes(2)


def refused() -> None:
    """Errors leave nothing behind."""
    for triangles in ([[0, 1, 9]], [[0, 1]], [[0, -1, 2]]):
        try:
            vc.Scene.from_arrays(np.eye(3), triangles)
        except ValueError:
            continue
        raise AssertionError("such triangles are refused")


STRUCTURES: dict[str, Callable[[], object]] = {
    "scene": lambda: scene().content_hash,
    "embree": lambda: scene().visible([[0, 0, 3]], [[0, 0, -3]]),
    "bsp": lambda: scene().visible([[0, 0, 3]], [[0, 0, -3]], rays=vc.Bsp()),
    "field": field,
    "moving field": moving,
    "maps": maps,
    "relighting": lambda: vc.Relighting(
        vc.VisibilityMapCache(KEPT, vc.MapSettings(m=4, n_startup=10)), size=SIZE, threads=2
    ).under(1.0),
    "exact frame": frame,
    "quantized frame": lambda: frame("aqvc"),
    "pairs": lambda: frame(vc.Aqvc(table_bytes=1 << 16), vc.Bdpt(max_depth=3)),
    "kept table": lambda: frame("aqvc", keep=vc.AqvcTable(table_bytes=1 << 16)),
    "kept rows": lambda: frame("aqvc", keep=vc.AqvcRows()),
    "shadow maps": lambda: frame(vc.ShadowMap(resolution=16), vc.Whitted(n_vpls=2)),
    "roulette": lambda: frame(vc.NeePlusPlus(n_voxels=2, n_directions=4), keep=vc.VoxelCounts()),
    "aligned batch": lambda: vc.aligned_occlusion(KEPT, np.eye(3), np.eye(3), 33, threads=2),
    "connections": lambda: vc.connections(KEPT, DIRECT, size=SIZE, threads=2).answers("exact"),
    "progressive picture": passes,
    "sky": lambda: vc.Sky(sun_direction=(0, 1, 1)).image(16),
    "refused scenes": refused,
    "leak of 2 kB": lambda: LEAK.append(bytes(2048)),
}


def growth(structure: str, cycles: int, most: int) -> int:
    """Bytes by which the process grew over the cycles.

    Where it grew by `most` or more, the same cycles decide again, up to twice: a pool of a thread
    comes once for each thread, a leak comes again.
    """
    once = STRUCTURES[structure]
    for _ in range(WARM_UP):
        once()
    for _ in range(3):
        before = resident()
        for _ in range(cycles):
            once()
        grown = resident() - before
        if grown < most:
            break
    return grown


if __name__ == "__main__":
    print(growth(sys.argv[1], *map(int, sys.argv[2:])))
