"""Bidirectional path tracing: against `Direct`, closed forms, and at its edges."""

from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from render import bdpt_scenes as scenes
from render.mitsuba_frames import assert_same, ours
from render.mitsuba_scene import Look, Model, ball, box, quad
from render.ztest import compare

SIZE = (24, 16)


def images(scene, integrator, spp, seeds, first=0):
    return ours(scene, integrator, spp=spp, seeds=seeds, first=first, size=SIZE)


@pytest.mark.stat
@pytest.mark.parametrize("camera", ["bypass", pytest.param("off", marks=pytest.mark.slow)])
def test_two_edges_are_direct_light_of_every_kind(camera):
    scene = scenes.LIGHTS.to_viscache()
    direct = images(scene, vc.Direct(n_area=32), 16, 6, first=100)
    bdpt = vc.Bdpt(max_depth=2, camera_connections=camera)
    assert_same(images(scene, bdpt, 128, 6), direct, power=0.02)
    for light in ("points", "directions", "spheres"):
        dark = replace(scenes.LIGHTS, **{light: ()}).to_viscache()
        assert not compare(images(dark, bdpt, 64, 6), direct).same, light


@pytest.mark.stat
def test_glossy_connections_have_one_expectation_for_all_strategies():
    """Densities of both ends of a connection are equal on diffuse surfaces, not on these."""
    look = Look(kind="glossy", base_color=(0.1, 0.1, 0.1), roughness=0.3)
    shiny = (replace(scenes.WALLS, look=look), scenes.LAMP, replace(scenes.BLOCK, look=look))
    room = replace(scenes.ROOM, parts=shiny).to_viscache()
    every = images(room, vc.Bdpt(max_depth=3), 32, 32)
    no_camera = images(room, vc.Bdpt(max_depth=3, camera_connections="off"), 32, 32, first=100)
    vc.testing.assert_unbiased(every, no_camera, energy=0.015)


@pytest.mark.stat
def test_a_lamp_that_shines_from_both_sides_is_direct_light():
    """Light paths leave either side; connections meet the side that faces them."""
    d = vc.SceneDescription()
    floor, lid = scenes.FLOOR, quad((-2, 2.2, -2), (4, 0, 0), (0, 0, 4))
    for part in (floor, lid, scenes.BLOCK):
        material = d.add_material(base_color=part.look.base_color)
        d.add_mesh(part.vertices, part.triangles, material=material)
    lamp = quad((-0.5, 1.4, 0.2), (1, 0, 0), (0, 0.1, 1))
    d.add_mesh(lamp.vertices, lamp.triangles, emission=(4, 3, 2), emits_two_sided=True)
    d.add_camera((0.3, 1.2, 3.5), (0, 1, 0), fov_deg=60)
    scene = vc.Scene.from_description(d)
    direct = images(scene, vc.Direct(n_area=32), 16, 6, first=100)
    assert_same(images(scene, vc.Bdpt(max_depth=2), 128, 6), direct, power=0.02)


def test_one_edge_is_emission_seen_directly():
    """The same eye paths as all integrators: the same light, without a query."""
    scene = scenes.LIGHTS.to_viscache()
    frame = vc.render(scene, vc.Bdpt(max_depth=1), size=SIZE, spp=8)
    direct = vc.render(scene, vc.Direct(), size=SIZE, spp=8)
    np.testing.assert_allclose(frame.image, direct.layers["emitted"], rtol=1e-5)
    for name in ("depth", "normal", "albedo", "coverage"):
        np.testing.assert_allclose(frame.layers[name], direct.layers[name], rtol=1e-4, atol=1e-5)
    assert frame.counters["queries"] == 0 and frame.image.max() > 0


@pytest.mark.stat
@pytest.mark.parametrize("camera", ["bypass", "off"])
def test_a_furnace_shines_by_the_geometric_series(camera):
    """A closed box of albedo 0.9 that emits 1: Σ 0.9^k over max_depth bounces, everywhere.

    With many bounces small errors of the weights add up: reverse densities that forget to turn the
    direction round make 1.3 % here.
    """
    look = Look(base_color=(0.9, 0.9, 0.9))
    walls = box((-1, -1, -1), (1, 1, 1), look=look, emission=(1, 1, 1)).reversed()
    scene = Model((walls,), origin=(0.2, 0.1, 0.3), target=(0, 0, -1)).to_viscache()
    for depth in (1, 2, 8):
        made = images(scene, vc.Bdpt(max_depth=depth, camera_connections=camera), 16, 8)
        means = made.mean(axis=(1, 2, 3)) / sum(0.9**k for k in range(depth))
        error = means.std(ddof=1) / np.sqrt(len(means))
        assert abs(means.mean() - 1) < 4 * error + 1e-6
        assert error < 0.0025


@pytest.mark.stat
def test_a_lamp_in_a_mirror_and_behind_glass_is_seen():
    """Only eye paths find these; sphere lights then count in full."""
    lamp = (((0.0, 1.0, 3.0), 0.4, (5.0, 4.0, 3.0)),)
    mirror = quad((-2, -1, 0), (4, 0, 0), (0, 4, 0), look=Look(kind="mirror"))
    pane = box((-2, -1, 0.5), (2, 3, 0.6), look=Look(kind="dielectric"))
    for part, origin in ((mirror, (0.0, 1.0, 2.0)), (pane, (0.0, 1.0, -2.0))):
        model = Model((part,), spheres=lamp, origin=origin, target=(0, 1, 0.3))
        scene = model.to_viscache()
        want = images(scene, vc.Whitted(n_vpls=0, max_depth=8), 64, 4)
        got = images(scene, vc.Bdpt(max_depth=9), 64, 4)
        assert want.max() > 1 and compare(got, want).same


LIT = {"points": (((0, 4, 0), (9, 9, 9)),), "env": (0.2, 0.3, 0.4)}
AROUND = ball((0, 1.5, 3), 1, 16, smooth=True, look=Look(kind="dielectric"))
MIRROR, BLACK = (
    replace(scenes.FLOOR, look=look) for look in (Look(kind="mirror"), Look(base_color=(0, 0, 0)))
)
EDGES = {
    "no light": scenes.OUTSIDE,
    "nothing but mirrors": Model((MIRROR,), **LIT),
    "the camera in glass": Model((scenes.FLOOR, AROUND), origin=(0, 1.5, 3), **LIT),
    "a light that is black": Model((scenes.FLOOR,), points=(((0, 2, 0), (0, 0, 0)),)),
    "a black surface": Model((BLACK,), env=(1, 1, 1)),
}


@pytest.mark.parametrize("name", EDGES)
def test_scenes_at_the_edge_give_finite_frames(name):
    scene = EDGES[name].to_viscache()
    for depth in (1, 2, 6):
        frame = vc.render(scene, vc.Bdpt(max_depth=depth), size=SIZE, spp=4)
        assert np.isfinite(frame.image).all() and (frame.image >= 0).all()
        assert frame.counters["non_finite"] == 0
    lit = EDGES[name].env is not None
    assert (frame.image.max() > 0) == lit
    if name in ("nothing but mirrors", "a black surface", "no light"):
        assert frame.counters["queries"] == 0


def test_bad_settings_are_refused_with_what_must_hold():
    for given, says in (
        ({"max_depth": 0}, r"max_depth must be in \[1, 64\], got 0"),
        ({"camera_connections": "on"}, "camera_connections must be"),
    ):
        with pytest.raises(ValueError, match=says):
            vc.Bdpt(**given)
