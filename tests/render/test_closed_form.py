"""Exact frames of scenes whose answer can be written down."""

from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from render.mitsuba_scene import Look, Model, ball, box, quad

WHITE = Look(base_color=(0.8, 0.5, 0.25))
RHO = np.array([0.8, 0.5, 0.25])
PLANE = quad((-20, 0, -20), (0, 0, 40), (40, 0, 0), look=WHITE)
#: Seen from straight above: the depth of a pixel's one sample tells how far from the axis it is.
ABOVE = {"origin": (0, 3, 0), "target": (0, 0, 0), "up": (0, 0, 1), "fov_deg": 60}
SIZE = (33, 21)


def rendered(model, integrator=None, **options):
    return vc.render(model.to_viscache(), integrator or vc.Direct(), **{"size": SIZE} | options)


def below(scene, integrator, x, spp, height=0.02):
    """The light that leaves the plane at (x, 0, 0), seen from straight above."""
    view = vc.look_at((x, height, 0), (x, 0, 0), (0, 0, 1), 0.5)
    return vc.render(scene, integrator, size=(1, 1), spp=spp, camera=view).image[0, 0]


def group(frame, name):
    return frame.layers[name].astype(np.float64)


def test_a_point_light_over_a_plane_follows_the_inverse_square_law():
    frame = rendered(replace(Model((PLANE,), **ABOVE), points=(((0, 2, 0), (1, 2, 3)),)))
    depth = frame.layers["depth"][..., 0].astype(float)
    r = np.sqrt(np.maximum(depth**2 - 3.0**2, 0))
    expected = RHO / np.pi * [1, 2, 3] * (2 / (r**2 + 4) ** 1.5)[..., None]
    np.testing.assert_allclose(frame.image, expected, rtol=2e-5)
    assert frame.counters["queries"] == frame.counters["rays"] == SIZE[0] * SIZE[1]


def everywhere(image, color, rtol):
    np.testing.assert_allclose(image, np.broadcast_to(color, image.shape), rtol=rtol)


def test_a_directional_light_follows_the_cosine():
    for cosine in (1.0, 0.5, 1e-3):
        direction = (0.0, cosine, float(np.sqrt(1 - cosine**2)))
        image = rendered(Model((PLANE,), directions=((direction, (1, 2, 3)),), **ABOVE)).image
        everywhere(image, RHO / np.pi * [1, 2, 3] * cosine, 1e-4)


def test_contributions_of_zero_cost_no_ray():
    """Black surfaces, dark lights, lights behind, below or along; samples below the horizon."""
    black = replace(PLANE, look=Look(base_color=(0, 0, 0)))
    lamp = quad((-1, 2, -1), (2, 0, 0), (0, 0, 2), emission=(1, 1, 1), look=black.look)
    lit = {"points": (((0, 2, 0), (1, 1, 1)),), "env": (1, 1, 1)}
    suns = tuple((direction, (1.0, 1.0, 1.0)) for direction in ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0)))
    for model in (
        Model((black, lamp), **lit, **ABOVE),
        Model((PLANE,), points=(((0, 2, 0), (0, 0, 0)),), env=(0, 0, 0), **ABOVE),
        Model((PLANE, lamp.reversed()), origin=(0, 1, 0), target=(0, 0, 0), up=(0, 0, 1)),
        Model((PLANE,), directions=suns, **ABOVE),
    ):
        frame = rendered(model)
        assert frame.counters["queries"] == frame.counters["rays"] == 0
        assert not frame.image[frame.layers["emitted"] == 0].any()
    half = rendered(Model((PLANE,), env=(1, 1, 1), **ABOVE), vc.Direct(n_brdf=0))
    share = half.counters["queries"] / (16 * SIZE[0] * SIZE[1])
    assert 0.45 < share < 0.55, "directions of the whole sphere, of which half are above the plane"


@pytest.mark.parametrize("kind", ["diffuse", "glossy"])
def test_in_a_furnace_a_convex_body_reflects_its_albedo(kind):
    """BRDF samples of a Lambertian surface under a constant sky weigh exactly its albedo."""
    look = replace(WHITE, kind=kind, specular=(0.04, 0.04, 0.04), roughness=0.3)
    model = Model((ball((0, 0, 0), 1, look=look),), env=(2, 2, 2), target=(0, 0, 0))
    frame = rendered(model, vc.Direct(n_environment=0, n_brdf=32), spp=4)
    inside = frame.layers["coverage"][..., 0] == 1
    assert inside.sum() > 50
    reflected = group(frame, "environment")[inside]
    if kind == "diffuse":
        everywhere(reflected, 2 * RHO, 1e-5)
    else:  # the lobe adds what it takes from the diffuse part, but for what masking loses
        mean = reflected.mean(0)
        assert (mean <= 2 * (RHO + 0.06)).all() and (mean > 2 * 0.9 * RHO).all()


