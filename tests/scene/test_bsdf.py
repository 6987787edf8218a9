"""scene/bsdf.h: reflection of diffuse and glossy materials."""

import numpy as np
import pytest

from core import testing
from sampling.chi_square import sphere_p_value, sphere_points, uniforms
from viscache._core import CoatKind, MaterialKind
from viscache._core.sampling import ShadingPoint, eval_bsdf

N = 200_000


def direction(cos_o, azimuth=0.7):
    s = np.sqrt(1 - cos_o**2)
    return (s * np.cos(azimuth), s * np.sin(azimuth), cos_o)


def glossy(cos_o=0.7, roughness=0.3, base=(0, 0, 0), specular=(1, 1, 1), **more):
    """`more`: coat, metal, microfacets and normals."""
    colours = {"base": base, "specular": specular}
    return ShadingPoint(
        MaterialKind.GLOSSY, direction(cos_o), roughness=roughness, **colours, **more
    )


def unit(v):
    x, y, z = np.array(v) / np.linalg.norm(v)
    return (x, y, z)


TILTED = {"ns": unit((0.3, 0.1, 1)), "ng": unit((-0.1, 0.2, 1))}
COPPER = {"metal_eta": (0.201, 0.9237, 1.1022), "metal_k": (3.9133, 2.453, 2.1421)}
POINTS = {
    "diffuse": ShadingPoint(MaterialKind.DIFFUSE, direction(0.4), base=(0.8, 0.5, 0.2)),
    "diffuse, tilted normals": ShadingPoint(
        MaterialKind.DIFFUSE, direction(0.6), base=(0.8, 0.5, 0.2), **TILTED
    ),
    "metal": glossy(),
    "smoother metal": glossy(0.8, 0.12),
    "rough metal at grazing angle": glossy(0.1, 1.0),
    "plastic": glossy(0.5, 0.2, (0.2, 0.6, 0.3), (0.04, 0.04, 0.04)),
    "plastic, tilted normals": glossy(0.5, 0.4, (0.2, 0.6, 0.3), (0.04, 0.1, 0.04), **TILTED),
    "smooth coat": glossy(0.5, 0.2, (0.2, 0.6, 0.3), coat=CoatKind.SMOOTH),
    "rough coat, tilted normals": glossy(0.5, 0.4, (0.2, 0.6, 0.3), coat=CoatKind.ROUGH, **TILTED),
    "copper": glossy(0.5, 0.3, **COPPER),
    "Beckmann's copper, tilted normals": glossy(0.7, 0.3, beckmann=True, **COPPER, **TILTED),
    "Beckmann's rough copper": glossy(0.3, 0.8, beckmann=True, **COPPER),
    "Beckmann's coat": glossy(0.5, 0.2, (0.2, 0.6, 0.3), coat=CoatKind.BECKMANN),
    "mix": glossy(0.5, 0.2, (0.2, 0.6, 0.3), (0.04, 0.02, 0.03), coat=CoatKind.FRESNEL_MIX),
    "mix, tilted normals": glossy(
        0.5, 0.4, (0.2, 0.6, 0.3), (0.01, 0.02, 0), coat=CoatKind.FRESNEL_MIX, f90=0.5, **TILTED
    ),
}
each_point = pytest.mark.parametrize("name", POINTS)


@each_point
@pytest.mark.stat
def test_directions_follow_their_density(name):
    sp = POINTS[name]
    wi, _, pdf = testing.sample_bsdf(sp, uniforms(N, 3))
    assert (
        sphere_p_value(
            wi[pdf > 0], lambda w: testing.pdf_bsdf(sp, w), (32, 64), sub=16, n_samples=N
        )
        >= 1e-3
    )


@pytest.mark.stat
def test_a_wrong_density_is_found():
    """Negative controls: 15 % rougher; another share of the lobes."""
    wi, _, pdf = testing.sample_bsdf(glossy(), uniforms(N, 3))
    wi = wi[pdf > 0]
    rougher = glossy(roughness=0.345)
    assert sphere_p_value(wi, lambda w: testing.pdf_bsdf(rougher, w), (32, 64), n_samples=N) < 1e-6
    wi, _, pdf = testing.sample_bsdf(POINTS["plastic"], uniforms(N, 3))
    darker = glossy(0.5, 0.2, (0.1, 0.3, 0.15), (0.04, 0.04, 0.04))
    assert (
        sphere_p_value(wi[pdf > 0], lambda w: testing.pdf_bsdf(darker, w), (32, 64), n_samples=N)
        < 1e-6
    )


