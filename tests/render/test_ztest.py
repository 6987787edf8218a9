"""The comparison that the statistical tests stand on: its size and its power."""

import numpy as np
import pytest

from render.ztest import ALPHA, compare

SHAPE = (24, 32, 3)


def images(seeds, start, *, noise=0.05):
    """Seeds of a picture with skewed noise that grows with its value."""
    rows, columns = np.indices(SHAPE[:2])
    picture = 0.2 + (rows + 2 * columns)[..., None] / 50 * np.ones(3)
    rng = np.random.default_rng(start)
    return picture * (1 + noise * (rng.gamma(4.0, 1.0, (seeds, *SHAPE)) - 4) / 2)


@pytest.mark.stat
def test_equal_expectations_pass_as_often_as_they_should():
    p = [compare(images(8, 2 * i), images(12, 2 * i + 1)).p for i in range(200)]
    # Uniform p: below 0.05 in about 10 of 200; heavy tails of the noise may add a few
    assert np.sum(np.array(p) < 0.05) <= 25
    assert np.sum(np.array(p) < ALPHA) <= 2


@pytest.mark.stat
@pytest.mark.parametrize(
    "spoil",
    [
        pytest.param(lambda a: a * 0.99, id="1 % less energy"),
        pytest.param(lambda a: a[:, ::-1], id="upside down"),
        pytest.param(lambda a: a[:, :, ::-1], id="mirrored"),
        pytest.param(lambda a: a[..., ::-1] * [1, 1, 1.01], id="one channel 1 % up"),
        pytest.param(
            lambda a: np.where(np.indices(SHAPE[:2]).sum(0)[..., None] == 9, 0.5 * a, a),
            id="a few pixels",
        ),
    ],
)
def test_a_wrong_image_fails(spoil):  # type: ignore[no-untyped-def]
    good = images(8, 100)
    assert compare(good, images(8, 101)).same
    assert not compare(spoil(good), images(8, 101)).same


def test_images_without_noise_are_compared_up_to_rounding():
    exact = np.repeat(images(1, 5, noise=0), 4, axis=0)
    assert compare(exact.astype(np.float32), exact).same
    assert not compare(exact * 1.001, exact).same


def test_images_that_are_not_finite_are_refused():
    broken = images(4, 7)
    broken[1, 2, 3, 0] = np.nan
    with pytest.raises(AssertionError):
        compare(broken, images(4, 8))
