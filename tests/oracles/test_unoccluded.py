"""Light without shadows: the baseline that every cache must beat."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import viscache as vc
from reference.built import built

SIZE = (32, 24)
ROOM = "room?triangles=2000"


@pytest.mark.parametrize(
    "integrator", [vc.Whitted(n_vpls=64), vc.Direct(n_area=4)], ids=["shared lights", "own samples"]
)
def test_the_frame_is_all_contributions_summed(integrator: Any) -> None:
    scene = built(ROOM)
    frame = vc.render(scene, integrator, size=SIZE, visibility=vc.Unoccluded())
    taps = vc.connections(scene, integrator, size=SIZE)
    seen = {name: np.ones_like(answer.visible) for name, answer in taps.answers(vc.Exact()).items()}
    assert frame.sha256 == taps.frame(seen).sha256
    exact = vc.render(scene, integrator, size=SIZE)
    assert frame.counters["queries"] == exact.counters["queries"]
    assert frame.counters["rays"] == frame.counters["occluded"] == 0
    assert np.all(frame.image >= exact.image * (1 - 1e-5))
    assert frame.image.mean() > 1.02 * exact.image.mean()


def test_ambient_occlusion_is_white_and_bidirectional_paths_take_it() -> None:
    scene = built(ROOM)
    ambient = vc.AmbientOcclusion(n_samples=4)
    frame = vc.render(scene, ambient, size=SIZE, visibility=vc.Unoccluded())
    assert frame.image.min() == pytest.approx(1, abs=1e-6)
    paths = vc.Bdpt(max_depth=3)
    bright, exact = (
        vc.render(scene, paths, size=SIZE, visibility=v).image.mean()
        for v in (vc.Unoccluded(), vc.Exact())
    )
    assert bright > exact