@each_point
def test_samples_report_what_evaluation_gives(name):
    sp = POINTS[name]
    ns = np.array(TILTED["ns"] if "tilted" in name else (0, 0, 1))
    wi, weight, pdf = testing.sample_bsdf(sp, uniforms(2000, 3))
    wi, weight, pdf = wi[pdf > 0], weight[pdf > 0], pdf[pdf > 0]
    assert np.linalg.norm(wi.astype(float), axis=1) == pytest.approx(1, abs=1e-6)
    np.testing.assert_allclose(pdf, testing.pdf_bsdf(sp, wi), rtol=1e-6)
    expected = eval_bsdf(sp, wi) * (wi @ ns / pdf)[:, None]
    np.testing.assert_allclose(weight, expected, rtol=1e-4, atol=1e-12)


@each_point
def test_reflection_is_the_same_both_ways(name):
    normals = TILTED if "tilted" in name else {}
    rng = np.random.default_rng(5)
    w = rng.normal(size=(200, 2, 3))
    w /= np.linalg.norm(w, axis=2, keepdims=True)

    def f(wo, wi):
        if name.startswith("diffuse"):
            sp = ShadingPoint(MaterialKind.DIFFUSE, wo, base=(0.8, 0.5, 0.2), **normals)
        else:
            sp = ShadingPoint(
                MaterialKind.GLOSSY,
                wo,
                base=(0.2, 0.6, 0.3),
                specular=(0.04, 0.3, 1),
                roughness=0.4,
                coat=CoatKind.ROUGH
                if "coat" in name
                else CoatKind.FRESNEL_MIX
                if "mix" in name
                else CoatKind.NONE,
                beckmann="Beckmann" in name,
                **normals,
            )
        return eval_bsdf(sp, wi[None])[0]

    there = np.array([f(a, b) for a, b in w])
    assert there == pytest.approx(np.array([f(b, a) for a, b in w]), rel=1e-4, abs=1e-7)
    assert 20 < np.count_nonzero(there.any(1)) < 100


#: (1 − V·H)⁵ times the reflectance at grazing incidence, and cosines and azimuths
MIX_SPECULAR, MIX_BASE = np.array([0.04, 0.02, 0.01]), np.array([0.8, 0.5, 0.2])
ANGLES = [(t, a) for t in (0, 20, 40, 60, 75, 85) for a in (0, 50, 180)]


def gltf_formula(wo, wi, alpha, f90):
    """dielectric_brdf of glTF 2.0, appendix B, with KHR_materials_specular."""
    h = (wo + wi) / np.linalg.norm(wo + wi)
    n_l, n_v, n_h, v_h, a2 = wi[2], wo[2], h[2], wo @ h, alpha**2
    d = a2 / (np.pi * (n_h**2 * (a2 - 1) + 1) ** 2)
    seen = [2 * x / (x + np.sqrt(a2 + (1 - a2) * x**2)) for x in (n_l, n_v)]
    lobe = d * seen[0] * seen[1] / (4 * n_l * n_v)
    fresnel = MIX_SPECULAR + (f90 - MIX_SPECULAR) * (1 - v_h) ** 5
    return (1 - fresnel.max()) * MIX_BASE / np.pi + fresnel * lobe


@pytest.mark.parametrize("f90", [1, 0.3])
@pytest.mark.parametrize("alpha", [1.0, 0.25, 0.09])
def test_a_fresnel_mix_is_the_formula_of_gltf(alpha, f90):
    def at(theta, azimuth):
        t, a = np.radians([theta, azimuth])
        return np.array([np.sin(t) * np.cos(a), np.sin(t) * np.sin(a), np.cos(t)])

    for theta in (0, 30, 60, 80):
        wo, wi = at(theta, 180), np.array([at(*w) for w in ANGLES])
        sp = ShadingPoint(
            MaterialKind.GLOSSY,
            tuple(wo),
            base=tuple(MIX_BASE),
            specular=tuple(MIX_SPECULAR),
            roughness=alpha,
            coat=CoatKind.FRESNEL_MIX,
            f90=f90,
        )
        want = [gltf_formula(wo, w, alpha, f90) for w in wi]
        np.testing.assert_allclose(eval_bsdf(sp, wi), want, rtol=1e-5, atol=1e-6)


