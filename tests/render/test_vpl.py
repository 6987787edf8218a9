"""Virtual point lights: their expectation is the indirect light, whatever their number."""

from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from core import testing
from render.mitsuba_frames import assert_same, ours, theirs
from render.mitsuba_scene import Look, Model, ball, quad
from render.ztest import compare
from viscache._core import CoatKind, MaterialKind
from viscache._core.sampling import ShadingPoint

#: Small, with many samples a pixel: an edge that crosses a pixel must be seen in every frame.
SIZE = (16, 12)

WHITE = Look(base_color=(0.8, 0.8, 0.8))
#: Walls that do not touch: the unbounded geometry term has no singular corners in sight.
FLOOR = quad((-3, 0, -3), (0, 0, 6), (6, 0, 0), look=WHITE)
RED = quad((-1.6, 0.3, -2), (0, 0, 3.5), (0, 2, 0), look=Look(base_color=(0.9, 0.2, 0.1)))
BLUE = quad((-1.2, 0.3, -2), (3, 0, 0), (0, 2, 0), look=Look(base_color=(0.2, 0.3, 0.9)))
GLOBE = ball((0.7, 0.7, -0.2), 0.4, look=Look(base_color=(0.5, 0.8, 0.4)))
LIGHTS = {
    "point": {"points": (((0.3, 2.2, 1.0), (8, 8, 8)),)},
    "spot": {"spots": (((0.6, 2.4, 1.0), (20, 18, 15), (-0.3, -1, -0.4), (15.0, 35.0)),)},
    "directional": {"directions": (((0.3, 0.8, 0.52), (3, 3, 3)),)},
    "area": {"parts": (quad((0, 2.5, 0), (1, 0, 0), (0, 0, 1), emission=(9, 8, 7)),)},
    "sphere": {"spheres": (((0.5, 2.5, 0.8), 0.25, (20, 20, 15)),)},
    "sky": {"env": (0.8, 0.9, 1.0)},
}
#: Of them, one of each way to leave a light.
EACH_TIME = ("spot", "area", "sky")


def model(light):
    extra = dict(LIGHTS[light])
    parts = (FLOOR, RED, BLUE, GLOBE, *extra.pop("parts", ()))
    return Model(parts, origin=(0.5, 2.2, 3.2), target=(0, 0.3, -0.5), **extra)


def indirect(scene, seeds, **kwargs):
    settings = {"vpl_bound": 0.0, "vpl_max_depth": 3, "n_vpls": 2048} | kwargs
    lights = vc.Whitted(n_area=0, n_environment=0, n_brdf=0, **settings)
    return ours(scene, lights, spp=9, seeds=seeds, size=SIZE, first=1000, layer="vpl")


def mitsubas(mi, lit, folder, depth, seeds):
    """Edges 3 to `depth`. Seeds do not pair samples: the difference has the variance of both."""
    scene = lit.to_mitsuba(mi, SIZE, folder)
    paths = (
        theirs(mi, scene, depth=d, spp=512, seeds=seeds, first=first)
        for d, first in ((depth, 0), (2, 500))
    )
    return np.subtract(*paths)


@pytest.mark.slow
@pytest.mark.stat
@pytest.mark.mitsuba
@pytest.mark.parametrize(
    "light", [pytest.param(n, marks=() if n in EACH_TIME else pytest.mark.release) for n in LIGHTS]
)
def test_the_expectation_over_seeds_is_mitsubas_indirect_light(light, mi, tmp_path):
    """3 bounces of a light path, one to the eye: edges 3 to 5."""
    reference = mitsubas(mi, model(light), tmp_path, 5, 16)
    made = indirect(model(light).to_viscache(), 32)
    # Virtual lights are shared by all pixels: 5 % of the indirect light is what these seeds can see
    assert_same(made, reference, 1e-4, power=0.05)
    shallow = indirect(model(light).to_viscache(), 8, n_vpls=1024, vpl_max_depth=1)
    assert not compare(shallow, reference, tolerance=1e-4).same


@pytest.mark.slow
@pytest.mark.stat
def test_resampling_does_not_change_the_expectation():
    """Few and many of the candidates carry the light of paths of 3 to 5 edges."""
    scene = model("point").to_viscache()

    given = {"size": SIZE, "spp": 64, "seeds": 24}
    reference = ours(scene, vc.Bdpt(max_depth=5), **given)
    reference -= ours(scene, vc.Bdpt(max_depth=2), first=500, **given)
    for n in (64, 512, 2048):
        found = compare(indirect(scene, 24, n_vpls=n), reference, tolerance=1e-4)
        assert found.same, (n, found)
    assert not compare(0.96 * indirect(scene, 24), reference, tolerance=1e-4).same


