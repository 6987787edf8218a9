"""render/glossy_sums.h: glossy reflection of shared lights under a mask of bits."""

import numpy as np
import pytest

from core import testing
from reference.isas import AVAILABLE
from scene.test_bsdf import glossy
from viscache._core.sampling import eval_bsdf

POINT, DIRECTION, SURFACE = 0, 1, 2
SP = glossy(0.7, 0.3, base=(0.3, 0.2, 0.1), specular=(0.5, 0.3, 0.1))
AT = np.float32([0.5, -0.25, 0.125])


def lights(semantic, n, seed=1):
    """Far ends, normals and values; some below the horizon or turned away."""
    rng = np.random.default_rng(seed)
    far = rng.normal(size=(n, 3)) + np.array([0, 0, 0.7])
    if semantic == DIRECTION:
        far /= np.linalg.norm(far, axis=1, keepdims=True)
    else:
        far += AT
    normal = -(far - AT) + rng.normal(size=(n, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return far.astype(np.float32), normal.astype(np.float32), rng.uniform(0, 2, (n, 3)).astype("f4")


def expected(semantic, far, normal, value, bound2, seen):
    """One light after another, in double."""
    total = np.zeros(3)
    for y, m, v in zip(far[seen].astype(float), normal[seen], value[seen], strict=True):
        d = y if semantic == DIRECTION else y - AT
        d2 = d @ d
        wi = d / np.sqrt(d2)
        g = max(0.0, wi[2])
        if semantic != DIRECTION:
            g *= max(0.0, -(wi @ m)) / (d2 + bound2) if semantic == SURFACE else 1 / d2
        total += eval_bsdf(SP, wi[None].astype(np.float32))[0] * v * g
    return total


@pytest.mark.parametrize("semantic", [POINT, DIRECTION, SURFACE])
@pytest.mark.parametrize("n", [1, 17, 700])
def test_sums_are_those_of_single_lights(semantic, n):
    """f·g·value over the seen columns alone; another mask gives another sum."""
    far, normal, value = lights(semantic, n)
    seen = np.random.default_rng(n).random(n) < 0.6
    seen[0] = True
    given = {"semantic": semantic, "far": far, "normal": normal, "value": value, "bound2": 0.1}
    got = testing.glossy_sum(SP, AT, seen=seen.tolist(), **given)
    want = expected(semantic, far, normal, value, 0.1, seen)
    np.testing.assert_allclose(got, want, rtol=1e-4, atol=1e-7)
    assert testing.glossy_sum(SP, AT, seen=[False] * n, **given) == (0, 0, 0)
    if n > 1:
        assert testing.glossy_sum(SP, AT, seen=[True] * n, **given) != got


@pytest.mark.parametrize("semantic", [POINT, DIRECTION, SURFACE])
@pytest.mark.parametrize("isa", AVAILABLE)
def test_every_instruction_set_sums_to_the_same_bits(semantic, isa):
    """The portable code's; a light at the eye point that is not seen does no harm."""
    far, normal, value = lights(semantic, 300)
    far[7] = AT
    seen = [k != 7 and k % 3 > 0 for k in range(300)]
    given = {"semantic": semantic, "far": far, "normal": normal, "value": value, "bound2": 0.1}
    sums = [testing.glossy_sum(SP, AT, seen=seen, isa=i, **given) for i in (isa, "portable")]
    assert sums[0] == sums[1] and np.isfinite(sums[0]).all() and min(sums[0]) > 0
