"""The map of where numbers hold: its scenes can be made, and what holds ends where errors grow."""

import numpy as np
import pytest

from viscache_lab.extremes import chart, scenes
from viscache_lab.extremes.families.moves import shift
from viscache_lab.extremes.moved import moved


@pytest.mark.parametrize("x", sorted({*chart.AXES["scale"][1], *chart.AXES["scale"][2]}))
def test_every_scale_of_the_map_can_be_made(x):
    box = scenes.lit_box()
    placed, unit = (np.asarray(s.bounds) for s in (moved(box, scale=x), box))
    np.testing.assert_allclose(placed, x * unit, rtol=1e-5)


@pytest.mark.parametrize("x", sorted({*chart.AXES["offset"][1], *chart.AXES["offset"][2]}))
def test_every_offset_of_the_map_can_be_made(x):
    box = scenes.lit_box()
    placed, unit = (np.asarray(s.bounds) for s in (moved(box, shift=shift(x)), box))
    np.testing.assert_allclose(placed, unit + shift(x), rtol=1e-6, atol=1e-6)


def test_an_error_holds_up_to_the_first_value_where_it_grows():
    errors = {1e-6: 0.5, 1e-3: 0.1, 1.0: 0.1, 1e3: 0.109, 1e6: 0.2, 1e9: 0.1}
    rows = [
        {"axis": "scale", "method": "m", "x": x, "error": error, "own": 0.1}
        for x, error in errors.items()
    ]
    assert chart.holding(rows, "scale", "m") == (1e-3, 1e3)
