"""Offsets against self-intersection, from 1e-6 to 1e6 units and up to 1e5 sizes off the origin.

`spawn` is transcribed from visibility/query.h; frames that use it are tested in
tests/render/test_closed_form.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from render.mitsuba_scene import Part, box, quad

pytestmark = pytest.mark.extreme

Array = npt.NDArray[Any]
OFFSET_ULPS, ULP = np.float32(8), np.float32(2.0**-23)
SCALES = [1e-6, 1e-3, 1.0, 1e3, 1e6]
AWAY = [0.0, 3.0, 1e2, 1e5]
N = 20_000


def turned(seed: int) -> Array:
    q: Array = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


def transform(scale: float, away: float, *, stretch: bool) -> Array:
    q = turned(3) @ np.diag([1, 0.7, 1.5] if stretch else [1, 1, 1])
    shift = away * np.array([1.0, 0.7, -0.3])
    return np.concatenate([q * scale, (shift * scale)[:, None]], axis=1)


def place(part: Part, scale: float, away: float, instanced: bool) -> tuple[vc.Scene, Array]:
    m = transform(scale, away, stretch=instanced)
    vertices = (part.vertices.astype(float) @ m[:, :3].T + m[:, 3]).astype(np.float32)
    if not instanced:
        return vc.Scene.from_arrays(vertices, part.triangles), vertices
    d = vc.SceneDescription()
    d.add_instance([d.add_mesh(part.vertices, part.triangles, in_world=False)], m)
    return vc.Scene.from_description(d), vertices


def surface_samples(vertices: Array, triangles: Array, seed: int) -> tuple[Array, Array]:
    """Points as `Scene::surface` makes them, in float, with normals of the outer side."""
    r = np.random.default_rng(seed)
    chosen = triangles[r.integers(0, len(triangles), N)]
    a, b, c = (vertices[chosen[:, i]] for i in range(3))
    uv = r.random((N, 2)).astype(np.float32)
    uv = np.where(uv.sum(1, keepdims=True) > 1, 1 - uv, uv).astype(np.float32)
    u, v = uv[:, :1], uv[:, 1:]
    p = a * (np.float32(1) - u - v) + b * u + c * v
    n = np.cross((b - a).astype(float), (c - a).astype(float))
    size = np.linalg.norm(n, axis=1)
    keep = size > 0
    return p[keep], (n[keep] / size[keep, None]).astype(np.float32)


def outgoing(n: Array, seed: int) -> Array:
    """Directions of the hemisphere, every other one grazing."""
    r = np.random.default_rng(seed)
    n = n.astype(float)
    d = r.normal(size=n.shape)
    d /= np.linalg.norm(d, axis=1)[:, None]
    up = np.einsum("ij,ij->i", d, n)
    along = d - n * up[:, None]
    along /= np.linalg.norm(along, axis=1)[:, None]
    grazing = along + n * 10.0 ** r.uniform(-7, -2, len(n))[:, None]
    d = np.where((np.arange(len(n)) % 2 == 0)[:, None], grazing, d * np.sign(up)[:, None])
    return d.astype(np.float32)


def spawn(p: Array, n: Array, extent: float) -> Array:
    offset = OFFSET_ULPS * ULP * np.maximum(np.abs(p).max(1), np.float32(extent))
    return (p + n * offset[:, None]).astype(np.float32)


SHAPES = {
    "quad": quad((-0.5, 0, -0.5), (0, 0, 1), (1, 0, 0)),
    "cube": box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)),
    "sliver": quad((-0.5, 0, -0.5), (0, 0, 1), (1e-3, 0, 0)),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("away", AWAY)
@pytest.mark.parametrize("instanced", [False, True])
def test_rays_that_leave_a_convex_surface_never_hit_it(
    shape: str, scale: float, away: float, instanced: bool
) -> None:
    scene, vertices = place(SHAPES[shape], scale, away, instanced)
    if shape == "sliver" and away == 1e5:
        pytest.skip("its width is below one unit in the last place")
    p, n = surface_samples(vertices, SHAPES[shape].triangles, 1)
    d = outgoing(n, 2)
    good = np.einsum("ij,ij->i", d.astype(float), n.astype(float)) > 0
    origin = spawn(p, n, scene._core.offset_extent)
    assert scene.occluded(origin[good], d[good]).sum() == 0
    # Without the offset the test would see plenty
    assert scene.occluded(p[good], d[good]).mean() > 0.01


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("away", AWAY)
def test_a_card_a_seventh_of_the_scene_away_still_blocks(scale: float, away: float) -> None:
    """At 1e5 sizes a unit in the last place is 1/128 of the scene; the offset stays below 1/8."""
    floor = quad((-0.5, 0, -0.5), (0, 0, 1), (1, 0, 0))
    card = quad((-0.5, 0.15625, -0.5), (0, 0, 1), (1, 0, 0))
    shift = np.array([away, away, -away])
    parts = [((q.vertices.astype(float) + shift) * scale).astype(np.float32) for q in (floor, card)]
    scene = vc.Scene.from_arrays(
        np.concatenate(parts), np.concatenate([floor.triangles, card.triangles + 4])
    )
    p, n = surface_samples(parts[0], floor.triangles, 3)
    up = np.broadcast_to(np.float32([0, 1, 0]), n.shape)
    assert (n == up).all()
    blocked = scene.occluded(spawn(p, n, scene._core.offset_extent), up)
    # Points that rounding moved over the card's edge pass beside it
    assert blocked.mean() > (0.999 if away < 1e5 else 0.95)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("away", AWAY)
def test_points_on_surfaces_see_each_other_through_free_space_only(
    scale: float, away: float
) -> None:
    """`visible` without normals: opposite walls see each other; a screen between them hides."""
    low = quad((-0.5, 0, -0.5), (0, 0, 1), (1, 0, 0))
    high = quad((-0.5, 1, -0.5), (0, 0, 1), (1, 0, 0))
    screen = quad((-2, 0.5, -2), (0, 0, 4), (4, 0, 0))
    shift = np.array([away, away, -away])

    def scene_of(*parts: Part) -> tuple[vc.Scene, list[Array]]:
        vertices = [((p.vertices.astype(float) + shift) * scale).astype(np.float32) for p in parts]
        faces = np.concatenate([p.triangles + 4 * i for i, p in enumerate(parts)])
        return vc.Scene.from_arrays(np.concatenate(vertices), faces), vertices

    free, (lower, upper) = scene_of(low, high)
    x, _ = surface_samples(lower, low.triangles, 1)
    y, _ = surface_samples(upper, high.triangles, 2)
    assert free.visible(x, y).all() and free.visible(y, x).all()
    hidden, _ = scene_of(low, high, screen)
    assert not hidden.visible(x, y).any() and not hidden.visible(y, x).any()


def test_visible_keeps_points_apart_that_touch_a_wall_from_both_sides() -> None:
    wall = vc.Scene.from_arrays([[-1, -1, 0], [1, -1, 0], [0, 2, 0]], [[0, 1, 2]])
    for gap in (1e-3, 1e-4):
        assert not wall.visible([[0, 0, gap]], [[0, 0, -gap]])[0]
        assert wall.visible([[0, 0, gap]], [[0, 0, 2 * gap]])[0]
