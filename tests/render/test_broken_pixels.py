"""Pixels whose sums of light overflow are counted and warned of."""

from __future__ import annotations

import numpy as np
import pytest

import viscache as vc


def frame(power: float) -> vc.Frame:
    d = vc.SceneDescription()
    d.add_material()
    d.add_mesh(
        np.array([[-4, 0, 4], [4, 0, 4], [4, 0, -4], [-4, 0, -4]], np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
    )
    d.add_point_light((0, 0.1, 0), (power,) * 3)
    d.add_camera((0, 0.4, 0.4), (0, 0, 0))
    return vc.render(vc.Scene.from_description(d), vc.Direct(), size=(16, 10))


@pytest.mark.extreme
def test_pixels_that_are_not_finite_are_counted_and_warned_of() -> None:
    broken = frame(1e38)
    count = int((~np.isfinite(broken.image).all(axis=2)).sum())
    assert count > 0
    assert broken.counters["non_finite_pixels"] == count
    assert broken.counters["non_finite"] >= count
    assert any(f"{count} pixels are not finite" in w for w in broken.warnings)


def test_finite_frames_have_none() -> None:
    whole = frame(1.0)
    assert whole.counters["non_finite_pixels"] == whole.counters["non_finite"] == 0
    assert not any("not finite" in w for w in whole.warnings)
