"""Light samples and BRDF samples of area lights at glossy points, by the balance heuristic."""

from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from core import testing
from render.mitsuba_frames import area_layers, assert_same, ours, theirs
from render.mitsuba_scene import Look, Model, box, quad
from render.ztest import compare
from viscache import _core

SIZE = (48, 32)


def plate(y, z, tilt_deg, roughness):
    """A wide plate that reflects the lamps above into the camera."""
    c, s = 0.55 * np.cos(np.radians(tilt_deg)), 0.55 * np.sin(np.radians(tilt_deg))
    metal = Look(kind="glossy", base_color=(0, 0, 0), roughness=roughness)
    return quad((-2, y - s / 2, z + c / 2), (4, 0, 0), (0, s, -c), look=metal)


#: After Veach and Guibas 1995: four plates under lamps of many sizes, of about equal power.
PLATES = (
    plate(0.05, 1.2, 3, 0.005),
    plate(0.15, 0.55, 8, 0.03),
    plate(0.32, -0.05, 13, 0.1),
    plate(0.58, -0.6, 18, 0.3),
)
LAMPS = (
    quad((-1.9, 2.2, -2.2), (0.12, 0, 0), (0, -0.08, 0.1), emission=(180, 160, 120)),
    quad((0.9, 2.2, -2.2), (0.9, 0, 0), (0, -0.3, 0.35), emission=(3, 5, 6)),
)
GLOBES = (((-0.7, 2.2, -2.0), 0.05, (300, 300, 300)), ((0.25, 2.25, -2.0), 0.3, (9, 7, 6)))
BACK = quad((-4, 0, -2.6), (8, 0, 0), (0, 1.6, 0), look=Look(base_color=(0.4, 0.4, 0.4)))
VEACH = Model(
    (*PLATES, *LAMPS, BACK), spheres=GLOBES, origin=(0, 1.6, 4.2), target=(0, 0.25, 0), fov_deg=32
)
BOTH = vc.Direct(n_area=16, n_brdf=16, centred=True)
LIGHT = replace(BOTH, n_brdf=0)
#: Light samples alone, many of them.
REFERENCE = replace(LIGHT, n_area=128)
JITTERED = replace(BOTH, centred=False)


@pytest.mark.mitsuba
@pytest.mark.stat
@pytest.mark.release
def test_veachs_plates_are_mitsubas(mi, tmp_path):
    # Lamps are out of sight: the silhouette of a tessellated sphere would differ
    reference = theirs(mi, VEACH.to_mitsuba(mi, SIZE, tmp_path), spp=128)
    assert_same(ours(VEACH.to_viscache(), JITTERED, spp=32), reference, edge=4)
    sharper = tuple(
        replace(p, look=replace(p.look, roughness=p.look.roughness * 1.15)) for p in PLATES
    )
    wrong = replace(VEACH, parts=(*sharper, *LAMPS, BACK))
    assert not compare(ours(wrong.to_viscache(), JITTERED, spp=32, seeds=6), reference).same


ROUGH = Look(kind="glossy", base_color=(0.4, 0.3, 0.2), specular=(0.3, 0.3, 0.3), roughness=0.25)
STAGE = Model(
    (
        quad((-3, 0, -3), (0, 0, 6), (6, 0, 0), look=ROUGH),
        box((-0.9, 0, -0.5), (-0.3, 0.9, 0.2), look=ROUGH),
        quad((-0.2, 0.6, -0.9), (0.9, 0, 0), (0, 0.7, 0), emission=(5, 4, 3)),
        quad((0.9, 0.02, 0.2), (0, 0, 0.5), (0, 0.5, 0), emission=(6, 8, 9)).reversed(),
    ),
    spheres=(((-0.2, 0.5, 0.7), 0.15, (8, 9, 7)),),
    origin=(0.3, 1.6, 3.0),
    target=(0, 0.2, 0),
)


@pytest.mark.stat
def test_both_techniques_and_light_samples_alone_have_the_same_mean():
    scene = STAGE.to_viscache()
    light = area_layers(scene, REFERENCE, first=100)
    both = area_layers(scene, BOTH, spp=16)
    assert compare(both, light).same
    assert not compare(0.98 * both, light).same


def variance(scene, integrator):
    return float(np.var(area_layers(scene, integrator, spp=1, size=SIZE), axis=0, ddof=1).mean())


def test_brdf_samples_take_the_noise_from_sharp_reflections():
    scene = VEACH.to_viscache()
    assert variance(scene, BOTH) < variance(scene, LIGHT) / 20


def test_diffuse_points_have_the_same_bytes_with_and_without_brdf_samples():
    plain = tuple(replace(p, look=Look()) for p in STAGE.parts)
    scene = replace(STAGE, parts=plain).to_viscache()
    frames = [vc.render(scene, i, size=SIZE) for i in (BOTH, LIGHT)]
    assert frames[0].sha256 == frames[1].sha256
    assert frames[0].counters["queries"] == frames[1].counters["queries"]
    glossy = [vc.render(STAGE.to_viscache(), i, size=SIZE).sha256 for i in (BOTH, LIGHT)]
    assert glossy[0] != glossy[1]


