"""Facts about a scene: numbers, coplanar triangles, distance from the origin."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.scene.coplanar import coplanar_share

MOST_COUNTED_TRIANGLES = 5_000_000
#: Distance from the origin, in sizes of the scene, that causes a warning.
FAR_AWAY = 1e3


def far_away(bounds: npt.NDArray[np.float32]) -> list[str]:
    """A warning if the distance from the origin costs precision."""
    low, high = bounds.astype(float)
    size = float(np.max(high - low))
    if not np.isfinite(size):
        return []
    if size == 0:
        where = ", ".join(f"{v:g}" for v in low)
        text = (
            f"all vertices are one point in single precision: give origin=({where}) if they differ"
        )
        return [text] if low.any() else []
    away = float(np.max(np.abs(low + high))) / 2 / size
    if away <= FAR_AWAY:
        return []
    steps = size / np.spacing(np.float32(away * size))
    digits = -math.floor(math.log10(size))
    near = ", ".join(f"{round(float(v), digits):g}" for v in (low + high) / 2)
    return [
        f"the scene lies {away:.3g} times its size from the origin, where single precision "
        f"leaves it {steps:.3g} steps across: give origin=({near}) to what makes it"
    ]


def sphere(scene: Any) -> tuple[npt.NDArray[np.float64], float]:
    """Centre (3,) and radius of the scene's bounding sphere."""
    return np.array(scene._core.center), scene._core.radius


def offset_extent(scene: Any) -> float:
    """The size by which rays from points near the origin are offset from their surfaces."""
    return float(scene._core.offset_extent)


def problems(scene: Any) -> list[str]:
    """See `Scene.warnings`."""
    texts = [
        f"{where}: {text}" if where else text for where, text in _core.scene_warnings(scene._core)
    ]
    if scene.triangles == 0:
        texts.append("the scene has no triangles; rays hit nothing")
    if not scene.lights:
        texts.append("the scene has no light; give it one with env=")
    return texts + far_away(scene.bounds)


def lit_coats(core: _core.Scene) -> list[str]:
    """A warning for light paths: lights without an extent show in the mirrors of smooth coats."""
    smooth = any(m["coat"] == _core.CoatKind.SMOOTH for m in _core.scene_materials(core))
    kinds = {light["kind"] for light in _core.scene_lights(core)} if smooth else set()
    if kinds.isdisjoint({"point", "directional"}):
        return []
    return [
        "bidirectional paths show point and directional lights in smooth coats, "
        "whose mirror is a narrow lobe"
    ]


def placed_coplanar_share(
    core: _core.Scene, meshes: Callable[[], list[dict[str, Any]]]
) -> float | None:
    """See `Scene.coplanar_share`."""
    if core.unique_triangles > MOST_COUNTED_TRIANGLES:
        return None
    listed = meshes()
    placed = np.array([int(m["in_world"]) for m in listed], dtype=float)
    for members, _ in _core.scene_instances(core):
        placed[list(members)] += 1
    counts = placed * [len(m["triangles"]) for m in listed]
    shares = [
        coplanar_share(m["vertices"], m["triangles"]) if count else 0.0
        for m, count in zip(listed, counts, strict=True)
    ]
    return float(counts @ shares / counts.sum()) if counts.sum() > 0 else 0.0


def info(scene: Any) -> dict[str, Any]:
    """See `Scene.info`."""
    bounds = [[float(str(v)) for v in corner] for corner in scene.bounds]
    return {
        "name": scene.name,
        "triangles": scene.triangles,
        "unique_triangles": scene._core.unique_triangles,
        "instances": scene._core.instances,
        "bounds": bounds,
        "lights": scene.lights,
        "cameras": [
            {
                "name": c.name,
                "origin": list(c.origin),
                "forward": list(c.forward),
                "size": [c.width, c.height],
            }
            for c in scene.cameras
        ],
        "memory_bytes": scene._core.memory_bytes,
        "coplanar_share": scene.coplanar_share,
        "content_hash": scene.content_hash,
        "warnings": scene.warnings,
    }
