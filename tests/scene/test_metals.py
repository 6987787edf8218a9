"""scene/conductor.h: metals by their complex index of refraction; Beckmann's microfacets."""

from pathlib import Path

import numpy as np
import pytest
from skimage.io import imsave

import viscache as vc
from scene.test_bsdf import direction
from scene.test_coat import above, of_mitsuba
from scene.test_metallic_roughness import waves
from scene.test_mitsuba_parity import VIEW, agreement
from scene.test_mitsuba_parity import of_mitsuba as frames_of_mitsuba
from scene.test_mitsuba_parity import of_viscache as frames_of_viscache
from viscache import _core as core
from viscache._core import MaterialKind
from viscache._core.sampling import ShadingPoint, eval_bsdf

COPPER = {
    "metal_eta": (0.201, 0.9237, 1.1022),
    "metal_k": (3.9133, 2.453, 2.1421),
}


def fresnel(cos, eta, k):
    """The unpolarised reflectance, from Fresnel's equations with complex numbers."""
    n = np.asarray(eta) + 1j * np.asarray(k)
    inside = np.sqrt(1 - (1 - cos**2) / n**2)
    across = (cos - n * inside) / (cos + n * inside)
    along = (n * cos - inside) / (n * cos + inside)
    return np.asarray((abs(across) ** 2 + abs(along) ** 2) / 2)


def metal(cos_o, roughness, *, beckmann=False, **more):
    given = {"specular": (1, 1, 1)} | COPPER | more
    return ShadingPoint(
        MaterialKind.GLOSSY, direction(cos_o), roughness=roughness, beckmann=beckmann, **given
    )


@pytest.mark.parametrize("cos", [1.0, 0.7, 0.2, 0.02])
@pytest.mark.parametrize(
    ("eta", "k"),
    [
        ((0.2, 0.9, 1.1), (3.9, 2.4, 2.1)),
        ((0, 1.5, 40), (1, 0, 60)),
        ((9e3, 1e-3, 1), (1, 9e3, 0.1)),
    ],
)
def test_a_metal_reflects_by_fresnels_equations(cos, eta, k):
    """The lobe divided by that of a perfect mirror, at the mirror direction."""
    wi = np.array([direction(cos, 0.7 + np.pi)])
    ours = eval_bsdf(metal(cos, 0.3, metal_eta=eta, metal_k=k), wi)[0]
    perfect = ShadingPoint(MaterialKind.GLOSSY, direction(cos), specular=(1, 1, 1), roughness=0.3)
    np.testing.assert_allclose(ours / eval_bsdf(perfect, wi)[0], fresnel(cos, eta, k), rtol=1e-3)


@pytest.mark.mitsuba
@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
@pytest.mark.parametrize("alpha", [0.02, 0.1, 0.4, 1.0])
@pytest.mark.parametrize("cos_o", [0.9, 0.4, 0.05])
def test_a_rough_metal_is_mitsubas(cos_o, alpha, distribution):
    rng, mirror = np.random.default_rng(4), np.array(direction(cos_o, 0.7 + np.pi))
    near = mirror + 2 * alpha * rng.normal(size=(100, 3))
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    wi = np.concatenate([near[near[:, 2] > 0.02], above(40)])
    plugin = {"type": "roughconductor", "material": "Cu", "alpha": alpha}
    theirs = of_mitsuba(plugin | {"distribution": distribution}, direction(cos_o), wi)

    def ours(beckmann, **more):
        return eval_bsdf(metal(cos_o, alpha, beckmann=beckmann, **more), wi) * wi[:, 2:]

    bright = theirs.max(1) > 1e-3 * theirs.max()
    right = distribution == "beckmann"
    assert ours(right)[bright] == pytest.approx(theirs[bright], rel=4e-3)
    # Power: the other microfacets, and the approximation that took the place of Fresnel's term
    assert np.abs(ours(not right)[bright] / theirs[bright] - 1).max() > 0.1
    schlick = ShadingPoint(
        MaterialKind.GLOSSY,
        direction(cos_o),
        specular=tuple(fresnel(1, *COPPER.values())),
        roughness=alpha,
        beckmann=right,
    )
    wrong = eval_bsdf(schlick, wi) * wi[:, 2:]
    if cos_o < 0.5:  # towards the normal, both are alike
        assert np.abs(wrong[bright] / theirs[bright] - 1).max() > 0.02


def test_specular_scales_the_reflection_of_a_metal():
    wi = np.array([direction(0.3, 0.7 + np.pi)])
    part = eval_bsdf(metal(0.3, 0.2, specular=(0.5, 0.25, 0)), wi)
    assert part == pytest.approx(eval_bsdf(metal(0.3, 0.2), wi) * [0.5, 0.25, 0])


PLANE = """<shape type="rectangle"><transform name="to_world"><scale value="5"/>
<rotate x="1" angle="-90"/></transform>{bsdf}</shape>
<shape type="rectangle"><transform name="to_world"><scale x="2" y="1.2"/>
<rotate x="1" angle="10"/><translate y="4.7" z="-3.2"/></transform>
<emitter type="area"><rgb name="radiance" value="6,5,4"/></emitter></shape>
<emitter type="constant"><rgb name="radiance" value="0.3,0.35,0.4"/></emitter>"""


