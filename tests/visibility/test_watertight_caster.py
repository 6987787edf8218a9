"""Embree's candidates with our edge test: the hits of the BSP, and nothing passes a vertex."""

import numpy as np
import pytest

import viscache as vc
from viscache_lab.extremes.families.leaks import SHAPES, segments
from viscache_lab.extremes.families.moves import turn
from visibility.soup import rays, soup

WATERTIGHT = vc.Embree(watertight=True)


def scenes():
    vertices, triangles = soup(300, 0.3)
    placed = vc.SceneDescription()
    mesh = placed.add_mesh(vertices, triangles, in_world=False)
    placed.add_mesh(vertices, triangles)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    for scale, x in ((0.5, 3.0), (2.0, -4.0)):
        placed.add_instance([mesh], np.concatenate([scale * turn, [[x], [0.5], [1.0]]], axis=1))
    grid = np.stack(np.meshgrid(*[np.arange(5.0)] * 2, [0.0]), -1).reshape(-1, 3)
    faces = [[i, i + 1, i + 6] for i in range(19) if i % 5 < 4]
    return {
        "soup": vc.Scene.from_arrays(vertices, triangles),
        "far": vc.Scene.from_arrays(vertices + np.float32([900, -700, 300]), triangles),
        "tiny": vc.Scene.from_arrays(vertices * np.float32(1e-6), triangles),
        "huge": vc.Scene.from_arrays(vertices * np.float32(1e6), triangles),
        "instances": vc.Scene.from_description(placed),
        "flat": vc.Scene.from_arrays(grid, faces),
        "four times in one place": vc.Scene.from_arrays(vertices, np.tile(triangles, (4, 1))),
    }


SCENES = scenes()


@pytest.mark.parametrize("name", SCENES)
def test_hits_are_those_of_the_bsp_bit_for_bit(name):
    scene = SCENES[name]
    o, d = rays(20_000, along=True)
    low, high = scene.bounds
    o = (0.5 * (low + high) + o * 0.5 * np.max(high - low)).astype(np.float32)
    ours, bsp = (scene.intersect(o, d, rays=r) for r in (WATERTIGHT, vc.Bsp()))
    assert 0.03 < (bsp.triangle >= 0).mean() < 0.99
    for a, b in zip(ours, bsp, strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(scene.occluded(o, d, rays=WATERTIGHT), bsp.triangle >= 0)
    half = np.where(np.isfinite(bsp.t), bsp.t * np.float32(0.5), 1).astype(np.float32)
    np.testing.assert_array_equal(
        scene.occluded(o, d, half, rays=WATERTIGHT), scene.occluded(o, d, half, rays=vc.Bsp())
    )


@pytest.mark.parametrize("radii", [3.9, 4.1, 1e3, 1e6, 1e9])
def test_rays_may_come_from_far_away(radii):
    """Aimed at points of triangles from outside, so each of them hits something nearer or that."""
    vertices, triangles = soup(300, 0.3)
    scene = SCENES["soup"]
    rng = np.random.default_rng(5)
    targets = vertices[triangles[rng.integers(0, len(triangles), 2_000)]].mean(axis=1)
    d = rng.normal(size=(2_000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    o = (targets - d * radii * scene._core.radius).astype(np.float32)
    toward = (targets - o).astype(np.float32)
    hit = scene.intersect(o, toward, rays=WATERTIGHT)
    assert (hit.triangle >= 0).mean() > (0.999 if radii < 1e5 else 0.2)
    met = hit.triangle >= 0
    assert (hit.t[met] <= 1 + 1e-3).all() and (hit.t[met] > 0).all()
    assert not scene.occluded(o, -toward, rays=WATERTIGHT).any()
    np.testing.assert_array_equal(scene.occluded(o, toward, rays=WATERTIGHT), met)


def leaks(shape, rotated, rays, n, seed=7):
    """Of n segments through vertices and edges of a closed shape, those that get out."""
    vertices, triangles = SHAPES[shape][0]()
    scene = vc.Scene.from_arrays(vertices @ turn(0).T if rotated else vertices, triangles)
    inside, outside = segments(shape, rotated, n, aimed=True, seed=seed)
    return int(scene.visible(inside, outside, rays=rays).sum())


@pytest.mark.parametrize("rotated", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
def test_no_ray_passes_an_edge_or_a_vertex(shape, rotated):
    assert leaks(shape, rotated, WATERTIGHT, 50_000) == 0


def test_robust_rays_pass_vertices_so_that_the_test_can_fail():
    assert leaks("sphere 1/1000 as high", True, vc.Embree(), 50_000) > 20


@pytest.mark.release
def test_none_of_fifty_million_rays_passes():
    found = {
        (shape, rotated): sum(
            leaks(shape, rotated, WATERTIGHT, 625_000, seed) for seed in range(10)
        )
        for shape in SHAPES
        for rotated in (False, True)
    }
    assert found == dict.fromkeys(found, 0)


def test_without_the_robust_flag_it_is_refused():
    with pytest.raises(ValueError, match="robust must be True with watertight"):
        vc.Embree(robust=False, watertight=True)


@pytest.mark.extreme
@pytest.mark.parametrize("length", [5e-39, 1e-37, 1.0, 1e15])
def test_directions_of_any_length_find_their_hit(length):
    scene = vc.Scene.from_arrays([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], [[0, 1, 2]])
    down = np.float32([[0, 0, -length]])
    hit = scene.intersect([[0, 0, 1]], down, rays=WATERTIGHT)
    assert hit.triangle[0] == 0 and hit.t[0] == pytest.approx(1 / length, rel=1e-5)
    behind = scene.intersect([[0, 0, -1]], down, rays=WATERTIGHT)
    assert behind.triangle[0] == -1
