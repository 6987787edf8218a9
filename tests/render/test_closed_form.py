"""Exact frames of scenes whose answer can be written down."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from render.mitsuba_scene import Look, Model, Part, ball, box, quad

WHITE = Look(base_color=(0.8, 0.5, 0.25))
RHO = np.array([0.8, 0.5, 0.25])
PLANE = quad((-20, 0, -20), (0, 0, 40), (40, 0, 0), look=WHITE)
#: Seen from straight above: the depth of a pixel's one sample tells how far from the axis it is.
ABOVE: dict[str, Any] = {"origin": (0, 3, 0), "target": (0, 0, 0), "up": (0, 0, 1), "fov_deg": 60}
SIZE = (33, 21)


def radius_on_plane(frame: vc.Frame, height: float = 3.0) -> npt.NDArray[np.float64]:
    depth = frame.layers["depth"][..., 0].astype(float)
    return np.sqrt(np.maximum(depth**2 - height**2, 0))


def group(frame: vc.Frame, name: str) -> npt.NDArray[np.float64]:
    return frame.layers[name].astype(np.float64)


def test_a_point_light_over_a_plane_follows_the_inverse_square_law() -> None:
    scene = replace(Model((PLANE,), **ABOVE), points=(((0, 2, 0), (1, 2, 3)),)).to_viscache()
    frame = vc.render(scene, vc.Direct(), size=SIZE)
    r = radius_on_plane(frame)
    expected = RHO / np.pi * [1, 2, 3] * (2 / (r**2 + 4) ** 1.5)[..., None]
    np.testing.assert_allclose(frame.image, expected, rtol=2e-5)
    assert frame.counters["queries"] == frame.counters["rays"] == SIZE[0] * SIZE[1]


def test_a_directional_light_follows_the_cosine() -> None:
    for cosine in (1.0, 0.5, 1e-3):
        direction = (0.0, cosine, float(np.sqrt(1 - cosine**2)))
        model = Model((PLANE,), directions=((direction, (1, 2, 3)),), **ABOVE)
        frame = vc.render(model.to_viscache(), vc.Direct(), size=SIZE)
        np.testing.assert_allclose(
            frame.image,
            np.broadcast_to(RHO / np.pi * [1, 2, 3] * cosine, frame.image.shape),
            rtol=1e-4,
        )


@pytest.mark.parametrize("direction", [(0, -1, 0), (1, 0, 0)])
def test_light_from_below_or_along_the_surface_costs_no_ray(direction: Any) -> None:
    frame = vc.render(
        Model((PLANE,), directions=((direction, (1, 1, 1)),), **ABOVE).to_viscache(),
        vc.Direct(),
        size=SIZE,
    )
    assert not frame.image.any() and frame.counters["queries"] == 0


def test_contributions_of_zero_cost_no_ray() -> None:
    """Black surfaces, dark lights, lights that turn their back, samples below the horizon."""
    black = replace(PLANE, look=Look(base_color=(0, 0, 0)))
    lamp = quad((-1, 2, -1), (2, 0, 0), (0, 0, 2), emission=(1, 1, 1), look=black.look)
    lit: dict[str, Any] = {"points": (((0, 2, 0), (1, 1, 1)),), "env": (1, 1, 1)}
    for model in (
        Model((black, lamp), **lit, **ABOVE),
        Model((PLANE,), points=(((0, 2, 0), (0, 0, 0)),), env=(0, 0, 0), **ABOVE),
        Model((PLANE, lamp.reversed()), origin=(0, 1, 0), target=(0, 0, 0), up=(0, 0, 1)),
    ):
        counters = vc.render(model.to_viscache(), vc.Direct(), size=SIZE).counters
        assert counters["queries"] == counters["rays"] == 0
    half = vc.render(
        Model((PLANE,), env=(1, 1, 1), **ABOVE).to_viscache(), vc.Direct(n_brdf=0), size=SIZE
    )
    share = half.counters["queries"] / (16 * SIZE[0] * SIZE[1])
    assert 0.45 < share < 0.55, "directions of the whole sphere, of which half are above the plane"


@pytest.mark.parametrize("kind", ["diffuse", "glossy"])
def test_in_a_furnace_a_convex_body_reflects_its_albedo(kind: str) -> None:
    """BRDF samples of a Lambertian surface under a constant sky weigh exactly its albedo."""
    look = replace(WHITE, kind=kind, specular=(0.04, 0.04, 0.04), roughness=0.3)
    scene = Model((ball((0, 0, 0), 1, look=look),), env=(2, 2, 2), target=(0, 0, 0)).to_viscache()
    frame = vc.render(scene, vc.Direct(n_environment=0, n_brdf=32), size=SIZE, spp=4)
    inside = frame.layers["coverage"][..., 0] == 1
    assert inside.sum() > 50
    reflected = group(frame, "environment")[inside]
    if kind == "diffuse":
        np.testing.assert_allclose(reflected, np.broadcast_to(2 * RHO, reflected.shape), rtol=1e-5)
    else:  # the lobe adds what it takes from the diffuse part, but for what masking loses
        assert (reflected.mean(0) <= 2 * (RHO + 0.06)).all() and (
            reflected.mean(0) > 2 * 0.9 * RHO
        ).all()


def test_a_rough_metal_never_gives_more_than_it_gets() -> None:
    for roughness in (0.05, 0.3, 1.0):
        metal = Look(kind="glossy", base_color=(0, 0, 0), roughness=roughness)
        scene = Model(
            (ball((0, 0, 0), 1, 24, smooth=True, look=metal),), env=(1, 1, 1), target=(0, 0, 0)
        )
        frame = vc.render(
            scene.to_viscache(), vc.Direct(n_environment=0, n_brdf=64), size=SIZE, spp=4
        )
        reflected = group(frame, "environment")[8:13, 14:19].mean()
        assert reflected <= 1 + 1e-5
        assert reflected > {0.05: 0.97, 0.3: 0.8, 1.0: 0.3}[roughness], (
            "what masking loses, no more"
        )


def test_inside_a_glowing_box_direct_light_is_albedo_times_emission() -> None:
    """The furnace closed: the camera is inside, all that is seen emits (1, 1, 1) at itself."""
    room = box((-1, -1, -1), (1, 1, 1), look=WHITE, emission=(1, 1, 1)).reversed()
    scene = Model((room,), origin=(0.1, 0.2, 0.3), target=(1, 0.5, 0.2), fov_deg=90).to_viscache()
    frame = vc.render(scene, vc.Direct(n_area=256), size=SIZE, spp=4)
    np.testing.assert_array_equal(frame.layers["emitted"], 1)
    np.testing.assert_allclose(group(frame, "area").mean((0, 1)), RHO, rtol=0.01)


@pytest.mark.stat
def test_a_ball_over_a_plane_under_a_constant_sky_casts_its_form_factor() -> None:
    """From a point at r, a ball of radius R at height h fills R² h / (r² + h²)^(3/2) of the sky."""
    big_r, h = 0.6, 1.0
    globe = ball((0, h, 0), big_r, 96)
    model = Model(
        (PLANE, globe), env=(1, 1, 1), origin=(0, 0.15, 2.5), target=(0, 0.0, 1.2), fov_deg=50
    )
    scene = model.to_viscache()
    x = np.linspace(0.05, 2.5, 24)
    for px in x[::6]:
        view = vc.look_at((px, 0.02, 0), (px, 0, 0), (0, 0, 1), 1.0)
        frame = vc.render(
            scene, vc.Direct(n_environment=0, n_brdf=64), size=(1, 1), spp=256, camera=view
        )
        blocked = big_r**2 * h / (px**2 + h**2) ** 1.5
        got = frame.image[0, 0] / RHO
        # Stratified in 256 × 64 samples: far below the binomial error of 0.4 %
        np.testing.assert_allclose(got, 1 - blocked, rtol=0.01)
        ambient = vc.render(
            scene,
            vc.AmbientOcclusion(n_samples=64, max_distance=None),
            size=(1, 1),
            spp=256,
            camera=view,
        )
        np.testing.assert_allclose(ambient.image[0, 0], 1 - blocked, rtol=0.01)


def corner_form_factor(a: Any, b: Any, h: float) -> Any:
    """From a point to a parallel a × b rectangle with one corner above the point, at distance h."""
    x, y = a / h, b / h
    return (
        x / np.sqrt(1 + x**2) * np.arctan(y / np.sqrt(1 + x**2))
        + y / np.sqrt(1 + y**2) * np.arctan(x / np.sqrt(1 + y**2))
    ) / (2 * np.pi)


@pytest.mark.stat
@pytest.mark.parametrize("n_area", [1, 64])
def test_parallel_plates_exchange_the_light_of_their_form_factor(n_area: int) -> None:
    lamp = quad((-1, 1, -1), (2, 0, 0), (0, 0, 2), emission=(3, 2, 1))
    scene = Model((PLANE, lamp)).to_viscache()
    for px in (0.0, 0.5, 1.5, 3.0):
        view = vc.look_at((px, 0.5, 0), (px, 0, 0), (0, 0, 1), 0.5)
        frame = vc.render(
            scene, vc.Direct(n_area=n_area), size=(1, 1), spp=4096 // n_area * 4, camera=view
        )
        f = corner_form_factor(1 + px, 1.0, 1.0) + np.sign(1 - px) * corner_form_factor(
            abs(1 - px), 1.0, 1.0
        )
        np.testing.assert_allclose(frame.image[0, 0], RHO * [3, 2, 1] * 2 * f, rtol=0.02)


@pytest.mark.stat
def test_a_sphere_light_shines_like_its_form_factor() -> None:
    radius, h = 0.25, 1.5
    scene = Model((PLANE,), spheres=(((0, h, 0), radius, (5, 4, 3)),)).to_viscache()
    for px in (0.0, 1.0, 3.0):
        view = vc.look_at((px, 0.3, 0), (px, 0, 0), (0, 0, 1), 0.5)
        frame = vc.render(scene, vc.Direct(n_area=64), size=(1, 1), spp=64, camera=view)
        expected = RHO * [5, 4, 3] * radius**2 * h / (px**2 + h**2) ** 1.5
        np.testing.assert_allclose(frame.image[0, 0], expected, rtol=2e-3)


def test_a_sphere_light_reflects_nothing() -> None:
    """It has no material: the scene's first is a mirror, and a point light shines at the sphere."""
    mirror = replace(PLANE, look=Look(kind="mirror"))
    model = Model(
        (mirror,),
        spheres=(((0, 1, 0), 0.5, (1, 1, 1)),),
        points=(((0, 3, 3), (100, 100, 100)),),
        target=(0, 1, 0),
        fov_deg=1,
    )
    frame = vc.render(model.to_viscache(), vc.Whitted(n_vpls=16), size=(1, 1))
    np.testing.assert_array_equal(frame.image, 1)
    assert model.to_viscache().with_environment(0.5).triangles == 2