@pytest.mark.stat
@pytest.mark.slow
def test_a_lamp_in_a_mirror_counts_once():
    """Mirrors are followed by rays: BRDF samples at the glossy floor add nothing to them."""
    mirror = Look(kind="mirror", specular=(0.9, 0.9, 0.9))
    parts = (*STAGE.parts, quad((-1.5, 0, -1.2), (3, 0, 0), (0, 2, 0), look=mirror))
    scene = replace(STAGE, parts=parts).to_viscache()
    whitted = vc.Whitted(n_vpls=0, n_area=16, n_brdf=16)
    light = area_layers(scene, replace(whitted, n_area=64, n_brdf=0), spp=16, first=100)
    both = area_layers(scene, whitted, spp=16)
    assert compare(both, light).same
    assert not compare(1.06 * both, light).same
    frames = [vc.render(scene, i, size=SIZE) for i in (whitted, replace(whitted, n_brdf=0))]
    assert frames[0].layers["emitted"].any()
    np.testing.assert_array_equal(*(f.layers["emitted"] for f in frames))


def holed_lamp(alpha):
    """A lamp with holes before another one, over a glossy floor."""
    checks = np.full((8, 8, 4), 1, np.float32)
    checks[::2, ::2, 3] = alpha
    d = vc.SceneDescription()
    kind = _core.MaterialKind.GLOSSY
    floor = d.add_material(kind, base_color=(0.2, 0.2, 0.2), roughness=0.2)
    holes = d.add_material(alpha_texture=d.add_image(checks))
    plain = d.add_material()
    for part, material in (
        (quad((-3, 0, -3), (0, 0, 6), (6, 0, 0)), floor),
        (quad((-1, 0.3, -0.5), (2, 0, 0), (0, 1, 0), emission=(2, 3, 4)), holes),
        (quad((-1, 0.3, -1.0), (2, 0, 0), (0, 1, 0), emission=(9, 5, 2)), plain),
    ):
        given = {"uvs": part.uvs, "emission": part.emission}
        d.add_mesh(part.vertices, part.triangles, material=material, **given)
    d.add_camera((0.3, 1.2, 3.0), (0, 0.2, 0), up=(0, 1, 0), fov_deg=45)
    return vc.Scene.from_description(d)


@pytest.mark.stat
def test_lamps_with_holes_hide_nothing_from_brdf_samples():
    light = area_layers(holed_lamp(0.0), REFERENCE, first=100)
    assert compare(area_layers(holed_lamp(0.0), BOTH, spp=8), light).same
    assert not compare(area_layers(holed_lamp(1.0), BOTH, spp=8), light).same


@pytest.mark.parametrize("lights", [12, 500])
def test_rays_find_the_nearest_light(lights):
    """As Embree does among the lights alone, by the list and by the tree."""
    random = np.random.default_rng(lights)
    d = vc.SceneDescription()
    d.add_material()
    corners = random.normal(size=(lights, 1, 3)) * 2 + random.normal(size=(lights, 3, 3)) * 0.4
    corners[: lights // 3, :, 1] = 0.5 + 0.01 * np.arange(lights // 3)[:, None]  # flat boxes
    for t in corners.astype(np.float32):
        d.add_mesh(t, np.array([[0, 1, 2]]), emission=(1, 1, 1))
    scene = vc.Scene.from_description(d)
    n = 20000
    o = random.normal(size=(n, 3)).astype(np.float32) * 3
    o[:2000, 1] = 0.5
    way = corners[random.integers(0, lights, n)].mean(axis=1) + random.normal(size=(n, 3)) * 0.2 - o
    way[1000:3000, 1] = 0
    way = (way / np.linalg.norm(way, axis=1, keepdims=True)).astype(np.float32)
    light, point = testing.nearest_emitter(scene._core, o, way)
    hit = scene.intersect(o, way)
    same = light == hit.triangle
    # Rays through an edge, and those in the plane of a triangle, may differ
    assert same[3000:].mean() > 0.9999 and same[2000:].mean() > 0.999
    assert (light[3000:] >= 0).mean() > 0.1
    both = same & (light >= 0)
    np.testing.assert_allclose(
        point[both], o[both] + way[both] * hit.t[both, None], atol=1e-5 * float(hit.t[both].max())
    )


def test_rays_find_spheres_and_what_they_hide():
    d = vc.SceneDescription()
    d.add_material()
    d.add_sphere_light((0, 0, -3), 1, (1, 1, 1))
    d.add_sphere_light((0, 0, -8), 4, (1, 1, 1))
    scene = vc.Scene.from_description(d)
    o = np.zeros((4, 3), np.float32)
    o[3] = (0, 0, -3)
    ways = np.array([(0, 0, -1), (0, 0, 0), (0, 0, 1), (0, 1, 0)], np.float32)
    ways[1] = np.array([3.7, 0, -8]) / np.linalg.norm([3.7, 0, -8])
    light, point = testing.nearest_emitter(scene._core, o, ways)
    assert list(light) == [0, 1, -1, 0]
    np.testing.assert_allclose(point[0], (0, 0, -2), atol=1e-6)
    np.testing.assert_allclose(point[3], (0, 1, -3), atol=1e-6)


def test_caches_see_the_brdf_samples():
    """Their queries go through the oracle as all others; a fine cache gives the exact picture."""
    scene, fine = STAGE.to_viscache(), vc.Aqvc(c_e=1, c_l=0.05, exact_groups=())
    light, both = (vc.render(scene, i, size=SIZE, visibility=fine) for i in (LIGHT, BOTH))
    exact = vc.render(scene, BOTH, size=SIZE)
    assert both.counters["queries"] == exact.counters["queries"] > light.counters["queries"]
    assert vc.metrics.compare(both, exact)["rel_l1"] < 0.05
