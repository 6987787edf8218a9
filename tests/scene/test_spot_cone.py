"""Spot lights: the falloff of three formats, in direct light, light paths and virtual lights."""

from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from render import bdpt_scenes as scenes
from render.mitsuba_scene import ball
from render.ztest import compare

SIZE = (24, 16)
INNER, OUTER = 20.0, 40.0
FALLOFFS = ["angle", "quadratic", "quartic", "smooth"]


def factor(angle_deg, falloff, inner=INNER, outer=OUTER):
    """The formulas as Mitsuba 3, glTF, pbrt-v3 and pbrt-v4 state them."""
    cosine, low, high = (np.cos(np.radians(a)) for a in (angle_deg, outer, inner))
    t = np.clip((cosine - low) / (high - low), 0, 1)
    linear = np.clip((outer - np.asarray(angle_deg)) / (outer - inner), 0, 1)
    return {"angle": linear, "quadratic": t**2, "quartic": t**4, "smooth": t * t * (3 - 2 * t)}[
        falloff
    ]


def under_a_lamp(falloff, look=None, **cone):
    """A floor of albedo 0.8 under a lamp 2 above it, seen from high above."""
    d = vc.SceneDescription()
    material = d.add_material(**(look or {"base_color": (0.8, 0.8, 0.8)}))
    x = 8.0
    corners = [(-x, 0, -x), (-x, 0, x), (x, 0, x), (x, 0, -x)]
    d.add_mesh(corners, [(0, 1, 2), (0, 2, 3)], material=material)
    settings = {"axis": (0, -3, 0), "cone_deg": (INNER, OUTER), "falloff": falloff} | cone
    d.add_point_light((0, 2, 0), (3, 2, 1), **settings)
    d.add_camera((0, 30, 0.01), (0, 0, 0), fov_deg=8)
    return vc.Scene.from_description(d)


def seen(scene):
    """Colour and the angle from the axis of the lamp, of each pixel's centre."""
    frame = vc.render(scene, vc.Direct(), size=(64, 64), spp=1)
    height = 30 * np.tan(np.radians(4))
    grid = ((np.arange(64) + 0.5) / 32 - 1) * height
    radius = np.hypot(*np.meshgrid(grid, grid))
    return frame.image, np.degrees(np.arctan2(radius, 2))


@pytest.mark.parametrize("falloff", FALLOFFS)
def test_direct_light_is_the_formula_of_the_format(falloff):
    image, angle = seen(under_a_lamp(falloff))
    cosine = np.cos(np.radians(angle))
    # A pixel is 0.07 wide, up to 2 degrees
    low, high = (factor(np.maximum(angle + d, 0), falloff) for d in (1.5, -1.5))
    plain = 0.8 / np.pi * 3 * cosine**3 / 4
    red = image[..., 0]
    assert np.all(red <= high * plain * 1.1 + 1e-6) and np.all(red >= low * plain * 0.9 - 1e-6)
    assert np.all(image[angle > OUTER + 1.5] == 0) and np.all(red[angle < INNER - 1.5] > 0)
    total, expected = red.sum(), (factor(angle, falloff) * plain).sum()
    assert total == pytest.approx(expected, rel=5e-3)
    # Power: the other formulas give another sum
    for other in FALLOFFS:
        if other != falloff:
            assert abs((factor(angle, other) * plain).sum() / expected - 1) > 0.02


def test_glossy_floors_see_the_same_cone():
    glossy = {"kind": vc._core.MaterialKind.GLOSSY, "roughness": 0.4, "specular": (0.3, 0.3, 0.3)}
    image, angle = seen(under_a_lamp("smooth", glossy))
    whole, _ = seen(under_a_lamp("smooth", glossy, cone_deg=(80.0, 85.0)))
    inside = angle < INNER - 1.5
    np.testing.assert_allclose(image[inside], whole[inside], rtol=1e-5)
    assert np.all(image[angle > OUTER + 1.5] == 0) and np.all(whole > 0)


def test_the_back_of_a_spot_light_is_dark():
    image, _ = seen(under_a_lamp("smooth", axis=(0, 1, 0)))
    assert np.all(image == 0)
    frame = vc.render(under_a_lamp("smooth", axis=(0, 1, 0)), vc.Direct(), size=(8, 8))
    assert frame.counters["queries"] == 0


