"""sampling/hemisphere_batch.h: the SIMD form of the hemisphere's samplers."""

import numpy as np
import pytest

from core import testing
from reference.isas import AVAILABLE

WARPS = {
    True: testing.square_to_cosine_hemisphere,
    False: testing.square_to_uniform_hemisphere,
}
NORMALS = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.3, -0.5, 0.8), (-0.7, 0.1, -1e-4)]


@pytest.mark.parametrize("cosine", WARPS)
@pytest.mark.parametrize("normal", NORMALS)
def test_a_batch_holds_the_points_of_the_sequence_around_the_normal(
    normal: tuple[float, float, float], cosine: bool
) -> None:
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
def test_every_variant_gives_the_same_bits(isa: str, cosine: bool) -> None:
    for seed in range(50):
        case = (seed, ~seed & 0xFFFFFFFF, NORMALS[3], cosine)
        ours = testing.hemisphere_batch(*case, isa=isa)
        theirs = testing.hemisphere_batch(*case)
        for a, b in zip(ours, theirs, strict=True):
            assert a.tobytes() == b.tobytes()


def test_an_unknown_variant_is_refused() -> None:
    with pytest.raises(ValueError, match="isa must be portable, avx2 or avx512"):
        testing.hemisphere_batch(0, 0, (0, 0, 1), isa="sse2")
