"""scene/lobes.h: reflection sixteen directions at a time."""

import numpy as np
import pytest

from core import testing
from reference.isas import AVAILABLE
from scene.test_bsdf import COPPER, direction, glossy
from viscache._core import CoatKind, MaterialKind
from viscache._core.sampling import ShadingPoint, eval_bsdf

BENT = {"ns": (0.2, -0.1, float(np.sqrt(0.95)))}
POINTS = {
    "diffuse": ShadingPoint(MaterialKind.DIFFUSE, direction(0.6), base=(0.2, 0.5, 0.8)),
    "diffuse, bent": ShadingPoint(
        MaterialKind.DIFFUSE, direction(0.6), base=(0.2, 0.5, 0.8), **BENT
    ),
    "glossy": glossy(0.7, 0.3, base=(0.3, 0.2, 0.1), specular=(0.9, 0.5, 0.04)),
    "grazing": glossy(0.05, 0.1, base=(0.3, 0.2, 0.1), specular=(0.04, 0.04, 0.04)),
    "sharp": glossy(0.8, 1e-3, specular=(1, 1, 1)),
    "bent": glossy(0.7, 0.5, base=(0.3, 0.2, 0.1), specular=(0.2, 0.2, 0.2), **BENT),
    "coat": glossy(0.7, 0.3, base=(0.3, 0.2, 0.1), coat=CoatKind.SMOOTH),
    "grazing coat": glossy(0.05, 0.1, base=(0.3, 0.2, 0.1), coat=CoatKind.ROUGH),
    "bent coat": glossy(0.7, 0.5, base=(0.3, 0.2, 0.1), coat=CoatKind.ROUGH, **BENT),
    "copper": glossy(0.7, 0.3, **COPPER),
    "sharp copper": glossy(0.8, 1e-3, **COPPER),
    "Beckmann": glossy(0.7, 0.3, base=(0.3, 0.2, 0.1), specular=(0.9, 0.5, 0.04), beckmann=True),
    "Beckmann's copper, bent": glossy(0.7, 0.5, beckmann=True, **COPPER, **BENT),
    "grazing Beckmann's coat": glossy(0.05, 0.1, base=(0.3, 0.2, 0.1), coat=CoatKind.BECKMANN),
    "mix": glossy(
        0.7, 0.3, base=(0.3, 0.2, 0.1), specular=(0.04, 0.02, 0), coat=CoatKind.FRESNEL_MIX
    ),
    "grazing mix": glossy(
        0.05, 0.1, base=(0.3, 0.2, 0.1), specular=(0.01,) * 3, coat=CoatKind.FRESNEL_MIX, f90=0.4
    ),
    "sharp Beckmann's copper": glossy(0.8, 1e-3, beckmann=True, **COPPER),
}


def directions(sp_wo, n=4001):
    """All around, and close to the mirror direction of wo."""
    rng = np.random.default_rng(2)
    w = rng.normal(size=(n, 3))
    mirror = np.array(sp_wo) * [-1, -1, 1]
    w[: n // 2] = mirror + rng.normal(size=(n // 2, 3)) * 10 ** rng.uniform(-4, -0.7, (n // 2, 1))
    return (w / np.linalg.norm(w, axis=1, keepdims=True)).astype(np.float32)


@pytest.mark.parametrize("name", POINTS)
def test_batches_are_the_bsdf_times_the_cosine_and_its_density(name):
    sp = POINTS[name]
    cosines = {"grazing": 0.05, "sharp": 0.8, "diffuse": 0.6}
    cosine = next((c for word, c in cosines.items() if word in name), 0.7)
    w = directions(direction(cosine))
    ns = np.float32(BENT["ns"]) if "bent" in name else np.float32([0, 0, 1])
    f, pdf = testing.reflect_directions(sp, w)
    want = eval_bsdf(sp, w) * (w @ ns)[:, None]
    np.testing.assert_allclose(f, want, rtol=2e-3, atol=1e-6)
    np.testing.assert_allclose(pdf, testing.pdf_bsdf(sp, w), rtol=2e-3, atol=1e-6)
    # Beckmann's lobe ends where numbers do
    assert (f[(want == 0).all(1)] < 1e-20).all()
    assert (f[want > 1e-20] > 0).all() and 0.1 < (pdf > 0).mean() < 0.9


@pytest.mark.parametrize("name", POINTS)
@pytest.mark.parametrize("isa", AVAILABLE)
def test_every_instruction_set_reflects_the_same_bits(name, isa):
    w = directions((0.5, 0.5, 0.7), 333)
    for a, b in zip(
        testing.reflect_directions(POINTS[name], w, isa=isa),
        testing.reflect_directions(POINTS[name], w, isa="portable"),
        strict=True,
    ):
        np.testing.assert_array_equal(a, b)


@pytest.mark.extreme
def test_what_reflects_nothing_gives_zero():
    w = directions((0, 0, 1), 64)
    for sp in (
        ShadingPoint(MaterialKind.MIRROR, (0, 0, 1), specular=(1, 1, 1)),
        ShadingPoint(MaterialKind.DIELECTRIC, (0, 0, 1)),
        ShadingPoint(MaterialKind.DIFFUSE, (0, 0, 1)),
        glossy(0.7, base=(0.5, 0.5, 0.5), ns=(0.0, 0.0, -1.0)),
    ):
        assert not eval_bsdf(sp, w).any() and not testing.reflect_directions(sp, w)[0].any()
