"""Flicker of cached frames above the reference's."""

import numpy as np
import pytest

from viscache.frame import Frame
from viscache.metrics import temporal


def frames(*values):
    return [Frame(layers={"color": np.full((2, 3, 3), v, np.float32)}) for v in values]


def test_an_error_that_stands_still_does_not_flicker():
    exact = frames(0.1, 0.2, 0.3)
    found = temporal.flicker(frames(0.2, 0.3, 0.4), exact, exposure=1.0)
    assert found.cached == pytest.approx(found.exact) == pytest.approx(0.01)
    assert found.error == pytest.approx(0, abs=1e-12) and found.above == pytest.approx(0, abs=1e-9)


def test_flicker_over_a_still_scene_is_the_variance_of_the_error():
    found = temporal.flicker(frames(0.1, 0.3, 0.2), frames(0.2, 0.2, 0.2), exposure=2.0)
    assert found.exact == pytest.approx(0, abs=1e-12)
    assert found.above == pytest.approx(found.error) == pytest.approx(4 * 0.01)


def test_a_cache_that_misses_motion_lies_below_the_reference():
    found = temporal.flicker(frames(0.2, 0.2), frames(0.1, 0.3), exposure=1.0)
    assert found.above == pytest.approx(-0.02) and found.error == pytest.approx(0.02)


def test_what_is_white_on_the_screen_cannot_flicker():
    found = temporal.flicker(frames(5.0, 9.0), frames(5.0, 3.0), exposure=1.0)
    assert found == temporal.Flicker(0.0, 0.0, 0.0)
    shown = temporal.flicker(frames(5.0, 9.0), frames(5.0, 3.0))
    assert shown.exact > 0  # the exposure of the first reference


def test_sequences_must_be_equally_long_and_have_two_frames():
    for some, others in ((1, 1), (3, 2), (0, 0)):
        with pytest.raises(ValueError, match="frames and references must be equally many"):
            temporal.flicker(frames(*[0.1] * some), frames(*[0.1] * others))