def test_virtual_lights_carry_no_direct_light():
    """Nothing reflects twice from a plane: all its light is direct, its VPLs give it none."""
    for light in LIGHTS:
        extra = dict(LIGHTS[light])
        black = tuple(replace(p, look=Look(base_color=(0, 0, 0))) for p in extra.pop("parts", ()))
        lit = Model((FLOOR, *black), origin=(0, 2, 2), target=(0, 0, 0), **extra).to_viscache()
        frame = vc.render(lit, vc.Whitted(n_vpls=64), size=SIZE)
        assert frame.counters["vpls"] > 0, light
        assert not frame.layers["vpl"].any() and frame.counters["groups"]["vpl"]["queries"] == 0


def test_the_number_of_virtual_lights_is_at_most_what_is_asked_for():
    scene = model("area").to_viscache()
    for n in (1, 7, 64, 1000):
        vpls = vc.render(scene, vc.Whitted(n_vpls=n), size=(8, 6)).counters["vpls"]
        assert 1 <= vpls <= n
    assert vc.render(scene, vc.Whitted(n_vpls=0), size=(8, 6)).counters["vpls"] == 0


def test_a_bound_takes_light_away_and_the_default_little():
    scene = model("point").to_viscache()
    free, slight, strong = (
        indirect(scene, 4, n_vpls=1024, vpl_bound=b).mean() for b in (0.0, 0.01, 0.2)
    )
    assert strong < 0.8 * free
    assert 0.9 * free < slight < 1.05 * free


def test_a_scene_that_leaves_no_virtual_light_renders():
    black, one_sided = Look(base_color=(0, 0, 0)), Look(two_sided=False)
    for lone in (
        Model((replace(FLOOR, look=black),), points=(((0, 1, 0), (1, 1, 1)),)),
        Model((FLOOR,)),
        Model((replace(FLOOR, look=one_sided),), directions=(((0, -1, 0), (1, 1, 1)),)),
    ):
        frame = vc.render(lone.to_viscache(), vc.Whitted(n_vpls=32), size=(8, 6))
        assert frame.counters["vpls"] == 0 and np.isfinite(frame.image).all()


@pytest.mark.stat
def test_light_by_way_of_a_mirror_reaches_the_floor():
    """VPLs at the end of light → mirror → ceiling: more than without the mirror."""
    roof = quad((-2, 2, -2), (4, 0, 0), (0, 0, 4), look=WHITE)
    wall = quad((-2, 0, -2), (4, 0, 0), (0, 2, 0), look=WHITE)

    def seen(look):
        plate = quad((-1, 0.1, -1), (0, 0, 2), (2, 0, 0), look=look)
        lamp = (((0.0, 0.6, 0.0), (2.0, 2.0, 2.0)),)
        lit = Model((plate, roof, wall), points=lamp, origin=(0, 1, 3), target=(0, 1.2, 0))
        return float(indirect(lit.to_viscache(), 4).mean())

    assert seen(Look(kind="mirror")) > 1.3 * seen(Look(base_color=(0, 0, 0))) > 0


# Shading normals and glossy surfaces. Light from straight above meets a floor alone; a wall beside
# it sees what the floor's virtual lights bring.


def bent(part, degrees):
    """The part with shading normals turned from +y towards −z."""
    normal = np.array([0, np.cos(np.radians(degrees)), -np.sin(np.radians(degrees))], np.float32)
    return replace(part, normals=np.tile(normal, (len(part.vertices), 1)))


WALL = quad((-1.5, 0.3, -1.6), (3, 0, 0), (0, 2, 0), look=WHITE)
AT_THE_WALL = {"origin": (0, 1.2, 3), "target": (0, 1.2, -1.6), "fov_deg": 15}


def on_the_wall(*parts, direction=(0, 1, 0), seeds=1, **given):
    scene = Model((*parts, WALL), directions=((direction, (3, 3, 3)),), **AT_THE_WALL)
    settings = {"n_vpls": 512, "vpl_max_depth": 1} | given
    return float(indirect(scene.to_viscache(), seeds, **settings).mean())


def from_the_side(cosine):
    return (float(np.sqrt(1 - cosine**2)), cosine, 0.0)


SHEET = quad((-1.5, 0, -1.5), (0, 0, 3), (3, 0, 0), look=WHITE)


@pytest.mark.parametrize("degrees", [20, 60, 89])
def test_virtual_lights_take_up_light_by_the_shading_normal(degrees):
    expected = np.cos(np.radians(degrees)) * on_the_wall(bent(SHEET, 0))
    assert on_the_wall(bent(SHEET, degrees)) == pytest.approx(expected, rel=1e-4)
    assert on_the_wall(bent(SHEET, 0)) == on_the_wall(SHEET) > 0.01


