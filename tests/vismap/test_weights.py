"""Weights of records: Eq. 9, its normalisation, the geometric term."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core import testing
from reference import vismap_records as reference
from viscache import _core

vismap = _core.vismap
THETA_MAX = math.radians(30)


def test_weight_is_the_papers():
    t, theta = np.meshgrid(np.linspace(0, 1, 50), np.linspace(0, np.pi, 50))
    expected = reference.weight(t, theta)
    np.testing.assert_allclose(vismap.record_weight(t, theta, 5.0), expected, atol=1e-6)
    np.testing.assert_allclose(
        vismap.record_weight(t, theta, 0.5), reference.weight(t, theta, 0.5), atol=1e-6
    )
    # The test sees a change of one per cent
    assert not np.allclose(vismap.record_weight(t, theta, 5.05), expected, atol=1e-6)


def test_weight_runs_from_one_to_its_least():
    assert vismap.record_weight(0, 0, 5) == 1
    assert vismap.record_weight(1, THETA_MAX, 5) == pytest.approx(0.694, abs=5e-4)
    slope = (vismap.record_weight(1e-3, 0, 5) - 1) / 1e-3
    assert slope == pytest.approx(-1, abs=0.01)
    assert testing.normalized_weight(0, 0, THETA_MAX, 5) == 1
    assert testing.normalized_weight(1, THETA_MAX, THETA_MAX, 5) == pytest.approx(0, abs=1e-6)
    assert testing.normalized_weight(1, 0, THETA_MAX, 5) == pytest.approx(0.4545, abs=1e-3)


@given(st.floats(0, 1), st.floats(0, 1), st.floats(0, 1), st.floats(0, 20))
def test_weight_falls_with_distance_and_angle(a, b, c, lam):
    near, far = sorted((a, b))
    angle = c * THETA_MAX
    of = testing.normalized_weight
    assert of(far, angle, THETA_MAX, lam) <= of(near, angle, THETA_MAX, lam) + 1e-6
    assert of(c, far * THETA_MAX, THETA_MAX, lam) <= of(c, near * THETA_MAX, THETA_MAX, lam) + 1e-6
    assert 0 <= of(far, angle, THETA_MAX, lam) <= 1


def test_angle_of_normals_keeps_its_digits():
    z = (0.0, 0.0, 1.0)
    for angle in (0, 1e-6, 1e-4, 0.5, math.pi / 2, 3.0, math.pi):
        other = (math.sin(angle), 0.0, math.cos(angle))
        assert testing.normal_angle(z, other) == pytest.approx(angle, rel=1e-5, abs=1e-7)


def test_records_before_and_behind_the_plane_weigh_less():
    z = (0.0, 0.0, 1.0)
    assert testing.geometric_weight(z, (0.3, 0.4, 0.0), 1) == 1
    assert testing.geometric_weight(z, (0.0, 0.0, 0.5), 1) == 0
    assert testing.geometric_weight(z, (0.3, 0.0, 0.4), 1) == pytest.approx(0.2, abs=1e-6)
    assert testing.geometric_weight(z, (0.3, 0.0, -0.4), 1) == pytest.approx(0.2, abs=1e-6)


@pytest.mark.extreme
def test_a_record_at_the_point_weighs_one():
    z = (0.0, 0.0, 1.0)
    assert testing.geometric_weight(z, (0.0, 0.0, 0.0), 1) == 1
    assert testing.geometric_weight(z, (0.0, 0.0, 9e-7), 1) == 1
    assert testing.geometric_weight(z, (0.0, 0.0, 2e-6), 1) == 0
    assert testing.geometric_weight(z, (0.0, 0.0, 9e-27), 1e-20) == 1
