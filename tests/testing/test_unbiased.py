"""`assert_unbiased`: its size, its power, and what it says of both."""

import re

import numpy as np
import pytest

import viscache as vc
from viscache.testing import PictureError, assert_unbiased, student

SHAPE = (32, 96, 3)


def picture():
    rows, columns = np.indices(SHAPE[:2])
    return 0.2 + (rows + 2 * columns)[..., None] / 50 * np.array([1.0, 0.9, 0.7])


def gamma(rng, n):
    """Skewed noise."""
    return picture() * (1 + 0.05 * (rng.gamma(4.0, 1.0, (n, *SHAPE)) - 4) / 2)


def corrected(rng, n):
    """Heavy tails: one pixel in 500 has a correction, of 50 times what is missing everywhere."""
    drawn = rng.random((n, *SHAPE[:2], 1)) < 0.002
    return picture() * (0.9 + 0.1 * drawn / 0.002)


def outcome(frames, exact, **options):
    """ "passes", "biased" or "weak"."""
    try:
        assert_unbiased(frames, exact, energy=0.9, **options)
    except PictureError as error:
        return "biased" if str(error).startswith("the frames are biased") else "weak"
    return "passes"


@pytest.mark.stat
@pytest.mark.parametrize("noise", [gamma, corrected])
@pytest.mark.parametrize("paired", [True, False])
def test_equal_expectations_pass_as_often_as_they_should(noise, paired):
    found = []
    for i in range(80):
        rng = np.random.default_rng(i)
        exact = gamma(rng, 12)
        frames = exact - picture() + noise(rng, 12) if paired else noise(rng, 12)
        found.append(outcome(frames, exact, alpha=0.05, paired=paired))
    # 4 of 80 expected; 12 or more have a probability of 0.1 %
    assert found.count("biased") <= 11 and "weak" not in found


@pytest.mark.stat
@pytest.mark.parametrize("noise", [gamma, corrected])
def test_a_bias_of_the_promised_size_is_found_as_often_as_promised(noise):
    """By the energy or by a block; one of a quarter of the size is mostly not."""
    base = assert_unbiased(noise(np.random.default_rng(1), 400), picture(), energy=0.9, alpha=0.01)
    # Of 16 frames: their noise is that of 400, and the quantiles of t are their own
    error = base.energy / base.t if base.t else 0.0
    size = student.detectable(abs(error) * np.sqrt(400 / 16), 15.0, 0.005, 0.9)
    found = {}
    for share in (1.0, 0.25):
        results = []
        for i in range(40):
            frames = noise(np.random.default_rng(1000 + i), 16) * (1 + share * size)
            results.append(outcome(frames, picture(), alpha=0.01, power=0.9))
        found[share] = results.count("biased")
    assert found[1.0] >= 30  # 36 expected
    assert found[0.25] < 13


def moved():
    """2 % more in the first block, and the same energy in all."""
    first, rest = picture()[:, :32].sum(), picture()[:, 32:].sum()
    return [(32, 1.02), (64, 1 - 0.02 * first / rest)]


@pytest.mark.parametrize(
    ("spoil", "where"),
    [
        pytest.param(lambda a: a * 0.99, "their energy", id="1 % less energy"),
        pytest.param(
            lambda a: a * np.concatenate([np.full((1, n, 1), f) for n, f in moved()], axis=1),
            "a block",
            id="light moved to other blocks",
        ),
        pytest.param(lambda a: a * np.array([1.02, 0.976, 1.0]), "a block", id="a channel"),
    ],
)
def test_a_bias_fails_and_is_named(spoil, where):
    good, exact = (gamma(np.random.default_rng(s), 12) for s in (0, 1))
    assert_unbiased(good, exact)
    with pytest.raises(PictureError, match=f"the frames are biased in {where}"):
        assert_unbiased(spoil(good), exact)


def test_too_little_power_fails_and_says_how_many_frames_it_takes():
    rng = np.random.default_rng(3)

    def stack(n):
        return picture() * (1 + 0.02 * rng.standard_normal((n, 1, 1, 1)))

    with pytest.raises(PictureError, match="the test is too weak") as caught:
        assert_unbiased(stack(6), picture(), energy=0.01)
    text = str(caught.value)
    need = int(re.search(r"about (\d+) frames", text)[1])
    assert 60 < need < 500
    enough = assert_unbiased(stack(2 * need), picture(), energy=0.01)
    assert enough.detectable <= 0.01
    # A bias that is seen anyway is a bias, whatever the power
    with pytest.raises(PictureError, match="biased"):
        assert_unbiased(1.5 * stack(6), picture(), energy=0.01)