@pytest.mark.slow
@pytest.mark.stat
@pytest.mark.mitsuba
def test_light_of_bent_normals_is_mitsubas(mi, tmp_path):
    lit = Model((bent(SHEET, 40), WALL), points=(((0.3, 2.2, 1.0), (8, 8, 8)),), **AT_THE_WALL)
    reference = mitsubas(mi, lit, tmp_path, 3, 8)
    settings = {"vpl_max_depth": 1, "n_vpls": 1024}
    found = compare(indirect(lit.to_viscache(), 16, **settings), reference, tolerance=1e-4)
    assert found.same and abs(found.energy) < 0.05, found
    plain = replace(lit, parts=(SHEET, WALL)).to_viscache()
    assert not compare(indirect(plain, 4, **settings), reference, tolerance=1e-4).same


@pytest.mark.stat
def test_a_mirror_with_bent_normals_sends_photons_where_eyes_look():
    """Its beam is that of a mirror turned by as much and cut to the beam's width."""
    angle, look = np.radians(20), Look(kind="mirror")
    flat = quad((-0.5, 0, -0.5), (0, 0, 1), (1, 0, 0), look=look)
    deep = float(np.cos(2 * angle) / np.cos(angle))
    across = (0.0, deep * float(np.sin(angle)), deep * float(np.cos(angle)))
    turned = quad((-0.5, -across[1] / 2, -across[2] / 2), across, (1, 0, 0), look=look)
    # The beam leaves at 40° towards −z and lights the catcher, which lights the screen
    catcher = quad((-2, 0.5, -3), (4, 0, 0), (0, 6, 0), look=WHITE)
    screen = quad((-2, 0.5, 2), (0, 4, 0), (4, 0, 0), look=WHITE)
    given = {"directions": (((0, 1, 0), (3, 3, 3)),), "fov_deg": 30}
    given |= {"origin": (0, 2.5, -2.5), "target": (0, 2.5, 2)}

    def seen(mirror):
        scene = Model((mirror, catcher, screen), **given).to_viscache()
        return float(indirect(scene, 4, vpl_max_depth=2, n_vpls=512).mean())

    assert seen(bent(flat, 20)) == pytest.approx(seen(turned), rel=0.02)
    assert seen(turned) > 1e-3 and seen(bent(flat, 0)) == 0


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.2])
@pytest.mark.parametrize("f0", [0.04, 0.5, 1.0])
def test_a_glossy_surface_gives_its_virtual_lights_what_the_lobe_leaves(cosine, f0):
    plastic = Look(kind="glossy", base_color=(0.8, 0.8, 0.8), specular=(f0,) * 3)
    share = 0.99714 * (1 - f0) * (1 - (1 - cosine) ** 5)
    white, found = (
        on_the_wall(replace(SHEET, look=look), direction=from_the_side(cosine))
        for look in (WHITE, plastic)
    )
    assert found == pytest.approx(share * white, rel=1e-4, abs=1e-12)


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.2])
@pytest.mark.parametrize("coat", list(CoatKind)[1:])
def test_a_coated_surface_gives_its_virtual_lights_what_leaves_the_coat(cosine, coat):
    coated = {
        "coat": coat,
        "nonlinear": coat != CoatKind.FRESNEL_MIX,
        "specular": (0.04,) * 3,
    }
    look, direction = Look(kind="glossy", base_color=(0.8,) * 3, **coated), from_the_side(cosine)
    coated |= {"base": look.base_color, "roughness": look.roughness}
    lit = ShadingPoint(MaterialKind.GLOSSY, (direction[0], 0, cosine), **coated)
    white, found = (on_the_wall(replace(SHEET, look=k), direction=direction) for k in (WHITE, look))
    assert found == pytest.approx(testing.diffuse_albedo(lit)[0] / 0.8 * white, rel=1e-4)


@pytest.mark.stat
def test_a_thin_plate_takes_from_virtual_lights_what_it_reflects():
    def below(eta):
        look = Look(kind="dielectric", eta=eta, thin=True)
        plate = quad((-1.5, 4, -1.5), (0, 0, 3), (3, 0, 0), look=look)
        return on_the_wall(SHEET, plate, seeds=4, n_vpls=1024, vpl_max_depth=2)

    fresnel = (1.5 / 3.5) ** 2
    assert below(2.5) == pytest.approx((1 - 2 * fresnel / (1 + fresnel)) * below(1), rel=0.05)