def test_a_cone_of_180_degrees_is_a_point_light():
    whole, _ = seen(under_a_lamp("smooth", cone_deg=(180.0, 180.0)))
    point, _ = seen(under_a_lamp("smooth", axis=None))
    np.testing.assert_array_equal(whole, point)


def with_spots(model=scenes.OUTSIDE):
    spots = (
        ((1.2, 2.2, 1.4), (9, 7, 5), (-0.5, -0.8, -0.5), (12.0, 30.0)),
        ((-1.5, 1.2, 1.0), (2, 3, 5), (1, -0.6, -0.4), (5.0, 60.0)),
    )
    return replace(model, points=(), directions=(), spheres=(), env=None, spots=spots)


def images(scene, integrator, spp, seeds, first=0):
    made = [vc.render(scene, integrator, size=SIZE, spp=spp, seed=first + i) for i in range(seeds)]
    return np.stack([f.image for f in made]).astype(np.float64)


@pytest.mark.stat
def test_bidirectional_paths_of_two_edges_are_direct_light():
    """Light paths that are connected to the camera leave the cone by its own density."""
    model = with_spots()
    direct = images(model.to_viscache(), vc.Direct(), 16, 6, first=100)
    bdpt = images(model.to_viscache(), vc.Bdpt(max_depth=2), 64, 6)
    assert compare(bdpt, direct).same
    assert not compare(0.96 * bdpt, direct).same
    for i in range(2):
        one = replace(model, spots=(model.spots[i],)).to_viscache()
        assert not compare(images(one, vc.Bdpt(max_depth=2), 64, 6), direct).same


def mean_indirect(**light):
    """Light of one bounce in a diffuse sphere: the same everywhere, in proportion to the power."""
    d = vc.SceneDescription()
    room = ball((0, 0, 0), 1.0, 24).reversed()
    material = d.add_material(base_color=(0.5, 0.5, 0.5))
    d.add_mesh(room.vertices, room.triangles, material=material)
    d.add_point_light((0, 0.1, 0), (4, 4, 4), **light)
    d.add_camera((0, 0, 0.5), (0, 0, -1), fov_deg=60)
    lights = vc.Whitted(n_vpls=2048, vpl_bound=0.0, vpl_max_depth=1)
    frame = vc.render(vc.Scene.from_description(d), lights, size=(8, 8), spp=4)
    return float(np.median(frame.layers["vpl"]))


@pytest.mark.parametrize("falloff", FALLOFFS)
def test_virtual_lights_carry_the_power_of_the_cone(falloff):
    angles = np.linspace(0, np.pi, 20_001)
    ring = np.sin(angles) * factor(np.degrees(angles), falloff)
    share = float(np.sum(ring) * angles[1] / 2)  # of the power of a point light
    found = mean_indirect(axis=(1, 2, 3), cone_deg=(INNER, OUTER), falloff=falloff)
    assert found / mean_indirect() == pytest.approx(share, rel=0.03)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"axis": (0, 0, 0)}, "axis must not be zero"),
        ({"axis": (0, 0, 1), "cone_deg": (30, 20)}, "cone_deg must be 0 <= inner <= outer <= 180"),
        ({"axis": (0, 0, 1), "cone_deg": (0, 181)}, "cone_deg must be"),
        ({"axis": (0, 0, 1), "falloff": "round"}, "falloff must be one of angle, quadratic"),
    ],
)
def test_cones_out_of_range_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        vc.SceneDescription().add_point_light((0, 0, 0), (1, 1, 1), **given)


@pytest.mark.parametrize(
    "visibility", [vc.ShadowMap(resolution=512), vc.Aqvc(c_e=4, exact_groups=())]
)
def test_caches_see_spot_lights_as_points(visibility):
    scene = with_spots().to_viscache()
    exact = vc.render(scene, vc.Direct(), size=(64, 48), spp=4)
    cached = vc.render(scene, vc.Direct(), size=(64, 48), spp=4, visibility=visibility)
    assert exact.image.mean() > 0.01
    assert np.abs(cached.image - exact.image).sum() <= 0.05 * exact.image.sum()


def test_contributions_of_connections_are_those_of_the_frame():
    scene = with_spots().to_viscache()
    made = vc.connections(scene, vc.Direct(), size=SIZE, spp=1)
    values = made.contributions("point", slice(0, 64))
    assert values.shape[1] == 2 and np.any(values > 0) and np.any(values == 0)