def test_a_mirror_multiplies_what_it_shows() -> None:
    mirror = replace(PLANE, look=Look(kind="mirror", specular=(0.9, 0.6, 0.3)))
    frame = vc.render(
        Model((mirror,), env=(1, 2, 3), **ABOVE).to_viscache(), vc.Direct(), size=SIZE
    )
    np.testing.assert_allclose(
        frame.image, np.broadcast_to([0.9, 1.2, 0.9], frame.image.shape), rtol=1e-6
    )


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


def furnace(parts: tuple[Part, ...], max_depth: int, **kwargs: Any) -> vc.Frame:
    model = Model(parts, env=(1, 1, 1), origin=(0.3, 3, 0.2), target=(0, 0, 0))
    integrator = vc.Whitted(n_vpls=0, max_depth=max_depth)
    return vc.render(model.to_viscache(), integrator, size=SIZE, **kwargs)


def test_glass_in_a_furnace_is_invisible() -> None:
    """What a slab reflects and what it lets through add up, without loss."""
    frame = furnace(GLASSES["slab"], 16, spp=64)
    assert (frame.layers["coverage"] == 1).sum() > 200
    assert frame.counters["lost_throughput"] < 1e-12
    assert frame.image.mean() == pytest.approx(1, abs=2e-5)
    assert frame.image.std() < 4e-4, "the roulette of weak branches is not seen"


