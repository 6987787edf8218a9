"""sampling/warp.h: samplers beside their densities."""

import numpy as np
import numpy.typing as npt
import pytest

from core import testing
from sampling.chi_square import p_value, sphere_mass, sphere_p_value, uniforms

N = 200_000
Rows = npt.NDArray[np.float32]


def constant(value, z_min=-1.0):  # type: ignore[no-untyped-def]
    return lambda w: np.where(w[:, 2] >= z_min, value, 0.0)


CONE = constant(testing.pdf_uniform_cone(0.5), 0.5)
HEMISPHERE = constant(testing.pdf_uniform_hemisphere(), 0)
SPHERICAL = {
    "cosine hemisphere": (testing.square_to_cosine_hemisphere, testing.pdf_cosine_hemisphere),
    "uniform hemisphere": (testing.square_to_uniform_hemisphere, HEMISPHERE),
    "uniform sphere": (testing.square_to_uniform_sphere, constant(testing.pdf_uniform_sphere())),
    "cone of 60 degrees": (lambda u: testing.square_to_uniform_cone(u, 0.5), CONE),
}


@pytest.mark.parametrize("name", SPHERICAL)
def test_directions_are_unit_and_densities_integrate_to_one(name):
    sample, pdf = SPHERICAL[name]
    directions = sample(uniforms(1000, 2)).astype(float)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(1, abs=1e-6)
    assert sphere_mass(pdf, (16, 16)).sum() == pytest.approx(1, abs=1e-6)


@pytest.mark.stat
@pytest.mark.parametrize("name", SPHERICAL)
def test_directions_follow_their_density(name):
    sample, pdf = SPHERICAL[name]
    assert sphere_p_value(sample(uniforms(N, 2)), pdf) >= 1e-3


@pytest.mark.stat
def test_a_wrong_density_is_found():
    """Negative controls: another sampler, and a tilt of 15 %."""
    uniform = testing.square_to_uniform_hemisphere(uniforms(N, 2))
    assert sphere_p_value(uniform, testing.pdf_cosine_hemisphere) < 1e-6
    tilted = sphere_p_value(
        uniform, lambda w: (w[:, 2] >= 0) * (1 + 0.15 * (w[:, 2] - 0.5)) / 2 / np.pi
    )
    assert tilted < 1e-6


@pytest.mark.stat
def test_the_disk_is_uniform_around_the_middle_of_the_square():
    x, y = testing.square_to_disk_concentric(uniforms(N, 2)).T.astype(float)
    r2 = x * x + y * y
    assert r2.max() <= 1 + 1e-6
    counts = np.histogram2d(r2, np.arctan2(y, x), (16, 32), [(0, 1 + 1e-6), (-np.pi, np.pi)])[0]
    assert p_value(counts, np.full(counts.shape, N / counts.size)) >= 1e-3
    assert testing.square_to_disk_concentric(np.array([[0.5, 0.5]])).tolist() == [[0, 0]]


@pytest.mark.stat
def test_the_triangle_is_uniform():
    b1, b2 = testing.square_to_triangle(uniforms(N, 2)).T.astype(float)
    assert b1.min() >= 0 and b2.min() >= 0 and (b1 + b2).max() <= 1 + 1e-6
    # 16² congruent small triangles: two of them in each square cell, but for the diagonal
    i, j = (16 * b1).astype(int), (16 * b2).astype(int)
    upper = (16 * b1 - i) + (16 * b2 - j) > 1
    counts = np.bincount((i * 17 + j) * 2 + upper, minlength=17 * 17 * 2).astype(float)
    inside = np.array([[(i + j + up) <= 15 for up in (0, 1)] for i in range(17) for j in range(17)])
    assert inside.sum() == 256
    assert p_value(counts[inside.ravel()], np.full(256, N / 256)) >= 1e-3


@pytest.mark.extreme
def test_narrow_cones_keep_their_digits():
    cos_max = np.float32(1 - 2**-20)
    w = testing.square_to_uniform_cone(np.array([[1 - 2**-24, 0.0]], dtype=np.float32), cos_max)
    assert w[0, 0] == pytest.approx(np.sqrt(1 - float(cos_max) ** 2), rel=1e-4)