def albedo(sp, n=1 << 14):
    """Mean weight over low-discrepancy points: the share of a white furnace's light."""
    index = np.arange(n, dtype=np.uint32)
    u = np.concatenate(
        [testing.sobol02(index, 1, 2), ((np.arange(n) + 0.5) / n).astype(np.float32)[:, None]], 1
    )
    u[:, 0] = np.random.default_rng(0).permutation(u[:, 0])
    return testing.sample_bsdf(sp, u)[1].astype(float).mean(0)


@pytest.mark.parametrize("cos_o", [1.0, 0.6, 0.3, 0.02])
def test_what_a_fresnel_mix_leaves_to_the_base_is_a_mean_over_directions(cos_o):
    cosine, azimuth = np.meshgrid(
        np.sqrt((np.arange(512) + 0.5) / 512), np.arange(256) / 128 * np.pi
    )
    across = np.sqrt((1 - cosine**2) * (1 - cos_o**2)) * np.cos(azimuth)
    weight = (1 - np.sqrt((1 + cosine * cos_o + across) / 2)) ** 5
    sp = glossy(cos_o, base=(0.8,) * 3, specular=(0.04,) * 3, coat=CoatKind.FRESNEL_MIX)
    want = 0.8 * (1 - 0.04 - 0.96 * weight.mean())
    assert testing.diffuse_albedo(sp)[0] == pytest.approx(want, abs=3e-5)


def test_a_fresnel_mix_reflects_less_than_arrives_below_a_base_of_095():
    cosines = (np.arange(8) + 0.5) / 8

    def mean(base, roughness):
        """Over light from all sides."""
        f0 = (0.04, 0.04, 0.04)
        look = {"specular": f0, "coat": CoatKind.FRESNEL_MIX}
        all_sides = [albedo(glossy(c, roughness, (base,) * 3, **look))[0] for c in cosines]
        return np.average(all_sides, weights=cosines)

    assert max(mean(0.95, roughness) for roughness in (0.01, 0.1, 0.3, 0.6, 1.0)) < 1
    # What the docs say of the formula
    assert mean(1, 0.01) > 1


def test_a_diffuse_surface_reflects_its_base_color():
    for cos_o in (1.0, 0.5, 0.01):
        sp = ShadingPoint(MaterialKind.DIFFUSE, direction(cos_o), base=(1, 0.5, 0))
        assert albedo(sp) == pytest.approx([1, 0.5, 0], abs=1e-5)


@pytest.mark.parametrize("f0", [0.0, 0.04, 0.3, 0.8, 1.0])
@pytest.mark.parametrize("roughness", [1e-3, 0.05, 0.2, 0.5, 1.0])
def test_a_white_surface_never_reflects_more_than_arrives(f0, roughness):
    for cos_o in (1.0, 0.9, 0.7, 0.5, 0.3, 0.15, 0.05, 0.01):
        sp = glossy(cos_o, roughness, (1, 1, 1), (f0, f0, f0))
        lobe = albedo(glossy(cos_o, roughness, (0, 0, 0), (f0, f0, f0)))
        fresnel = f0 + (1 - f0) * (1 - cos_o) ** 5
        # The diffuse part's albedo is known (see below), so only the lobe is integrated
        assert (lobe + 0.9972 * (1 - fresnel)).max() <= 1 + 1e-4
        assert albedo(sp).max() <= 1 + 3e-3  # both together, with the noise of choosing lobes


def test_a_smooth_white_metal_reflects_all_light():
    assert albedo(glossy(0.7, 1e-3)) == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("cos_o", [1.0, 0.6, 0.2])