@pytest.mark.parametrize("glass", GLASSES)
@pytest.mark.parametrize("max_depth", [1, 4, 16])
def test_what_glass_lacks_in_a_furnace_is_what_was_counted_as_lost(
    glass: str, max_depth: int
) -> None:
    frame = furnace(GLASSES[glass], max_depth, spp=16)
    lost = frame.counters["lost_throughput"]
    assert frame.image.mean() + lost == pytest.approx(1, abs=3e-4)
    assert (max_depth < 16) <= (lost > 5e-4) and lost < 1


def test_a_diver_counts_what_is_lost_in_the_scale_of_the_water() -> None:
    """Seen from within glass, light from outside is the square of the index brighter."""
    frame = furnace((ball((0, 0, 0), 5, look=GLASS),), 1, spp=16)
    np.testing.assert_allclose(frame.image.max(), 1.5**2, rtol=0.05)
    assert 0 < frame.counters["lost_throughput"] < 1


def test_at_normal_incidence_glass_reflects_the_fresnel_share() -> None:
    glass = quad((-1, 0, -1), (0, 0, 2), (2, 0, 0), look=Look(kind="dielectric", eta=1.5))
    lamp = quad((-4, 4, -4), (8, 0, 0), (0, 0, 8), emission=(1, 1, 1))
    view = {"origin": (0, 3, 0), "target": (0, 0, 0), "up": (0, 0, 1), "fov_deg": 1.0}
    frame = vc.render(Model((glass, lamp), **view).to_viscache(), vc.Whitted(n_vpls=0), size=(3, 3))
    np.testing.assert_allclose(frame.image, 0.04, rtol=1e-3)


