"""vismap/product_tree.h: directions in proportion to light × reflection."""

import numpy as np
import pytest

from core import testing
from sampling.chi_square import p_value
from viscache._core import PointSet
from viscache._core.sampling import eval_bsdf
from viscache._core.vismap import EnvironmentPyramid, points
from vismap.worlds import coarser, directions, luminance, morton, sky, surface

SURFACES = {
    "diffuse": surface(),
    "glossy": surface(glossy=True),
    "sharp": surface(glossy=True, roughness=0.02),
    "along an axis": surface((0, 0, 1), glossy=True),
    "below the horizon": surface((0.1, 0.2, -1)),
}


@pytest.mark.parametrize("edge", [1, 16, 128, 512])
def test_sums_of_the_environment_are_those_of_numpy(edge):
    pixels = sky(edge, sun=1e6) if edge > 8 else np.full((1, 1, 3), 0.7, np.float32)
    pyramid = EnvironmentPyramid(pixels)
    assert pyramid.levels == max(7, int(np.log2(edge)))
    size = 2**pyramid.levels
    fine = luminance(np.kron(pixels, np.ones((size // edge, size // edge, 1), np.float32)))
    fine *= 4 * np.pi / size**2
    for level in (0, 3, 5, pyramid.levels):
        expected = coarser(fine, 2**level).ravel()[morton(level)]
        np.testing.assert_allclose(pyramid.sums(level), expected, rtol=1e-12)


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("map_level", [4, 5, 6, 7])
def test_probabilities_sum_to_one_at_every_level(name, map_level):
    tree = testing.ProductTree.of_surface(
        EnvironmentPyramid(sky(256, sun=1e6)), SURFACES[name], map_level
    )
    masses = tree.texel_masses()
    assert masses.sum() == pytest.approx(tree.total, rel=1e-12)
    for level in range(tree.dense_level + 1):
        expected = coarser(masses, 2**level).ravel()[morton(level)]
        np.testing.assert_allclose(tree.masses(level), expected, rtol=1e-12)


def test_split_leaves_can_be_drawn():
    """A bright patch and a bright horizon split leaves whose samples of a lobe miss its edge."""
    light = sky(512)
    light[200:206, 300:310] = 3e3
    light[254:258] = 300
    pyramid, fine = EnvironmentPyramid(light), directions(1024)
    rng, below = np.random.default_rng(5), 0
    for _ in range(12):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        point = surface(tuple(normal), glossy=True, roughness=float(rng.uniform(0.02, 0.3)))
        tree = testing.ProductTree.of_surface(pyramid, point)
        cosine = np.maximum(fine @ normal, 0)
        b = luminance(eval_bsdf(point, fine.reshape(-1, 3))).reshape(cosine.shape) * cosine
        brings = (coarser(b, 512) > 0) & (luminance(light) > 0)
        assert (tree.texel_masses()[brings] > 0).all()
        b_tilde = luminance(tree.b_tilde())[brings]
        below += int((b_tilde < 1.1e-3 * b_tilde.max()).sum())
    assert below > 100  # at the floor


def surface_normal(name):
    normal = {"along an axis": (0, 0, 1), "below the horizon": (0.1, 0.2, -1)}.get(
        name, (0.3, -0.5, 0.81)
    )
    return tuple(np.asarray(normal) / np.linalg.norm(normal))


@pytest.mark.parametrize("level", [6, 7, 8])
@pytest.mark.parametrize("name", SURFACES)
def test_reflection_sixteen_at_a_time_is_that_of_the_scene(name, level):
    for first in range(0, 4**level, 16 * 4 ** (level - 4) // 5 // 16 * 16 or 16):
        d, b = testing.reflection_at_nodes(SURFACES[name], level, first)
        cosine = np.maximum(d @ np.asarray(surface_normal(name)), 0)
        expected = eval_bsdf(SURFACES[name], d) * cosine[:, None]
        np.testing.assert_allclose(b, expected, rtol=2e-3, atol=1e-5)


@pytest.mark.parametrize("sun", [0.0, 1e4, 1e6])
def test_samples_are_as_frequent_as_their_masses(sun):
    tree = testing.ProductTree.of_surface(EnvironmentPyramid(sky(128, sun=sun)), SURFACES["glossy"])
    n = 400_000
    texel, wi = tree.sample(points(PointSet.INDEPENDENT, n))
    counts = np.bincount(texel, minlength=128 * 128)
    masses = tree.texel_masses().ravel()
    assert not counts[masses == 0].any()
    expected = n * masses / tree.total
    assert p_value(counts, expected) > 1e-4
    assert p_value(counts, np.roll(expected, 1)) < 1e-9, "masses in the wrong place must show"
    cell = np.asarray(directions(128).reshape(-1, 3)[texel])
    assert (wi * cell).sum(1).min() > np.cos(0.06), "a direction lies in its texel"


def test_the_warp_keeps_strata():
    """16 points of a (0, 2)-sequence fall into the four equal parts of the sphere evenly."""
    light = np.ones((128, 128, 3), np.float32)
    tree = testing.ProductTree.of_table(
        EnvironmentPyramid(light), np.ones((128, 128, 3), np.float32)
    )
    texel, _ = tree.sample(points(PointSet.ZERO_TWO, 16, seed=5))
    cells = (texel // 128 // 32) * 4 + texel % 128 // 32
    assert sorted(cells) == list(range(16))


def test_points_fill_their_strata():
    for pixel in range(20):
        u = points(PointSet.ZERO_TWO, 64, seed=3, pixel=pixel)
        for rows in (1, 2, 4, 8, 16, 32, 64):
            cell = (u[:, 0] * 64 // rows) * rows + u[:, 1] * rows // 1
            assert len(np.unique(cell)) == 64
    u = points(PointSet.INDEPENDENT, 20_000, seed=3)
    assert abs(np.corrcoef(u.T)[0, 1]) < 0.03 and abs(u.mean() - 0.5) < 0.01
    again = points(PointSet.ZERO_TWO, 64, seed=3, pass_=1)
    assert not np.array_equal(again, points(PointSet.ZERO_TWO, 64, seed=3, pass_=2))


def test_nothing_is_drawn_in_the_dark():
    black = EnvironmentPyramid(np.zeros((128, 128, 3), np.float32))
    tree = testing.ProductTree.of_surface(black, SURFACES["diffuse"])
    assert tree.total == 0
    with pytest.raises(ValueError, match="total must be > 0"):
        tree.sample(np.zeros((1, 2)))
    light = EnvironmentPyramid(sky())
    assert testing.ProductTree.of_table(light, np.zeros((128, 128, 3), np.float32)).total == 0


def test_bad_input_is_refused():
    bad, light = np.stack([sky()] * 3), EnvironmentPyramid(sky())
    bad[[0, 1, 2], 3, 4, 1] = np.nan, np.inf, -1.0
    tree = testing.ProductTree.of_surface(light, SURFACES["diffuse"])
    for call, says in (
        (lambda: EnvironmentPyramid(np.ones((100, 100, 3), np.float32)), "power of two"),
        *((lambda p=p: EnvironmentPyramid(p), "finite and >= 0") for p in bad),
        (lambda: testing.ProductTree.of_surface(light, SURFACES["glossy"], 3), "map_level must be"),
        (lambda: tree.sample(np.array([[0.5, 1.0]])), r"u must be in \[0, 1\)"),
    ):
        with pytest.raises(ValueError, match=says):
            call()
