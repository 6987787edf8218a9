"""Shared by the visibility field's figures: rays, tracers tuned by a grid search, CPU seconds."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.scene.about import offset_extent
from viscache.settings.rays import Rays
from viscache_lab.cases.beams import Beams
from viscache_lab.experiment.amounts import turns
from viscache_lab.figures import vlf_printed as printed

Floats: TypeAlias = npt.NDArray[np.float32]

#: The searched grids: depth and leaf size of the BSP, depth of the field's tiles.
BSP_DEPTHS, BSP_LEAVES = (12, 14, 16, 18, 20, 22, 24, 26), (2, 4, 8, 16)
QUICK_BSP_DEPTHS, QUICK_BSP_LEAVES = (14, 18), (4, 16)
FIELD_DEPTHS, QUICK_FIELD_DEPTHS = (0, 1, 2, 3, 4, 5, 6), (0, 3)
QUICK_DIRECTIONS, QUICK_TILES = 129, 64
#: Rays that a grid search traces.
TRIAL_RAYS = 20_000
MAX_BYTES = 6 << 30
#: Offset of ray origins from a surface, as in visibility/query.h: units in the last place.
OFFSET = 8 * 2.0**-23


@dataclass(frozen=True, kw_only=True, slots=True)
class Tuned:
    """A tracer with the fastest parameters of a grid."""

    settings: Rays
    caster: Any
    build_s: float
    """CPU seconds of all threads."""
    nbytes: int

    @property
    def text(self) -> str:
        """The parameters, as text for a note."""
        s = self.settings
        if isinstance(s, vc.Bsp):
            kind = f"depth {s.max_depth}, leaf {s.leaf_size}"
        elif isinstance(s, vc.Vlf):
            kind = f"l {s.n_directions}, n {s.n_tiles}, depth {s.bsp_depth}"
        else:
            kind = "robust" if s.robust else "not robust"
        return f"{kind}, {self.nbytes / 1e6:.1f} MB, built in {self.build_s:.2f} CPU s"


def cpu_seconds(run: Callable[[], Any], repeats: int = 2) -> float:
    """The smallest CPU seconds of several runs."""
    best = math.inf
    for _ in range(repeats):
        start = time.process_time()
        run()
        best = min(best, time.process_time() - start)
    return best


def in_turns(
    runs: Mapping[str, Callable[[], Any]], repeats: int = 3, answers: dict[str, Any] | None = None
) -> dict[str, float]:
    """The smallest CPU seconds of each; they take turns, so a busy machine slows all of them."""
    samples, given = turns(runs, repeats, warm_up=False)
    if answers is not None:
        answers |= given
    return {name: min(s.cpu_s for s in some) for name, some in samples.items()}


def tracers(scene: vc.Scene, beams: Beams, quick: bool, *, lazy: bool = False) -> dict[str, Tuned]:
    """The paper's two tracers, tuned for some rays, and Embree's two."""
    return {
        "CRT": best_bsp(scene, beams, quick),
        "VLF-RT": best_field(scene, beams, quick, lazy=lazy),
        "Embree": embree(scene),
        FAST_EMBREE: embree(scene, robust=False),
    }


def best_bsp(scene: vc.Scene, beams: Beams, quick: bool) -> Tuned:
    """The fastest BSP for some rays, from the paper's pre-test over depth and leaf size."""
    depths, leaves = (QUICK_BSP_DEPTHS, QUICK_BSP_LEAVES) if quick else (BSP_DEPTHS, BSP_LEAVES)
    grid = (vc.Bsp(max_depth=d, leaf_size=n, kernel="wald") for d in depths for n in leaves)
    return _best(scene, beams, grid)


def best_field(scene: vc.Scene, beams: Beams, quick: bool, *, lazy: bool = False) -> Tuned:
    """The fastest field over tile depths, with the paper's directions and tiles."""
    axes, n = (QUICK_DIRECTIONS, QUICK_TILES) if quick else (printed.DIRECTIONS, printed.TILES)
    depths = QUICK_FIELD_DEPTHS if quick else FIELD_DEPTHS
    base = vc.Vlf(n_directions=axes, n_tiles=n, kernel="wald", lazy=lazy, max_bytes=MAX_BYTES)
    return _best(scene, beams, (replace(base, bsp_depth=d) for d in depths))


