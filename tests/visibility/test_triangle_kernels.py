"""One ray against one triangle: right hits, strict ends, no gaps between neighbours, extremes."""

import numpy as np
import pytest

from core import testing
from visibility.soup import rays

KERNELS = ["watertight", "wald"]


def hits(kernel, corners, o, d, **ends):
    """(t, u, v) of ray i against triangle i, corners (N, 3, 3)."""
    a, b, c = (np.ascontiguousarray(corners[:, i], dtype=np.float32) for i in range(3))
    return testing.triangle_hits(
        kernel, a, b, c, o.astype(np.float32), d.astype(np.float32), **ends
    )


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("axis", range(3))
def test_rays_along_an_axis_hit_triangles_across_it(kernel, axis):
    """Every dominant axis and both directions; u and v belong to vertices 1 and 2."""
    corners = np.roll(np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], float), axis, axis=-1)
    for sign in (1, -1):
        o = np.roll([[0.5, 0.25, -2.0 * sign]], axis, axis=-1)
        d = np.roll([[0, 0, float(sign)]], axis, axis=-1)
        np.testing.assert_array_equal(hits(kernel, corners, o, d), [[2, 0.5, 0.25]])


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_hit_at_t_min_does_not_count(kernel):
    corners = np.array([[[-1, -1, 2], [1, -1, 2], [0, 1, 2]]], float)
    o, d = np.zeros((1, 3)), np.array([[0.0, 0, 1]])
    below, above = np.nextafter(np.float32(2), [0, 3], dtype=np.float32)
    assert np.isnan(hits(kernel, corners, o, d, t_min=2.0)).all()
    assert np.isfinite(hits(kernel, corners, o, d, t_min=float(below))).all()
    assert np.isfinite(hits(kernel, corners, o, d, t_max=2.0)).all()
    assert np.isnan(hits(kernel, corners, o, d, t_max=float(below))).all()
    assert np.isnan(hits(kernel, corners, o, d, t_min=float(above))).all()


def fan(n, seed):
    """Closed fans of six triangles round a vertex (n, 6, 3, 3), and their rims (n, 6, 3)."""
    r = np.random.default_rng(seed)
    centre = r.normal(size=(n, 1, 3))
    angle = np.sort(r.uniform(0, 2 * np.pi, (n, 6)), axis=1)
    angle = np.arange(6) * (np.pi / 3) + 0.4 * (angle - angle.mean(axis=1, keepdims=True)) / 7
    ring = np.stack([np.cos(angle), np.sin(angle), 0.3 * r.normal(size=(n, 6))], axis=-1)
    ring = (centre + ring).astype(np.float32)
    centre = np.broadcast_to(centre.astype(np.float32), ring.shape)
    corners = np.stack([centre, ring, np.roll(ring, -1, axis=1)], axis=2)
    return corners, ring


def holes(kernel, n=20_000):
    """Rays to points on the spokes of fans, the hub included, that no triangle of the fan stops."""
    corners, ring = fan(n, 3)
    r = np.random.default_rng(4)
    w = np.where(r.random((n, 1)) < 0.25, 0, r.uniform(0, 0.9, (n, 1)))
    target = corners[:, 0, 0] + w * (ring[:, 2] - corners[:, 0, 0])
    o = (target + r.normal((0, 0, 5), 0.3, (n, 3))).astype(np.float32)
    d = (target - o).astype(np.float32)
    stopped = np.zeros(n, bool)
    for k in range(6):
        stopped |= np.isfinite(hits(kernel, corners[:, k], o, d)[:, 0])
    return int((~stopped).sum())


def test_no_ray_passes_between_triangles_that_share_an_edge():
    assert holes("watertight") == 0
    # The control: the same rays find the gaps of the paper's kernel
    assert holes("wald") > 0


@pytest.mark.extreme
@pytest.mark.parametrize("kernel", KERNELS)
def test_what_cannot_be_hit_is_missed(kernel):
    """No area, no direction, not a number: a miss each, and nothing but a miss."""
    corners, (o, d) = np.random.default_rng(0).normal(size=(6, 3, 3)), rays(6)
    corners[0] = corners[0, :1]
    corners[1, 2] = corners[1, 1]
    d[2] = 0
    d[3] = np.nan
    o[4] = np.nan
    corners[5] = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    o[5], d[5] = [-1, 0.25, 0], [1, 0, 0]  # edge-on
    assert np.isnan(hits(kernel, corners, o, d)).all()


@pytest.mark.extreme
def test_the_watertight_kernel_reaches_the_largest_and_smallest_triangles():
    """Products of these corners leave single precision; double takes over."""
    for size in (1e-20, 1e16):
        corners = np.array([[[-1, -1, 2], [1, -1, 2], [0, 1, 2]]]) * size
        o, d = np.zeros((1, 3)), np.array([[0.0, 0, 1]])
        t, u, v = hits("watertight", corners, o, d)[0]
        np.testing.assert_allclose([t / size, u, v], [2, 0.25, 0.5], rtol=1e-6)