def facing(origin, p):
    """Unit directions from the origin, and distances, in double."""
    d = p.astype(float) - origin
    distance = np.linalg.norm(d, axis=1)
    return d / distance[:, None], distance


def test_both_densities_of_a_sphere_give_its_irradiance():
    """E = π L (r/d)² on a surface that faces the sphere."""
    u = np.stack(np.meshgrid(*2 * [(np.arange(256, dtype=np.float32) + 0.5) / 256]), -1).reshape(
        -1, 2
    )
    p, n, pdf, pdf_area = testing.sample_sphere_light((0, 0, 3), 1.0, (0, 0, 0), u)
    w, d = facing(np.zeros(3), p)
    assert np.mean(w[:, 2] / pdf) == pytest.approx(np.pi / 9, rel=1e-4)
    by_area = w[:, 2] * -(w * n).sum(1) / d**2 / pdf_area
    assert np.mean(by_area) == pytest.approx(np.pi / 9, rel=1e-3)


@pytest.mark.extreme
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("distance", [1 + 1e-6, 1e3, 1e8])
def test_spheres_of_any_size_and_distance_give_finite_densities(scale, distance):
    u = np.append(uniforms(1000, 2), [[0, 0], [1 - 2**-24] * 2], 0)
    found = testing.sample_sphere_light((0, 0, 0), scale, (0, 0, distance * scale), u)
    _, _, pdf, pdf_area = found
    for values in found:
        assert np.isfinite(values).all()
    assert (pdf > 0).all() and (pdf_area > 0).all()
    if distance > 10:
        assert pdf == pytest.approx(distance**2 / np.pi, rel=1e-3)


@pytest.mark.parametrize(("radius", "z"), [(1.0, 0.0), (1.0, 0.5), (1.0, 1.0), (0.0, 2.0)])
def test_there_is_no_sample_unless_outside_a_sphere_of_some_size(radius, z):
    assert testing.sample_sphere_light((0, 0, 0), radius, (0, 0, z), uniforms(4, 2)) is None


def stretched(alpha, bins=256, sub=4):
    """Normals that tile the hemisphere evenly once slopes are divided by alpha; solid angles.

    Rows are even in v, the cosine of the stretched normal (slope s = alpha √(1 − v²)/v),
    columns in azimuth.
    """
    n = bins * sub
    v = (np.arange(n) + 0.5) / n
    s = alpha * np.sqrt(1 - v**2) / v
    phi = (np.arange(512) + 0.5) / 512 * 2 * np.pi
    z = 1 / np.sqrt(1 + s**2)
    x, y = np.outer(s * z, np.cos(phi)), np.outer(s * z, np.sin(phi))
    h = np.stack([x, y, np.repeat(z[:, None], 512, 1)], -1)
    # dω = z³ s ds dφ and s ds = −α² dv/v³
    dw = z**3 * alpha**2 / v**3 / n * 2 * np.pi / 512
    return h.reshape(-1, 3).astype(np.float32), np.repeat(dw, 512)


@pytest.mark.parametrize("alpha", [1e-3, 0.05, 0.3, 1.0])
def test_the_projected_area_of_the_microfacets_is_one(alpha):
    h, dw = stretched(alpha)
    assert (testing.ggx_d(h, alpha) * h[:, 2] * dw).sum() == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("alpha", [1e-3, 0.05, 0.3, 1.0])
@pytest.mark.parametrize("cos_o", [0.999, 0.5, 0.1])
def test_visible_normals_have_a_density_that_integrates_to_one(alpha, cos_o):
    """∫ G1 D max(0, wo·h) dω = cos_o: this ties G1 to D."""
    h, dw = stretched(alpha, bins=1024)
    wo = (np.sqrt(1 - cos_o**2), 0.0, cos_o)
    assert (testing.pdf_ggx_vndf(wo, h, alpha) * dw).sum() == pytest.approx(1, abs=5e-3)