def _best(scene: vc.Scene, beams: Beams, candidates: Iterable[vc.Bsp | vc.Vlf]) -> Tuned:
    trial = beams.some(TRIAL_RAYS)

    def seconds(settings: vc.Bsp | vc.Vlf) -> float:
        caster = settings.build(scene)
        trial.trace(caster)  # the first rays build a lazy field
        return cpu_seconds(partial(trial.trace, caster))

    chosen = min(candidates, key=seconds)
    start = time.process_time()
    caster: Any = chosen.build(scene)
    if isinstance(chosen, vc.Vlf) and chosen.lazy:
        beams.trace(caster)
    built = time.process_time() - start
    return Tuned(settings=chosen, caster=caster, build_s=built, nbytes=caster.stats["bytes"])


#: Embree without its robust flag: it leaks at edges, as Wald's test of the others does.
FAST_EMBREE = "fast Embree"


def embree(scene: vc.Scene, *, robust: bool = True) -> Tuned:
    """Embree with the flag that all other rays of this package have, or without it."""
    settings = vc.Embree(robust=robust)
    start = time.process_time()
    caster = settings.build(scene)
    # Embree does not report its bytes; about 100 per triangle were measured
    return Tuned(
        settings=settings,
        caster=caster,
        build_s=time.process_time() - start,
        nbytes=100 * scene.triangles,
    )


def camera_rays(camera: vc.Camera, size: tuple[int, int]) -> Beams:
    """Rays through the pixel centres, row by row."""
    width, height = size
    half = math.tan(camera.fov_rad / 2)
    across = half if camera.fov_is_horizontal else half * width / height
    x = across * ((np.arange(width) + 0.5) / width * 2 - 1)
    y = across * height / width * (1 - (np.arange(height) + 0.5) / height * 2)
    forward, right, up = (np.asarray(v) for v in (camera.forward, camera.right, camera.up))
    d = forward + x[None, :, None] * right + y[:, None, None] * up
    d = (d / np.linalg.norm(d, axis=-1, keepdims=True)).reshape(-1, 3).astype(np.float32)
    o = np.broadcast_to(np.asarray(camera.origin, np.float32), d.shape).copy()
    return Beams(origins=o, directions=d)


def first_hits(
    scene: vc.Scene, camera: vc.Camera, size: tuple[int, int]
) -> tuple[Floats, Floats, npt.NDArray[np.bool_]]:
    """Points (N, 3) that pixels see, normals towards the camera, which pixels (H, W) see one."""
    beams = camera_rays(camera, size)
    hit = scene.intersect(beams.origins, beams.directions)
    seen = hit.triangle >= 0
    # No scene here has instances
    corners = np.concatenate([m["vertices"][m["triangles"]] for m in scene.meshes()]).astype(float)
    a, b, c = (corners[hit.triangle[seen], i] for i in range(3))
    w = hit.barycentrics[seen].astype(float)
    positions = a + w[:, :1] * (b - a) + w[:, 1:] * (c - a)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    facing = np.einsum("nk,nk->n", normals, beams.directions[seen]) > 0
    normals[facing] *= -1
    return (
        positions.astype(np.float32),
        normals.astype(np.float32),
        seen.reshape(size[1], size[0]),
    )


def starts(scene: vc.Scene, points: Floats, normals: Floats) -> Floats:
    """Origins of rays that leave the points' surfaces."""
    extent = np.float32(offset_extent(scene))
    size = np.maximum(np.abs(points).max(axis=1, keepdims=True), extent)
    return np.asarray(points + normals * (np.float32(OFFSET) * size), np.float32)


def free_bits(
    scene: vc.Scene, points: Floats, normals: Floats, count: int, engine: Any = "auto"
) -> npt.NDArray[np.bool_]:
    """(N, l): which of l directions are unoccluded."""
    words = vc.vlf.aligned_occlusion(scene, points, normals, count, engine=engine)
    return np.unpackbits(words.view(np.uint8), axis=1, bitorder="little")[:, :count].astype(bool)
