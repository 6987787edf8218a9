"""The map of voxel-to-voxel visibilities, against NumPy."""

import numpy as np
import pytest

import viscache as vc
from core import testing
from reference import nee_plus_plus as reference

LOW, HIGH = (-1.0, 0.0, 2.0), (3.0, 0.5, 4.0)


def learn(near, far, seen, *, direction=False, box=(LOW, HIGH), **given):
    """Cells of both ends, visibility and probability."""
    ends, answers = (np.asarray(v, np.float32) for v in (near, far)), np.asarray(seen, bool)
    core = vc.NeePlusPlus(**given).core()
    return testing.learnt_map(core, *box, *ends, answers, direction=direction)


def connections(n, seed=0):
    """Ends inside and around the box, and answers that depend on them."""
    rng = np.random.default_rng(seed)
    near, far = rng.uniform(np.subtract(LOW, 0.2), np.add(HIGH, 0.2), (2, n, 3))
    return near, far, rng.random(n) < np.clip(near[:, 0] / 3, 0, 1)


@pytest.mark.parametrize("symmetric", [True, False])
@pytest.mark.parametrize(("n", "least", "exponent"), [(3, 0.05, 1.0), (2, 0.3, 0.5), (1, 0.01, 2)])
def test_cells_visibilities_and_probabilities_are_those_of_the_equations(
    n, least, exponent, symmetric
):
    near, far, seen = connections(600)
    a, b, visibility, probability = learn(
        near, far, seen, n_voxels=n, min_probability=least, exponent=exponent, symmetric=symmetric
    )
    np.testing.assert_array_equal(a, reference.voxel(near, LOW, HIGH, n))
    np.testing.assert_array_equal(b, reference.voxel(far, LOW, HIGH, n))
    expected = reference.visibility(a, b, seen, symmetric)
    np.testing.assert_allclose(visibility, expected, rtol=1e-12)
    np.testing.assert_allclose(
        probability, reference.probability(expected, least, exponent), rtol=1e-12
    )
    assert n == 1 or len(np.unique(visibility)) > 5


@pytest.mark.parametrize("n", [1, 4, 16])
def test_directions_have_cells_of_their_own_behind_the_voxels(n):
    rng = np.random.default_rng(1)
    near = rng.uniform(LOW, HIGH, (20_000, 3))
    towards = rng.normal(size=(20_000, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    seen = towards[:, 2] > 0
    _, far, visibility, _ = learn(near, towards, seen, direction=True, n_voxels=2, n_directions=n)
    np.testing.assert_array_equal(far, 8 + reference.direction_cell(towards, n))
    gap = visibility[seen].mean() - visibility[~seen].mean()
    # Half of the sphere is dark; cells on the horizon hold both halves
    assert {1: 0 <= gap < 0.1, 4: 0.3 < gap < 0.6, 16: 0.65 < gap < 0.9}[n]


def test_a_pair_is_shared_in_both_orders_only_if_asked():
    near, far = np.array([[-0.9, 0.1, 2.1]] * 9), np.array([[2.9, 0.4, 3.9]] * 9)
    both = np.concatenate([near, far]), np.concatenate([far, near])
    seen = np.arange(18) < 9  # one way free, the other blocked
    _, _, shared, _ = learn(*both, seen, symmetric=True)
    np.testing.assert_allclose(shared, 10 / 19)
    _, _, apart, _ = learn(*both, seen, symmetric=False)
    np.testing.assert_allclose(apart, np.where(seen, 1.0, 0.1))


@pytest.mark.extreme
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e30, -1e30])
def test_points_that_are_far_off_or_no_numbers_have_a_voxel(value):
    near = np.array([[value, 0.2, 3.0], [1.0, value, 3.0], [value, value, value]])
    a, b, visibility, _ = learn(near, near, [True] * 3, n_voxels=5)
    assert (a < 125).all() and (b < 125).all() and np.isfinite(visibility).all()
    _, b, *_ = learn(near, near, [True] * 3, n_voxels=5, n_directions=7, direction=True)
    assert ((b >= 125) & (b < 125 + 49)).all()


@pytest.mark.extreme
def test_a_flat_box_has_one_layer_of_voxels():
    near = np.random.default_rng(2).uniform(-1, 1, (100, 3)) * [1, 1, 0]
    a, *_ = learn(near, near, [True] * 100, box=((-1, -1, 0), (1, 1, 0)), n_voxels=4)
    assert a.max() < 16 and len(np.unique(a)) > 10


def test_a_map_that_does_not_fit_is_refused_with_the_bytes_it_needs():
    n, cells = 16**3, 16**2
    needed = 8 * (n * (n + 1) // 2 + n * cells)
    near, far, seen = connections(4)
    learn(near, far, seen, max_bytes=needed)
    with pytest.raises(ValueError, match=rf"max_bytes must be >= {needed} for 16³ voxels, got"):
        learn(near, far, seen, max_bytes=needed - 1)
    scene = vc.scenes.cube_on_plane()
    with pytest.raises(ValueError, match=r"max_bytes must be >= .* for 64³ voxels"):
        vc.render(scene, vc.Direct(), size=(8, 8), visibility=vc.NeePlusPlus(n_voxels=64))
