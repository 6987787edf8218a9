"""The self-test of `viscache doctor`, of about a second."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

import viscache as vc
from viscache_lab.extremes import Check


def checks(active: str, best: str) -> list[Check]:
    """The checks of the self-test."""
    scene = small_scene()
    asked = os.environ.get("VISCACHE_ISA")
    result = [
        Check(
            name="the kernels run the best variant this CPU has (or the one asked for)",
            value=int(active != (asked or best)),
            limit=0,
        ),
        Check(name="visible() agrees with plane geometry", value=_wrong_answers(scene), limit=0),
    ]
    direct = vc.Direct()
    exact = vc.render(scene, direct, size=(48, 32))
    shadow = float(np.mean(exact.image[:, :, 0] > 0))
    name = "the test picture has light and shadow"
    result.append(Check(name=name, value=shadow, limit=(0.02, 0.98)))
    tiny = vc.render(scene, direct, visibility=vc.Aqvc(c_e=0.01, exact_groups=()), size=(48, 32))
    error = vc.metrics.compare(tiny, exact, metrics=["max_abs"]).max_abs
    name = "the quantized cache at C_E = 0.01 gives the exact picture"
    result.append(Check(name=name, value=error, limit=0))
    cached = vc.Aqvc(c_e=8, exact_groups=())
    frames = [
        vc.render(scene, direct, visibility=cached, size=(80, 64), threads=t).sha256
        for t in (1, 2, 3)
    ]
    name = "1, 2 and 3 threads give the same bytes"
    result.append(Check(name=name, value=len(set(frames)) - 1, limit=0))
    return result


def small_scene() -> Any:
    """A floor, a triangle above it, a point light, a camera."""
    description = vc.SceneDescription()
    floor = np.array([[-4, 0, -4], [4, 0, -4], [4, 0, 4], [-4, 0, 4]], np.float32)
    quads = np.array([[0, 2, 1], [0, 3, 2]], np.uint32)
    material = description.add_material(base_color=(0.5, 0.5, 0.5))
    description.add_mesh(floor, quads, material=material)
    triangle = np.array([_A, _B, _C], np.float32)
    description.add_mesh(triangle, np.array([[0, 1, 2]], np.uint32), material=material)
    description.add_point_light((0.3, 4.0, 0.2), (20.0, 20.0, 20.0))
    description.add_camera((0.0, 5.0, 7.0), (0.0, 0.0, 0.0), width=48, height=32)
    return vc.Scene.from_description(description)


_A, _B, _C = (-1.0, 1.0, -1.0), (1.0, 1.0, -1.0), (0.0, 1.0, 1.0)


def _wrong_answers(scene: Any) -> int:
    """Number of segments through the triangle's plane whose answer is wrong."""
    rng, n = np.random.default_rng(0), 4000
    below = np.column_stack([rng.uniform(-2, 2, n), np.full(n, 0.5), rng.uniform(-2, 2, n)])
    above = np.column_stack([rng.uniform(-2, 2, n), np.full(n, 1.5), rng.uniform(-2, 2, n)])
    crossing = (0.5 * (below + above))[:, [0, 2]]
    corners = np.array([_A, _B, _C])[:, [0, 2]]
    edges = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(edges, axis=1)
    to = crossing[:, None, :] - corners[None]
    side = (edges[None, :, 0] * to[:, :, 1] - edges[None, :, 1] * to[:, :, 0]) / lengths
    clear = np.abs(side).min(axis=1) > 1e-3  # not on an edge, where rounding decides
    expected = ~(side > 0).all(axis=1)
    seen = scene.visible(below.astype(np.float32), above.astype(np.float32))
    return int((seen != expected)[clear].sum())
