"""Processing orders: AQVC Sec. 4.3."""

import numpy as np
import pytest

from core import testing
from reference import aqvc as reference
from viscache import _core

aqvc = _core.aqvc


def make(width, height, branches=1, **options):
    y, x = np.divmod(np.tile(np.arange(width * height), branches), width)
    order = testing.order(x.tolist(), y.tolist(), width, height, aqvc.AqvcParameters(**options))
    return x, y, order


@pytest.mark.parametrize("order", ["hm", "scanline", "random"])
@pytest.mark.parametrize(("width", "height"), [(1, 1), (16, 16), (13, 29), (32, 8)])
def test_every_eye_point_occurs_once(order, width, height):
    _, _, o = make(width, height, branches=2, order=order)
    assert sorted(o["eye"]) == list(range(2 * width * height))
    assert o["segment_end"][-1] == o["run_end"][-1] == 2 * width * height


def test_segments_hold_the_points_of_the_halton_sequence():
    """Cut at C_PI, C_PI·C_PG, …; Morton order inside, x on the low bit."""
    x, y, o = make(24, 20, c_e=6)
    visited = reference.halton_order(24, 20)
    assert o["segment_end"][0] == 24 * 20 // 36
    first, density = 0, 24 * 20 / 36
    for end in o["segment_end"]:
        assert end == min(480, int(density))
        mine = [(int(x[e]), int(y[e])) for e in o["eye"][first:end]]
        assert set(mine) == set(visited[first:end])

        def morton(p):
            return sum((p[0] >> b & 1) << 2 * b | (p[1] >> b & 1) << 2 * b + 1 for b in range(8))

        assert mine == sorted(mine, key=morton)
        first, density = end, density * 3.7


def test_runs_never_straddle_a_segment():
    _, _, o = make(32, 32, c_e=8, batch=50)
    assert set(o["segment_end"]) <= set(o["run_end"])
    assert np.diff([0, *o["run_end"]]).max() <= 50


@pytest.mark.extreme
def test_positions_outside_the_tile_fall_back_to_the_given_order():
    o = testing.order([0, 9], [0, 0], 2, 2, aqvc.AqvcParameters())
    assert o["eye"] == [0, 1]
    empty = testing.order([], [], 0, 0, aqvc.AqvcParameters())
    assert empty["eye"] == [] and empty["run_end"] == []
