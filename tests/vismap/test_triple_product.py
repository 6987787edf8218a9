"""vismap/triple_product.h: sums over light × reflection × maps equal those over single texels."""

import numpy as np
import pytest

from reference.isas import AVAILABLE
from viscache._core.vismap import EnvironmentPyramid, PointEstimate
from vismap.worlds import blended, cosine_lobe, dilations, luminance, morton, shares, sky

EDGE = 256


def kinds_of_maps(edge):
    rng = np.random.default_rng(edge)
    y, x = np.indices((edge, edge))
    window = (abs(x - 0.4 * edge) < edge / 10) & (abs(y - 0.7 * edge) < edge / 14)
    single = np.zeros((1, edge, edge), bool)
    single[0, edge - 1, 0] = True
    return {
        "random": rng.random((4, edge, edge)) < 0.5,
        "smooth": np.stack([x + k * y < 0.9 * edge for k in (0, 1, 2)]),
        "window": np.stack([np.roll(window, k, 1) for k in range(8)]),
        "full": np.ones((2, edge, edge), bool),
        "empty": np.zeros((2, edge, edge), bool),
        "single": single,
        "full and empty": np.stack([np.ones((edge, edge), bool), np.zeros((edge, edge), bool)]),
        "checkerboard": ((x + y) % 2 == 0)[None],
    }


@pytest.fixture(scope="module")
def light():
    return sky(EDGE, sun=1e6)


@pytest.mark.parametrize("m", [4, 5, 6, 7])
def test_walk_flat_sums_and_brute_force_agree(m, light):
    pyramid, table = EnvironmentPyramid(light), cosine_lobe(EDGE)
    for name, maps in kinds_of_maps(2**m).items():
        beta, grown = shares(len(maps)), dilations(maps)
        point = PointEstimate(pyramid, table, maps, beta, dilated=grown, eta=0.25)
        solid_angle = 4 * np.pi / EDGE**2
        mass = luminance(light) * point.b_tilde() * solid_angle
        visible = blended(maps, beta, EDGE)
        j, w2 = (mass * visible).sum(), (mass * visible**2).sum()
        expected = [(mass * blended(g, beta, EDGE)).sum() for g in grown]
        tolerance = {"rel": 1e-12, "abs": 1e-12 * mass.sum()}
        walk_j, walk_w2, nodes = point.walk()
        assert walk_j == pytest.approx(j, **tolerance), name
        assert walk_w2 == pytest.approx(w2, **tolerance), name
        assert nodes <= 4 ** (m + 1) / 3
        assert (nodes == 1) == (name in ("full", "empty", "full and empty"))
        flats = [point.flat(isa) for isa in AVAILABLE]
        assert all(flat == flats[0] for flat in flats), "the same bits from every instruction set"
        assert flats[0][0] == pytest.approx(j, **tolerance), name
        assert flats[0][1] == pytest.approx(w2, **tolerance), name
        assert flats[0][2] == pytest.approx(
            [(light[..., c] * point.b_tilde() * solid_angle * visible).sum() for c in range(3)],
            rel=1e-5,  # B̃ of the channels is grey up to rounding
        )
        np.testing.assert_allclose(flats[0][3][: len(grown)], expected, rtol=1e-12, atol=1e-300)


@pytest.mark.parametrize("m", [4, 5, 6])
@pytest.mark.parametrize("eta", [0.05, 0.25])
def test_every_node_of_the_density_is_the_sum_of_its_texels(m, eta, light):
    pyramid, table = EnvironmentPyramid(light), cosine_lobe(EDGE)
    shares_of = {2: (0.67, 0.33), 3: (0.5, 0.3, 0.2)}
    for name, maps in kinds_of_maps(2**m).items():
        beta, grown = shares(len(maps)), dilations(maps)
        point = PointEstimate(pyramid, table, maps, beta, dilated=grown, eta=eta)
        mass = luminance(light) * point.b_tilde() * (4 * np.pi / EDGE**2)
        density = np.full((EDGE, EDGE), eta)
        means = [(mass * blended(g, beta, EDGE)).sum() / mass.sum() for g in grown]
        if min(means) <= 1e-9:
            assert not point.guided, name
            density[:] = 1
        else:
            for a, g, mu in zip(shares_of[len(grown)], grown, means, strict=True):
                density += (1 - eta) * a * blended(g, beta, EDGE) / mu
        np.testing.assert_allclose(point.density(), density, rtol=1e-11)
        for level in range(m + 1):
            k = EDGE // 2**level
            q = (mass * density).reshape(2**level, k, 2**level, k).sum(axis=(1, 3))
            expected = q.ravel()[morton(level)]
            np.testing.assert_allclose(point.guided_masses(level), expected, rtol=1e-11, atol=0)


def test_moments_of_w_are_those_of_the_texels(light):
    grey = np.repeat(luminance(light)[..., None], 3, axis=-1).astype(np.float32)
    maps, found = kinds_of_maps(32)["window"], []
    beta, grown = shares(8), dilations(maps)
    for eta in (1.0, 0.25):
        point = PointEstimate(
            EnvironmentPyramid(grey), cosine_lobe(EDGE), maps, beta, dilated=grown, eta=eta
        )
        p, w = point.probabilities(), blended(maps, beta, EDGE) / point.density()
        assert point.mean_w == pytest.approx((p * w).sum(), rel=1e-6)
        variance = (p * w**2).sum() - (p * w).sum() ** 2
        assert point.variance_w == pytest.approx(variance, rel=1e-11)
        found.append(variance)
    assert abs(found[0] / found[1] - 1) > 0.1, "another density has another variance"


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"maps": np.ones((2, 24, 24), bool)}, "maps must have shape"),
        ({"beta": shares(3)}, "beta must have shape"),
        ({"beta": np.array([np.nan, 1], np.float32)}, "beta must be > 0"),
        ({"beta": np.array([0.5, 0.6], np.float32)}, "beta must have the sum 1"),
        ({"eta": 0.0}, r"eta must be in \(0, 1\]"),
        ({"eta": 0.5}, "dilated must be given"),
        ({"eta": 0.5, "dilated": [np.ones((2, 32, 32), bool)]}, "dilated must have 2 arrays"),
    ],
)
def test_bad_maps_are_refused(light, given, says):
    good = {"maps": np.ones((2, 32, 32), bool), "beta": shares(2)}
    with pytest.raises(ValueError, match=says):
        PointEstimate(EnvironmentPyramid(light), cosine_lobe(EDGE), **(good | given))