@pytest.mark.parametrize(("roughness", "least"), [(0.05, 0.97), (0.3, 0.8), (1.0, 0.3)])
def test_a_rough_metal_gives_no_more_than_it_gets_less_what_masking_loses(roughness, least):
    metal = Look(kind="glossy", base_color=(0, 0, 0), roughness=roughness)
    globe = ball((0, 0, 0), 1, 24, smooth=True, look=metal)
    model = Model((globe,), env=(1, 1, 1), target=(0, 0, 0))
    frame = rendered(model, vc.Direct(n_environment=0, n_brdf=64), spp=4)
    assert least < group(frame, "environment")[8:13, 14:19].mean() <= 1 + 1e-5


def test_inside_a_glowing_box_direct_light_is_albedo_times_emission():
    """The furnace closed: the camera is inside, all that is seen emits (1, 1, 1) at itself."""
    room = box((-1, -1, -1), (1, 1, 1), look=WHITE, emission=(1, 1, 1)).reversed()
    model = Model((room,), origin=(0.1, 0.2, 0.3), target=(1, 0.5, 0.2), fov_deg=90)
    frame = rendered(model, vc.Direct(n_area=256), spp=4)
    np.testing.assert_array_equal(frame.layers["emitted"], 1)
    np.testing.assert_allclose(group(frame, "area").mean((0, 1)), RHO, rtol=0.01)


@pytest.mark.stat
def test_a_ball_over_a_plane_under_a_constant_sky_casts_its_form_factor():
    """From a point at r, a ball of radius R at height h fills R² h / (r² + h²)^(3/2) of the sky."""
    big_r, h = 0.6, 1.0
    scene = Model((PLANE, ball((0, h, 0), big_r, 96)), env=(1, 1, 1)).to_viscache()
    ambient = vc.AmbientOcclusion(n_samples=64, max_distance=None)
    for px in np.linspace(0.05, 2.5, 24)[::6]:
        # Stratified in 256 × 64 samples: far below the binomial error of 0.4 %
        free = 1 - big_r**2 * h / (px**2 + h**2) ** 1.5
        lit = below(scene, vc.Direct(n_environment=0, n_brdf=64), px, 256)
        np.testing.assert_allclose(lit, free * RHO, rtol=0.01)
        np.testing.assert_allclose(below(scene, ambient, px, 256), free, rtol=0.01)


def corner_form_factor(a, b, h):
    """From a point to a parallel a × b rectangle with one corner above the point, at distance h."""
    x, y = a / h, b / h
    return (
        x / np.sqrt(1 + x**2) * np.arctan(y / np.sqrt(1 + x**2))
        + y / np.sqrt(1 + y**2) * np.arctan(x / np.sqrt(1 + y**2))
    ) / (2 * np.pi)