def write(folder, bsdf):
    path = folder / "scene.xml"
    path.write_text(f'<scene version="3.0.0">{VIEW}{PLANE.format(bsdf=bsdf)}</scene>')
    return path


@pytest.mark.slow
@pytest.mark.mitsuba
@pytest.mark.parametrize(
    "distribution", [pytest.param("ggx", marks=pytest.mark.release), "beckmann"]
)
def test_an_image_of_alpha_is_that_of_mitsuba(tmp_path, distribution):
    imsave(tmp_path / "rough.png", waves(0, 25, 130), check_contrast=False)
    image = """<texture type="bitmap" name="alpha"><string name="filename" value="rough.png"/>
    <boolean name="raw" value="true"/></texture>"""

    def rough(alpha):
        lobe = f'<string name="distribution" value="{distribution}"/>'
        gold = '<string name="material" value="Au"/>'
        return write(tmp_path, f'<bsdf type="roughconductor">{alpha}{lobe}{gold}</bsdf>')

    path = rough(image)
    assert not vc.load_scene(path).warnings
    ours, theirs = frames_of_viscache(path), frames_of_mitsuba(path)
    assert agreement(ours, theirs) >= 0.95
    assert np.mean(ours, (0, 1, 2)) == pytest.approx(np.mean(theirs, (0, 1, 2)), rel=0.01)
    assert agreement(np.multiply(ours, 1.05), theirs) < 0.9
    even = frames_of_viscache(rough('<float name="alpha" value="0.3"/>'))
    assert agreement(even, theirs) < 0.9


def in_a_mirror(integrator, **material):
    """A white sky in a floor, seen at a slant."""
    floor = [[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]]
    scene = vc.Scene.from_arrays([(floor, [[0, 2, 1], [0, 3, 2]], material)], env=1.0)
    view = vc.look_at((0, 1, 3), (0, 0, 0), fov_deg=2)
    return vc.render(scene, integrator, camera=view, size=(8, 8), spp=4).image.mean((0, 1))


@pytest.mark.parametrize("integrator", [vc.Direct(), vc.Bdpt(max_depth=3)], ids=["direct", "bdpt"])
def test_a_mirror_of_metal_is_tinted_by_its_angle(integrator):
    cos = 1 / np.sqrt(10)
    seen = in_a_mirror(integrator, kind="mirror", **COPPER)
    assert seen == pytest.approx(fresnel(cos, *COPPER.values()), rel=2e-3)
    upright = fresnel(1, *COPPER.values())
    assert np.abs(seen / upright - 1).max() > 0.02
    half = in_a_mirror(integrator, kind="mirror", specular=(0.5, 0.5, 0.5), **COPPER)
    assert half == pytest.approx(seen / 2, rel=1e-3)


def test_photons_are_tinted_by_a_mirror_as_eye_paths_are():
    """A narrow beam by way of a mirror to a wall, whose virtual lights shine on another wall."""

    def lit(**material):
        d = vc.SceneDescription()
        wall = d.add_material()
        mirror = d.add_material(MaterialKind.MIRROR, **material)
        faces = [[0, 1, 2], [0, 2, 3]]
        for corners, surface in (
            ([[-3, 0, -3], [3, 0, -3], [3, 0, 3], [-3, 0, 3]], mirror),
            ([[4, 0, -3], [4, 6, -3], [4, 6, 3], [4, 0, 3]], wall),
            ([[-4, 0, 3], [4, 0, 3], [4, 6, 3], [-4, 6, 3]], wall),
        ):
            d.add_mesh(corners, faces, material=surface)
        to_light = np.array([-np.sqrt(8), 1, 0])
        d.add_point_light(to_light, (9e4, 9e4, 9e4), axis=-to_light, cone_deg=(0.5, 1))
        scene = vc.Scene.from_description(d)
        view = vc.look_at((0, 2, -3), (2, 3.5, 3), fov_deg=20)
        by = vc.Whitted(n_vpls=64, vpl_max_depth=2)
        return vc.render(scene, by, camera=view, size=(16, 16), spp=1).image.mean((0, 1))

    assert lit().min() > 1e-4
    assert lit(**COPPER) / lit() == pytest.approx(fresnel(1 / 3, *COPPER.values()), rel=0.01)


@pytest.mark.mitsuba
def test_the_named_metals_are_those_of_mitsuba(tmp_path):
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("scalar_rgb")
    folder = Path(mi.__file__).parent / "data" / "ior"
    names = sorted({f.name.split(".")[0] for f in folder.iterdir()})
    assert len(names) > 60
    for name in names:
        bsdf = f'<bsdf type="conductor"><string name="material" value="{name}"/></bsdf>'
        scene = core.load_scene_file(str(write(tmp_path, bsdf)))
        if name.startswith("AlSb"):  # no index of red light in Mitsuba
            assert len(scene.warnings) == 1
            continue
        assert not scene.warnings
        theirs = mi.traverse(mi.load_dict({"type": "conductor", "material": name}))
        for ours, key in (("metal_eta", "eta.value"), ("metal_k", "k.value")):
            assert scene.materials[0][ours] == pytest.approx(np.ravel(theirs[key]), abs=1e-4)