def test_the_diffuse_part_gets_what_the_glossy_part_leaves(cos_o):
    """∫ (f − f_glossy) cos = 0.9971 · base · (1 − F(cos_o)), after Shirley et al. 1997."""
    base, specular = (0.9, 0.5, 0.1), (0.04, 0.3, 0.9)
    points = sphere_points(512, 64, (0, 1)).reshape(-1, 3).astype(np.float32)
    diffuse = eval_bsdf(glossy(cos_o, 0.5, base, specular), points).astype(float)
    diffuse -= eval_bsdf(glossy(cos_o, 0.5, (0, 0, 0), specular), points)
    reflected = (diffuse * points[:, 2:]).mean(0) * 2 * np.pi
    fresnel = np.array(specular) + (1 - np.array(specular)) * (1 - cos_o) ** 5
    assert reflected == pytest.approx(0.9971 * np.array(base) * (1 - fresnel), abs=1e-4)
    assert testing.diffuse_albedo(glossy(cos_o, 0.5, base, specular)) == pytest.approx(
        reflected, abs=1e-4
    )


def test_the_diffuse_part_of_other_materials_is_the_base_color_or_nothing():
    for kind, share in (("DIFFUSE", 1), ("MIRROR", 0), ("DIELECTRIC", 0)):
        sp = ShadingPoint(MaterialKind[kind], direction(0.3), base=(0.75, 0.5, 0.25))
        assert testing.diffuse_albedo(sp) == [share * v for v in (0.75, 0.5, 0.25)]
    below = ShadingPoint(MaterialKind.DIFFUSE, (0, 0, -1), base=(1, 1, 1))
    assert testing.diffuse_albedo(below) == [0, 0, 0]


def test_nothing_is_reflected_below_either_normal():
    w = testing.square_to_uniform_sphere(uniforms(4000, 2))
    above = (w @ np.array(TILTED["ns"]) > 0) & (w @ np.array(TILTED["ng"]) > 0)
    for name in (
        "diffuse, tilted normals",
        "plastic, tilted normals",
        "rough coat, tilted normals",
    ):
        assert np.array_equal(eval_bsdf(POINTS[name], w).max(1) > 0, above)
        assert np.array_equal(testing.pdf_bsdf(POINTS[name], w) > 0, above)
    # The eye below the geometric normal, above the shading normal
    hidden = ShadingPoint(
        MaterialKind.GLOSSY,
        unit((1, 0, 0.1)),
        ns=unit((1, 0, 1)),
        ng=unit((-1, 0, 1)),
        specular=(1, 1, 1),
    )
    assert not eval_bsdf(hidden, w).any() and not testing.pdf_bsdf(hidden, w).any()
    assert not testing.sample_bsdf(hidden, uniforms(100, 3))[2].any()


@pytest.mark.parametrize("kind", [MaterialKind.MIRROR, MaterialKind.DIELECTRIC])
def test_mirrors_and_glass_are_zero(kind):
    sp = ShadingPoint(kind, (0, 0, 1), base=(1, 1, 1), specular=(1, 1, 1))
    assert not eval_bsdf(sp, np.array([[0, 0, 1]])).any()
    assert not testing.pdf_bsdf(sp, np.array([[0, 0, 1]])).any()
    assert not testing.sample_bsdf(sp, uniforms(100, 3))[2].any()


@pytest.mark.extreme
@pytest.mark.parametrize("roughness", [1e-3, 1e-2, 1.0])
@pytest.mark.parametrize("cos_o", [1.0, 0.5, 1e-3, 1e-6])
def test_weights_stay_finite_and_below_one_for_a_metal(roughness, cos_o):
    wi, weight, pdf = testing.sample_bsdf(glossy(cos_o, roughness), uniforms(10_000, 3))
    assert np.isfinite(wi).all() and np.isfinite(weight).all() and np.isfinite(pdf).all()
    assert weight.min() >= 0 and weight.max() <= 1 + 1e-3
    # F = 1: what is left is the shadowing of wi
    some = pdf > 0
    shadowing = testing.smith_g1(wi[some, 2], roughness)
    np.testing.assert_allclose(weight[some, 0], shadowing, rtol=1e-3)