@pytest.mark.stat
@pytest.mark.parametrize("n_area", [1, 64])
def test_parallel_plates_exchange_the_light_of_their_form_factor(n_area):
    lamp = quad((-1, 1, -1), (2, 0, 0), (0, 0, 2), emission=(3, 2, 1))
    scene = Model((PLANE, lamp)).to_viscache()
    for px in (0.0, 0.5, 1.5, 3.0):
        sides = (corner_form_factor(abs(w), 1.0, 1.0) * np.sign(w) for w in (1 + px, 1 - px))
        lit = below(scene, vc.Direct(n_area=n_area), px, 4096 // n_area * 4, 0.5)
        np.testing.assert_allclose(lit, RHO * [3, 2, 1] * 2 * sum(sides), rtol=0.02)


@pytest.mark.stat
def test_a_sphere_light_shines_like_its_form_factor():
    radius, h = 0.25, 1.5
    scene = Model((PLANE,), spheres=(((0, h, 0), radius, (5, 4, 3)),)).to_viscache()
    for px in (0.0, 1.0, 3.0):
        expected = RHO * [5, 4, 3] * radius**2 * h / (px**2 + h**2) ** 1.5
        lit = below(scene, vc.Direct(n_area=64), px, 64, 0.3)
        np.testing.assert_allclose(lit, expected, rtol=2e-3)


def test_a_sphere_light_reflects_nothing():
    """It has no material: the scene's first is a mirror, and a point light shines at the sphere."""
    view = {"target": (0, 1, 0), "fov_deg": 1}
    view |= {"points": (((0, 3, 3), (100, 100, 100)),), "spheres": (((0, 1, 0), 0.5, (1, 1, 1)),)}
    model = Model((replace(PLANE, look=Look(kind="mirror")),), **view)
    np.testing.assert_array_equal(rendered(model, vc.Whitted(n_vpls=16), size=(1, 1)).image, 1)
    assert model.to_viscache().with_environment(0.5).triangles == 2


def test_a_mirror_multiplies_what_it_shows():
    mirror = replace(PLANE, look=Look(kind="mirror", specular=(0.9, 0.6, 0.3)))
    image = rendered(Model((mirror,), env=(1, 2, 3), **ABOVE)).image
    everywhere(image, [0.9, 1.2, 0.9], 1e-6)


GLASS = Look(kind="dielectric", eta=1.5)
GLASSES = {
    "slab": (box((-1, -0.2, -1), (1, 0.2, 1), look=GLASS),),
    "four panes": tuple(box((-1, y, -1), (1, y + 0.2, 1), look=GLASS) for y in (0, 0.5, 1, 1.5)),
    "faceted ball": (ball((0, 0, 0), 1, look=GLASS),),
    "smooth shell": tuple(
        ball((0, 0, 0), r, 48, smooth=True, look=replace(GLASS, eta=eta))
        for r, eta in ((1, 1.5), (0.9, 1 / 1.5))
    ),
}


def furnace(parts, max_depth, **kwargs):
    model = Model(parts, env=(1, 1, 1), origin=(0.3, 3, 0.2), target=(0, 0, 0))
    return rendered(model, vc.Whitted(n_vpls=0, max_depth=max_depth), **kwargs)


def test_glass_in_a_furnace_is_invisible():
    """What a slab reflects and what it lets through add up, without loss."""
    frame = furnace(GLASSES["slab"], 16, spp=64)
    assert (frame.layers["coverage"] == 1).sum() > 200
    assert frame.counters["lost_throughput"] < 1e-12
    assert frame.image.mean() == pytest.approx(1, abs=2e-5)
    assert frame.image.std() < 4e-4, "the roulette of weak branches is not seen"


@pytest.mark.parametrize("glass", GLASSES)
@pytest.mark.parametrize("max_depth", [1, 4, 16])
def test_what_glass_lacks_in_a_furnace_is_what_was_counted_as_lost(glass, max_depth):
    frame = furnace(GLASSES[glass], max_depth, spp=16)
    lost = frame.counters["lost_throughput"]
    assert frame.image.mean() + lost == pytest.approx(1, abs=3e-4)
    assert (max_depth < 16) <= (lost > 5e-4) and lost < 1


def test_a_diver_counts_what_is_lost_in_the_scale_of_the_water():
    """Seen from within glass, light from outside is the square of the index brighter."""
    frame = furnace((ball((0, 0, 0), 5, look=GLASS),), 1, spp=16)
    np.testing.assert_allclose(frame.image.max(), 1.5**2, rtol=0.05)
    assert 0 < frame.counters["lost_throughput"] < 1


def test_at_normal_incidence_glass_reflects_the_fresnel_share():
    glass = quad((-1, 0, -1), (0, 0, 2), (2, 0, 0), look=Look(kind="dielectric", eta=1.5))
    lamp = quad((-4, 4, -4), (8, 0, 0), (0, 0, 8), emission=(1, 1, 1))
    model = Model((glass, lamp), **ABOVE | {"fov_deg": 1.0})
    image = rendered(model, vc.Whitted(n_vpls=0), size=(3, 3)).image
    np.testing.assert_allclose(image, 0.04, rtol=1e-3)


@pytest.mark.extreme
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("away", [0.0, 3.0, 1e3, 1e5])
@pytest.mark.parametrize("instanced", [False, True])
def test_surfaces_do_not_shadow_themselves_and_closed_rooms_do_not_leak(instanced, scale, away):
    """Ambient occlusion of a turned cube: 1 outside, whatever the angle; 0 inside."""
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    cube = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
    centre = np.array([away, 0.7 * away, -0.3 * away])
    vertices = ((cube.vertices @ rotation.T + centre) * scale).astype(np.float32)
    d = vc.SceneDescription()
    if instanced:
        mesh = d.add_mesh(cube.vertices, cube.triangles, in_world=False)
        d.add_instance([mesh], scale * np.concatenate([rotation, centre[:, None]], axis=1))
    else:
        d.add_mesh(vertices, cube.triangles)
    scene = vc.Scene.from_description(d)
    middle = vertices.astype(float).mean(0)
    ambient = vc.AmbientOcclusion(n_samples=32, max_distance=None)
    for eye, target, fov, expected in (
        ((2.0, 1.5, 1.0), (0, 0, 0), 30.0, 1.0),
        ((0, 0, 0), (0.3, 0.2, 0.4), 100.0, 0.0),
    ):
        places = ((middle + scale * np.array(place)).tolist() for place in (eye, target))
        view = vc.look_at(*places, (0, 1, 0), fov)
        frame = vc.render(scene, ambient, size=(24, 24), spp=4, camera=view)
        coverage = frame.layers["coverage"][..., 0]
        free = frame.image[..., 0][coverage == 1]
        assert (coverage > 0).mean() > 0.2 and len(free) > 50
        if away < 1e5:
            np.testing.assert_allclose(free, expected, atol=1e-5)
        else:  # where a unit in the last place is 1/128 of the cube, its edges are rough
            assert abs(free.mean() - expected) < 3e-3 and np.median(free) == expected