@pytest.mark.slow
@pytest.mark.stat
@pytest.mark.parametrize("alpha", [1e-3, 0.1, 0.5, 1.0])
@pytest.mark.parametrize("cos_o", [1.0, 0.6, 0.1])
def test_visible_normals_follow_their_density(alpha, cos_o):
    wo = (np.sqrt(1 - cos_o**2) * 0.8, np.sqrt(1 - cos_o**2) * 0.6, cos_o)
    x, y, z = testing.sample_ggx_vndf(wo, alpha, uniforms(N, 2)).astype(float).T
    assert x * x + y * y + z * z == pytest.approx(1, abs=1e-6)
    v, azimuth = (1 + (x * x + y * y) / z**2 / alpha**2) ** -0.5, np.arctan2(y, x) % (2 * np.pi)
    counts = np.histogram2d(v, azimuth, (16, 32), [(0, 1), (0, 2 * np.pi)])[0]
    h, dw = stretched(alpha, bins=16, sub=64)

    def p(assumed):
        mass = (testing.pdf_ggx_vndf(wo, h, assumed) * dw).reshape(16, 64, 32, 16).sum((1, 3))
        return p_value(counts, N * mass)

    assert p(alpha) >= 1e-3
    assert alpha == 1 or p(1.1 * alpha) < 1e-6


def test_smith_masking_has_its_limits():
    assert testing.smith_g1(np.array([1.0, 0.0, -0.5]), 0.5).tolist() == [1, 0, 0]
    assert testing.smith_g1(np.array([1e-30, 1e-10]), 0.5) == pytest.approx(0, abs=1e-9)
    g1 = testing.smith_g1(np.array([0.3, 0.7]), 0.4)
    assert testing.smith_g2(0.3, 0.7, 0.4) == pytest.approx(g1[0] * g1[1])


def test_schlick_goes_from_f0_to_one():
    f = testing.schlick((0.04, 0.5, 1.0), np.array([1.0, 0.5, 0.0]))
    assert f[0] == pytest.approx([0.04, 0.5, 1.0])
    assert f[1, 0] == pytest.approx(0.04 + 0.96 / 32)
    assert f[2] == pytest.approx([1, 1, 1])


@pytest.mark.parametrize("eta", [1.5, 1 / 1.5, 1.33, 2.4, 1.0])
def test_the_fresnel_term_is_that_of_amplitudes(eta):
    cos_i = np.linspace(0.01, 1, 100)
    for sign, n in ((1, eta), (-1, 1 / eta)):
        cos_t = np.emath.sqrt(1 - (1 - cos_i**2) / n**2)  # complex at total reflection
        s = (cos_i - n * cos_t) / (cos_i + n * cos_t)
        p = (n * cos_i - cos_t) / (n * cos_i + cos_t)
        expected = 0.5 * (np.abs(s) ** 2 + np.abs(p) ** 2)
        assert testing.fresnel_dielectric(sign * cos_i, eta) == pytest.approx(expected, abs=2e-5)


def test_the_fresnel_term_has_its_limits():
    assert testing.fresnel_dielectric(np.array([1.0, -1.0]), 1.5) == pytest.approx(0.04)
    assert testing.fresnel_dielectric(np.array([0.0, -0.0, -0.1, -0.74]), 1.5).tolist() == [1] * 4
    assert testing.fresnel_dielectric(np.array([-0.75]), 1.5)[0] < 1


@pytest.mark.parametrize("eta", [1.5, 0.7])
def test_refraction_obeys_snell_and_can_be_reversed(eta):
    n = np.array([0.0, 0.6, 0.8])
    wo = testing.square_to_uniform_sphere(uniforms(1000, 2)).astype(float)
    wo *= np.sign(wo @ n)[:, None]
    t = testing.refract(wo, n, 1 / eta).astype(float)
    total = np.isnan(t[:, 0])
    # Nothing passes exactly where the Fresnel term is one
    assert np.array_equal(total, testing.fresnel_dielectric(wo @ n, eta) == 1)
    assert total.any() == (eta < 1)
    wo, t = wo[~total], t[~total]
    assert np.linalg.norm(t, axis=1) == pytest.approx(1, abs=1e-5)
    assert eta * np.cross(n, t) == pytest.approx(-np.cross(n, wo), abs=1e-5)
    assert (t @ n).max() <= 0
    steep = wo @ n > 0.05  # at grazing angles rounding may bring total reflection on the way back
    assert testing.refract(t, -n, eta)[steep] == pytest.approx(wo[steep], abs=1e-4)