# Any size, any place


@pytest.mark.extreme
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("away", [0.0, 3.0, 1e3, 1e5])
def test_surfaces_do_not_shadow_themselves_and_closed_rooms_do_not_leak(
    scale: float, away: float
) -> None:
    """Ambient occlusion of a turned cube: 1 outside, whatever the angle; 0 inside."""
    rng = np.random.default_rng(1)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    cube = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
    centre = np.array([away, 0.7 * away, -0.3 * away])
    vertices = ((cube.vertices @ rotation.T + centre) * scale).astype(np.float32)
    scene = vc.Scene.from_arrays(vertices, cube.triangles)
    middle = vertices.astype(float).mean(0)
    for eye, expected in ((middle + scale * np.array([2.0, 1.5, 1.0]), 1.0), (middle, 0.0)):
        target = middle if expected else middle + scale * np.array([0.3, 0.2, 0.4])
        view = vc.look_at(
            tuple(map(float, eye)),
            tuple(map(float, target)),
            (0, 1, 0),
            30.0 if expected else 100.0,
        )
        frame = vc.render(
            scene,
            vc.AmbientOcclusion(n_samples=32, max_distance=None),
            size=(24, 24),
            spp=4,
            camera=view,
        )
        coverage = frame.layers["coverage"][..., 0]
        assert (coverage > 0).mean() > 0.2
        ambient = frame.image[..., 0][coverage == 1]
        assert len(ambient) > 50
        if away < 1e5:
            np.testing.assert_allclose(ambient, expected, atol=1e-5)
        else:  # where a unit in the last place is 1/128 of the cube, its edges are rough
            assert abs(ambient.mean() - expected) < 3e-3 and np.median(ambient) == expected
