"""Every visibility setting on `Embree(watertight=True)`: bits of the BSP, closed at vertices."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import viscache as vc
from oracles.test_oracle import area_points, lamps
from oracles.test_written import Rays
from reference.built import built
from viscache_lab.extremes import scenes
from viscache_lab.extremes.families.leaks import SHAPES
from viscache_lab.extremes.families.moves import turn
from viscache_lab.extremes.pictures import METHODS, picture

WATERTIGHT = vc.Embree(watertight=True)
#: Rows of the table of methods that leave the choice of rays.
FREE = {
    name: method
    for name, method in METHODS.items()
    if "rays" not in method.settings and "shafts" not in name
}


def test_every_setting_is_among_the_methods():
    used = {type(m.settings.get("visibility", vc.Exact())) for m in FREE.values()}
    assert used == {vc.Exact, vc.Aqvc, vc.ShadowMap, vc.NeePlusPlus, vc.VisMaps}


@pytest.mark.parametrize("name", FREE)
def test_frames_are_those_of_the_bsp(name):
    method = FREE[name]
    ours, bsp, plain = (
        picture(scenes.lit_box(), replace(method, settings=method.settings | {"rays": rays}))
        for rays in (WATERTIGHT, vc.Bsp(), vc.Embree())
    )
    assert ours.sha256 == bsp.sha256
    assert ours.counters["rays"] == bsp.counters["rays"] > 0
    np.testing.assert_allclose(ours.image.mean(), plain.image.mean(), rtol=0.01)


@pytest.mark.parametrize("visibility", [Rays(), vc.Unoccluded()], ids=["own", "unoccluded"])
@pytest.mark.parametrize("integrator", [vc.Direct(), vc.Bdpt(), vc.AmbientOcclusion()])
def test_other_oracles_and_integrators_are_those_of_the_bsp(integrator, visibility):
    given = {"size": (16, 12), "visibility": visibility, "threads": 1}
    ours, bsp = (
        vc.render(scenes.lit_box(), integrator, rays=rays, **given)
        for rays in (WATERTIGHT, vc.Bsp())
    )
    assert ours.sha256 == bsp.sha256 and ours.image.any()


#: Settings that answer arrays of points.
SETTINGS = {
    "exact": vc.Exact(),
    "quantized": vc.Aqvc(c_e=6, exact_groups=()),
    "quantized pairs": vc.Aqvc(c_e=6, exact_groups=(), paper=vc.PaperForm(form="pairs")),
    "shadow maps": vc.ShadowMap(resolution=16),
    "NEE++": vc.NeePlusPlus(n_voxels=8),
    "own": Rays(),
}


@pytest.mark.parametrize("use", ["replace", "correct"])
@pytest.mark.parametrize("name", SETTINGS)
def test_answers_for_points_are_those_of_the_bsp(name, use):
    scene = built("room?triangles=3000")
    eyes, ends = area_points(scene, 500), lamps(scene, 70)
    near = lamps(scene, 500, seed=5)
    index = np.random.default_rng(3).permutation(500)
    found = []
    for rays in (WATERTIGHT, vc.Bsp()):
        oracle = scene.oracle(SETTINGS[name], rays=rays, use=use)
        block, pairs = oracle.block(eyes, ends), oracle.pairs(eyes, index, near)
        found.append((block.visible.copy(), block.weights, pairs.visible.copy(), pairs.weights))
    for ours, bsp in zip(*found, strict=True):
        np.testing.assert_array_equal(ours, bsp)
    assert 0.05 < found[0][0].mean() < 0.95


@cache
def closed():
    """A flat sphere at an angle, and its vertices."""
    vertices, triangles = SHAPES["sphere 1/1000 as high"][0]()
    vertices = vertices @ turn(0).T
    return vc.Scene.from_arrays(vertices, triangles), vertices


def leaks(visibility, rays):
    """Rays from inside of the sphere through its vertices that get out: of blocks, of pairs."""
    scene, vertices = closed()
    rng = np.random.default_rng(1)
    inside = (rng.uniform(-0.5, 0.5, (100, 3)) * [1, 1e-3, 1] @ turn(0).T).astype(np.float32)
    up = np.broadcast_to(turn(0) @ [0, 1, 0], inside.shape)
    eyes = vc.EyePoints(inside, up, density=1e3, _origins=inside)
    oracle = scene.oracle(visibility, rays=rays, threads=1)
    ends = [vc.FarEnds.points(p + 3 * (vertices - p)) for p in inside.astype(float)]
    of_blocks = sum(
        int(oracle.block(eyes[i], through).visible.sum()) for i, through in enumerate(ends)
    )
    every = vc.FarEnds.points(np.concatenate([through.positions for through in ends]))
    index = np.repeat(np.arange(len(inside)), len(vertices))
    return of_blocks, int(oracle.pairs(eyes, index, every).visible.sum())


@pytest.mark.parametrize(
    "visibility",
    [vc.Exact(), vc.Aqvc(c_e=1e-3, exact_groups=()), Rays()],
    ids=["exact", "quantized", "own"],
)
def test_no_oracle_lets_light_through_a_vertex(visibility):
    assert leaks(visibility, WATERTIGHT) == (0, 0)


def test_oracles_on_plain_rays_let_light_through_so_that_the_test_can_fail():
    of_blocks, of_pairs = leaks(vc.Exact(), vc.Embree())
    assert of_blocks > 5 and of_pairs > 5
