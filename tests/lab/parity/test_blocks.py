"""Statistics of blocks: how often equal pictures differ, and which differences are found."""

import numpy as np
import numpy.typing as npt
import pytest

from viscache_lab.parity.blocks import block_means, compare

Array = npt.NDArray[np.float64]
ROWS = COLUMNS = 8


def stack(rng, n, level, noise):
    """n pictures of blocks with the relative noise of block means."""
    return np.asarray(level) * (1 + noise * rng.standard_normal((n, ROWS, COLUMNS, 3)))


def scene(rng):
    """Levels of blocks over two decades."""
    return 10 ** rng.uniform(-1, 1, (ROWS, COLUMNS, 3))


def test_means_of_blocks_leave_out_what_does_not_fill_one():
    picture = np.arange(5 * 7 * 3, dtype=np.float32).reshape(5, 7, 3)
    means = block_means(picture, 2)
    assert means.shape == (2, 3, 3)
    np.testing.assert_allclose(means[1, 2], picture[2:4, 4:6].mean((0, 1)))


@pytest.mark.stat
@pytest.mark.parametrize("noise", [0.01, 0.1])
@pytest.mark.parametrize("n", [6, 12, 48])
def test_equal_expectations_agree(n, noise):
    rng = np.random.default_rng(3)
    alarms = 0
    for _ in range(200):
        level = scene(rng)
        alarms += not compare(stack(rng, n, level, noise), stack(rng, n, level, noise)).agrees
    # More samples are asked for where it is near, so the first look may be wrong now and then
    assert alarms <= (6 if n == 6 else 1)


@pytest.mark.stat
@pytest.mark.parametrize("noise", [0.01, 0.05])
def test_the_stated_power_is_that_of_a_block(noise):
    rng = np.random.default_rng(5)
    level = np.ones((ROWS, COLUMNS, 3))
    power = compare(stack(rng, 48, level, noise), stack(rng, 48, level, noise)).power

    def missed(d):
        return 1 - compare(stack(rng, 48, level * d, noise), stack(rng, 48, level, noise)).share

    found, less = (np.mean([missed(1 + d) for _ in range(20)]) for d in (power, power / 2))
    assert found == pytest.approx(0.95, abs=0.03)
    assert less < 0.7


@pytest.mark.stat
def test_five_per_cent_more_light_is_found():
    rng = np.random.default_rng(7)
    level = scene(rng)
    ours, theirs = stack(rng, 12, level, 0.02), stack(rng, 12, level, 0.02)
    assert compare(ours, theirs).agrees
    brighter = compare(1.05 * ours, theirs)
    assert not brighter.agrees
    assert brighter.energy_difference == pytest.approx(0.05, abs=0.01)
    assert not compare(0.95 * ours, theirs).agrees


@pytest.mark.stat
def test_a_difference_in_few_blocks_counts_by_its_energy():
    rng = np.random.default_rng(9)
    level = np.ones((ROWS, COLUMNS, 3))
    ours, theirs = stack(rng, 24, level, 0.01), stack(rng, 24, level, 0.01)
    ours[:, 0, :2] *= 2  # 2 of 64 blocks
    found = compare(ours, theirs)
    assert found.share >= 0.95
    assert not found.energies_agree
    assert not found.agrees
    assert found.worst_z > 50


def test_black_pictures_agree_and_light_in_the_dark_does_not():
    black = np.zeros((4, ROWS, COLUMNS, 3))
    assert compare(black, black).agrees
    assert not compare(black + 1e-3, black).agrees
    assert not compare(black, black + 1e-3).agrees


def test_blocks_that_are_not_finite_do_not_agree():
    a = np.ones((4, ROWS, COLUMNS, 3))
    b = a.copy()
    b[2, 1, 1, 0] = np.nan
    assert not compare(b, a).agrees
    b[2, 1, 1, 0] = np.inf
    assert not compare(b, a).agrees


def test_stacks_of_other_sizes_are_refused():
    a = np.ones((4, ROWS, COLUMNS, 3))
    with pytest.raises(ValueError, match="stacks must have shape"):
        compare(a[:, 1:], a)
    with pytest.raises(ValueError, match="stacks must have shape"):
        compare(a[:1], a)
