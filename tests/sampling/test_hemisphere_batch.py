"""sampling/hemisphere_batch.h and sphere_batch.h: directions by the batch."""

import numpy as np
import pytest
from scipy import stats

from core import testing
from reference.isas import AVAILABLE

WARPS = {True: testing.square_to_cosine_hemisphere, False: testing.square_to_uniform_hemisphere}
NORMALS = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.3, -0.5, 0.8), (-0.7, 0.1, -1e-4)]


@pytest.mark.parametrize("cosine", WARPS)
@pytest.mark.parametrize("normal", NORMALS)
def test_a_batch_holds_the_points_of_the_sequence_around_the_normal(normal, cosine):
    directions, cosines = testing.hemisphere_batch(7, 11, normal, cosine=cosine)
    points = testing.sobol02(np.arange(32, dtype=np.uint32), 7, 11)
    local = WARPS[cosine](points)
    n = np.array(normal) / np.linalg.norm(normal)
    assert cosines == pytest.approx(local[:, 2], abs=1e-7)
    assert directions @ n == pytest.approx(cosines, abs=3e-7)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(1, abs=1e-6)
    # The frame is a rotation: angles between the samples are those of the local ones
    assert directions @ directions.T == pytest.approx(local @ local.T, abs=1e-6)


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("cosine", WARPS)
def test_every_variant_gives_the_same_bits(isa, cosine):
    for seed in range(50):
        case = (seed, ~seed & 0xFFFFFFFF, NORMALS[3], cosine)
        ours = testing.hemisphere_batch(*case, isa=isa)
        theirs = testing.hemisphere_batch(*case)
        for a, b in zip(ours, theirs, strict=True):
            assert a.tobytes() == b.tobytes()


def test_an_unknown_variant_is_refused():
    with pytest.raises(ValueError, match="isa must be portable, avx2 or avx512"):
        testing.hemisphere_batch(0, 0, (0, 0, 1), isa="sse2")


def test_directions_are_even_over_the_sphere():
    """Equal bands of z and equal sectors, each drawn as often: scrambles differ, so do samples."""
    rng = np.random.default_rng(8)
    w = np.concatenate(
        [testing.sphere_batch(*map(int, rng.integers(2**32, size=2)), n=4) for _ in range(20000)]
    )
    np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-6)
    band = np.minimum(7, ((w[:, 2] + 1) * 4).astype(int))
    sector = np.minimum(15, ((np.arctan2(w[:, 1], w[:, 0]) / np.pi + 1) * 8).astype(int))
    # Four points of one sequence are stratified: take one of each for the test
    one = (band * 16 + sector).reshape(-1, 4)[:, 1]
    assert stats.chisquare(np.bincount(one, minlength=128)).pvalue > 1e-3
    # Control: half a per cent more of one band is found
    assert np.bincount(band, minlength=8) == pytest.approx(np.full(8, len(w) / 8), rel=0.02)
    skewed = np.where(rng.random(len(one)) < 0.03, one % 16, one)
    assert stats.chisquare(np.bincount(skewed, minlength=128)).pvalue < 1e-3


def test_points_of_one_sequence_are_stratified():
    """Of 2^k points each half of the sphere and each of 16 bands gets its share."""
    for n in (16, 64, 256):
        z = testing.sphere_batch(12345, 678, n=n)[:, 2]
        assert (z > 0).sum() == n // 2
    whole = testing.sphere_batch(5, 6, n=64)
    np.testing.assert_array_equal(testing.sphere_batch(5, 6, first=32, n=32), whole[32:])


@pytest.mark.parametrize("isa", AVAILABLE)
def test_every_instruction_set_draws_the_same_bits(isa):
    """The portable code's."""
    want = testing.sphere_batch(99, 2**31 + 7, n=333, isa="portable")
    np.testing.assert_array_equal(testing.sphere_batch(99, 2**31 + 7, n=333, isa=isa), want)
