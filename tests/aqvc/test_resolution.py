"""Resolutions: AQVC Eq. 2, 3, 5-9."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core import testing
from reference import aqvc as reference
from viscache import _core

aqvc = _core.aqvc
POSITIVE = st.floats(1e-6, 1e6)


def test_the_printed_examples_of_equations_6_7_and_9_hold():
    assert testing.resolution_pair(16.0, 1.0, 2.0, 1.0) == pytest.approx(2 * 4**0.25)
    assert aqvc.resolution_eye(16.0, 2.0, 1.0) == pytest.approx(4)
    assert testing.resolution_environment(256 / (4 * np.pi)) == pytest.approx(16)
    printed = testing.resolution_environment(256 / (4 * np.pi), printed=True)
    assert printed == pytest.approx(1.273, abs=1e-3)


@given(POSITIVE, POSITIVE, st.floats(0.1, 64), st.floats(1e-3, 1e3), st.integers(1, 10**6))
def test_patches_of_equations_6_and_7_have_the_area_of_equation_3(d_e, d_l, c_e, b_r, n_s):
    """A_e·A_l·P_e·P_l·N_P = C_E² before the ladder, for both rules."""
    p_e, m = d_e / n_s, 7.0
    p_l, n_p = d_l / m, m * n_s
    area = testing.patch_area_product(p_e, p_l, n_p, c_e)
    both = testing.patch_area(testing.resolution_pair(d_e, d_l, c_e, b_r), b_r) ** 2
    split = testing.patch_area(aqvc.resolution_eye(d_e, c_e, b_r), b_r)
    split *= testing.patch_area(testing.resolution_light(d_l, b_r), b_r)
    assert both == pytest.approx(area, rel=1e-12)
    assert split == pytest.approx(area, rel=1e-12)
    assert testing.expected_paths(n_p, p_e, area, p_l, 1.0) == pytest.approx(c_e**2, rel=1e-12)


@pytest.mark.extreme
def test_densities_of_thirty_decades_keep_resolutions_finite():
    for d in (1e-30, 1e30):
        assert 0 < testing.resolution_pair(d, d, 12.0, 1.0) < np.inf
    tiny = testing.resolution_pair(1e-300, 1e-300, 1.0, 1.0)
    assert tiny == pytest.approx(2e-150)


@pytest.mark.parametrize("c_r", [1.1, 1.2, 1.5, 2.0, 2.5])
def test_the_ladder_is_equation_8(c_r):
    """The table equals ⌊C_R^⌊log R + ½⌋⌋ where R >= 1 and never decreases."""
    r = np.exp(np.random.default_rng(1).uniform(0, 18, 20000))
    got, slots, clamps = testing.ladder(np.sort(r), c_r=c_r)
    np.testing.assert_array_equal(got, reference.ladder(np.sort(r), c_r))
    np.testing.assert_array_equal(slots, got)
    assert (np.diff(got) >= 0).all() and got.min() >= 1
    assert clamps == {"low": 0, "high": 0, "nan": 0}


def test_the_ladder_has_the_known_rungs():
    rungs = np.unique(testing.ladder(np.linspace(1, 120, 5000))[0]).astype(int).tolist()
    want = [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 15, 18, 22, 26, 31, 38, 46, 55, 66, 79, 95, 114]
    assert rungs == want


@pytest.mark.extreme
@pytest.mark.parametrize(
    ("r", "clamp"),
    [(0.0, "low"), (-0.0, "low"), (0.9, "low"), (-3.0, "low"), (np.nan, "nan"), (np.inf, "high")],
)
def test_resolutions_out_of_range_are_clamped_and_counted(r, clamp):
    got, slot, clamps = testing.ladder([r])
    assert clamps == {"low": 0, "high": 0, "nan": 0, clamp: 1}
    assert slot[0] > 0
    assert got[0] == 1 if clamp == "low" else got[0] > 2e8


@pytest.mark.extreme
def test_resolutions_beyond_32_bits_get_finer_still():
    """R > R_max is folded, not clamped: a negative slot, counted."""
    got, slot, clamps = testing.ladder([1e9, 1e12, 1e14])
    np.testing.assert_allclose(got, [1e9, 1e12, 1e14], rtol=0.1)
    assert (slot < 0).all() and len(set(slot)) == 3 and clamps["high"] == 3