def test_noise_of_equal_seeds_cancels():
    scene, size = vc.scenes.build("room?triangles=3000"), (48, 32)
    light = vc.Whitted(n_vpls=64)
    options = {"visibility": vc.Aqvc(c_e=16), "use": vc.Correct(share=0.5)}

    def exact(first):
        return [vc.render(scene, light, size=size, seed=first + i) for i in range(10)]

    frames = [vc.render(scene, light, size=size, seed=i, **options) for i in range(10)]
    of_these_seeds = exact(0)
    same = assert_unbiased(frames, of_these_seeds, energy=0.2)
    other = assert_unbiased(frames, exact(100), energy=0.9)
    assert same.paired and not other.paired
    assert same.detectable < 0.5 * other.detectable
    arrays = assert_unbiased([f.image for f in frames], of_these_seeds, energy=0.9)
    assert not arrays.paired
    assert f"{same.detectable:.2%}" in str(same) and "10 frames find" in str(same)
    replaced = [
        vc.render(scene, light, size=size, seed=i, visibility=vc.Unoccluded()) for i in range(10)
    ]
    with pytest.raises(PictureError, match="biased") as caught:
        assert_unbiased(replaced, of_these_seeds)
    assert 'use="correct" is not' in str(caught.value)
    assert isinstance(caught.value.picture, np.ndarray)  # the means
    means = np.mean([f.image for f in replaced], axis=0)
    np.testing.assert_allclose(caught.value.picture, means, rtol=1e-5)


def test_one_exact_picture_is_one_without_noise():
    frames = gamma(np.random.default_rng(4), 16)
    for exact in (picture(), [picture()], vc.Frame(layers={"color": picture()})):
        assert assert_unbiased(frames, exact).frames == 16
    with pytest.raises(PictureError, match="biased"):
        assert_unbiased(frames, 1.01 * picture())


def test_grey_pictures_and_alpha_are_taken():
    rng = np.random.default_rng(5)
    grey = [0.5 + 0.01 * rng.standard_normal((40, 40)) for _ in range(8)]
    assert assert_unbiased(grey, np.full((40, 40), 0.5)).blocks == 1
    frames = gamma(rng, 8)
    with_alpha = np.concatenate([frames, 7 * np.ones((*frames.shape[:3], 1))], axis=3)
    assert assert_unbiased(with_alpha, picture()).energy == pytest.approx(
        assert_unbiased(frames, picture()).energy
    )


def test_frames_that_are_not_independent_are_refused():
    frames = list(gamma(np.random.default_rng(6), 4))
    with pytest.raises(ValueError, match="the same picture as numbers 1 and 3"):
        assert_unbiased([*frames[:3], frames[1]], picture())
    with pytest.raises(ValueError, match="at least 2, got 1"):
        assert_unbiased(frames[:1], picture())
    with pytest.raises(ValueError, match="must not be black"):
        assert_unbiased(frames, 0 * picture())
    with pytest.raises(ValueError, match="pairs must be as many"):
        assert_unbiased(frames, frames[:3], paired=True)
    for name, bad in (("energy", 0), ("alpha", 0.7), ("power", 0.2)):
        with pytest.raises(ValueError, match=f"{name} must be in"):
            assert_unbiased(frames, picture(), **{name: bad})


def test_broken_pictures_fail():
    frames = gamma(np.random.default_rng(7), 4)
    with pytest.raises(PictureError, match="must have one size"):
        assert_unbiased(frames[:, :20], picture())
    with pytest.raises(PictureError, match="pictures of one size"):
        assert_unbiased([frames[0], frames[1][:20]], picture())
    with pytest.raises(ValueError, match="frames must be real numbers, got dtype complex128"):
        assert_unbiased(frames * 1j, picture())
    frames[2, 0, 0, 0] = np.inf
    with pytest.raises(PictureError, match="pixels that are not in number 2"):
        assert_unbiased(frames, picture())


@pytest.mark.parametrize("freedom", [1, 3, 15, 60])
def test_the_power_is_that_of_simulated_tests(freedom):
    from scipy.stats import t

    n, alpha = freedom + 1, 0.01
    size = student.detectable(1 / np.sqrt(n), freedom, alpha, 0.9)
    drawn = np.random.default_rng(8).normal(size, 1, (20_000, n))
    values = drawn.mean(axis=1) / (drawn.std(axis=1, ddof=1) / np.sqrt(n))
    found = np.abs(values) > t.isf(alpha / 2, freedom)
    assert found.mean() == pytest.approx(0.9, abs=0.01)
    assert student.detectable(1, 1e9, alpha, 0.9) == pytest.approx(2.5758 + 1.2816, rel=1e-3)


def test_blocks_are_even_and_cover_the_picture():
    image = np.random.default_rng(9).random((1, 70, 33, 1))
    found = student.blocks(image, 32)
    assert found.shape == (1, 2, 1, 1)
    np.testing.assert_allclose(found[0, :, 0, 0], [image[0, :35].mean(), image[0, 35:].mean()])
