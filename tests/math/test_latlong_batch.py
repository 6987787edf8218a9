"""scene/latlong_batch.h: places in a lat-long image, along rows of the equal-area map."""

import numpy as np
import pytest

from core import testing
from reference.isas import AVAILABLE

N = 1000


def turned():
    q, _ = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))
    return 7 * q * np.sign(np.linalg.det(q))


def exact(to_world, y):
    """The same in double: equal-area map (Clarberg 2008), turned back, then as in description.h."""
    a, b = 2 * (np.arange(N) + 0.5) / N - 1, 2 * y - 1
    distance = 1 - abs(a) - abs(b)
    r = 1 - abs(distance)
    phi = np.where(r > 0, (abs(b) - abs(a)) / np.where(r > 0, r, 1) + 1, 1) * np.pi / 4
    side = r * np.sqrt(2 - r * r)
    z = np.copysign(1 - r * r, distance)
    d = np.stack([np.copysign(np.cos(phi) * side, a), np.copysign(np.sin(phi) * side, b), z], 1)
    d = d @ to_world
    u = np.arctan2(d[:, 0], -d[:, 2]) / (2 * np.pi) % 1
    return np.stack([u, np.arctan2(np.hypot(d[:, 0], d[:, 2]), d[:, 1]) / np.pi])


@pytest.mark.parametrize("to_world", [np.eye(3), turned()], ids=["still", "turned"])
def test_places_are_those_of_exact_arithmetic(to_world):
    """Far below a pixel of the largest image, 16384 wide; near the poles columns matter less."""
    worst = 0.0
    for y in (0.0005, 0.1, 0.37, 0.5 + 1e-3, 0.77, 0.9995):
        u, v = testing.latlong_batch(to_world, y=y, first=0.5, step=1 / N, n=N)
        u_exact, v_exact = exact(to_world, float(np.float32(y)))
        around = np.abs((u - u_exact + 0.5) % 1 - 0.5) * np.sin(np.pi * v_exact)
        worst = max(worst, float(around.max()), float(np.abs(v - v_exact).max()))
        assert (u >= 0).all() and (u <= 1).all() and (v >= 0).all() and (v <= 1).all()
    assert worst < 1e-6


def test_poles_and_the_seam_are_places():
    """Straight up is row 0, straight down row 1, and nothing is NaN."""
    y_up = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # the map's z axis shows up in the image
    up = testing.latlong_batch(y_up, y=0.5, first=0.5, step=1, n=1)
    corner = testing.latlong_batch(y_up, y=0, first=0, step=1, n=2)
    assert {round(float(v), 5) for v in (up[1, 0], *corner[1])} == {0.0, 1.0}
    assert np.isfinite(up).all() and np.isfinite(corner).all()


def places(width, height):
    """Anywhere in the image, and on and beside its borders and centres of pixels."""
    rng = np.random.default_rng(3)
    u, v = rng.random((2, 400)).astype(np.float32)
    edges = np.array([0, 0.25, 0.5, 0.75, 1, width - 0.5, width - 0.25, width], np.float32)
    u[: len(edges)] = edges / max(width, 1)
    v[10 : 10 + len(edges)] = np.minimum(edges / height, 1)
    return u.clip(0, 1), v


@pytest.mark.parametrize("width, height", [(1, 1), (2, 1), (3, 2), (1024, 512), (16384, 8192)])
def test_look_ups_are_bilinear_around_the_sphere(width, height):
    """Columns wrap around, rows end at the poles, and the shares are those of the place."""
    u, v = places(width, height)
    pixels, shares = testing.bilinear_places(u, v, width=width, height=height)
    x, y = u * np.float32(width) - np.float32(0.5), v * np.float32(height) - np.float32(0.5)
    left, up = np.floor(x).astype(int), np.floor(y).astype(int)
    rows = np.clip([up, up + 1], 0, height - 1)
    columns = np.array([left, left + 1]) % width
    want = [rows[j] * width + columns[i] for j in range(2) for i in range(2)]
    # A float beside a boundary may be rounded across it: then its share of the far pixel is 1
    same = (shares >= 0).all(0) & (shares < 1).all(0)
    assert same.mean() > 0.99
    assert (shares >= 0).all() and (shares <= 1).all()
    np.testing.assert_array_equal(pixels[:, same], np.array(want)[:, same])
    np.testing.assert_array_equal(
        shares[:, same], np.array([x - left, y - up], np.float32)[:, same]
    )


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("n", [1, 15, 16, 33, 400])
def test_every_instruction_set_gives_the_same_bits(isa, n):
    """The portable code's, at tails of all lengths too."""
    u, v = (values[:n] for values in places(1000, 500))
    row = {"y": 0.3, "first": 7.5, "step": 1 / 1024, "n": n}
    want, got = (
        (
            *testing.latlong_batch(turned(), **row, isa=i),
            *testing.bilinear_places(u, v, width=1000, height=500, isa=i),
        )
        for i in ("portable", isa)
    )
    for a, b in zip(got, want, strict=True):
        np.testing.assert_array_equal(a, b)
