"""Frames by Next Event Estimation++: right in expectation, and what they leave out."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from render.test_determinism import INTEGRATORS, ROOM
from render.ztest import ZTest, compare
from viscache import _core

SIZE = (64, 48)
#: Coarse, so that voxels see each other in part, and quick to learn.
COARSE = vc.NeePlusPlus(n_voxels=4, n_directions=4, learn_pixels=768, min_probability=0.1)
SKY = vc.Direct(environment="shared", n_environment=32, n_area=2)


@pytest.fixture(scope="module")
def room() -> vc.Scene:
    return ROOM.to_viscache()


def stack(scene: vc.Scene, integrator: Any, visibility: Any, seeds: range) -> npt.NDArray[Any]:
    return np.stack(
        [
            vc.render(scene, integrator, size=SIZE, visibility=visibility, seed=s).image
            for s in seeds
        ]
    )


def paired(frames: npt.NDArray[Any], exact: npt.NDArray[Any]) -> ZTest:
    """Against the exact frames of the same seeds, by 8 × 8 blocks: they differ by roulette alone.

    A pixel's answers are too rare to be normal.
    """
    blocks = [
        np.asarray(i, np.float64).reshape(len(i), -1, 8, i.shape[2] // 8, 8, 3).mean(axis=(2, 4))
        for i in (frames, exact)
    ]
    mean = blocks[1].mean(axis=0)
    return compare(blocks[0] - blocks[1] + mean, np.repeat(mean[None], 4, axis=0), edge=2)


@pytest.mark.stat
def test_light_between_voxels_learnt_as_dark_still_arrives() -> None:
    """Slits of light share coarse voxels with shadows, and are traced one time in ten."""
    scene = vc.scenes.stairs(12)
    seeds = range(96)
    exact = stack(scene, vc.Direct(), vc.Exact(), seeds)
    ours = stack(scene, vc.Direct(), COARSE, seeds)
    assert (ours - exact).std() > 0.05 * exact.mean()
    result = paired(ours, exact)
    assert result.same, str(result)
    assert not paired(0.98 * ours, exact).same


@pytest.mark.parametrize("integrator", [*INTEGRATORS, SKY], ids=lambda i: type(i).__name__)
@pytest.mark.parametrize("never", [{"min_probability": 1.0}, {"exponent": 0.0}])
def test_where_nothing_is_left_out_the_frame_is_the_exact_one(
    integrator: Any, never: dict[str, float], room: vc.Scene
) -> None:
    exact = vc.render(room, integrator, size=SIZE)
    frame = vc.render(room, integrator, size=SIZE, visibility=vc.NeePlusPlus(**never))
    assert frame.sha256 == exact.sha256
    assert frame.counters["discarded"] == 0
    assert frame.counters["rays"] - frame.counters["learning_rays"] == exact.counters["rays"]
    groups = exact.counters["groups"]
    assert [g["queries"] for g in frame.counters["groups"].values()] == [
        g["queries"] for g in groups.values()
    ]


def walled() -> vc.Scene:
    """A floor, and a lamp behind a wall that hides it from half of the floor."""
    d = _core.SceneDescription()
    quads = [((-4, 0, -4), (0, 0, 8), (8, 0, 0)), ((0, 0, -4), (0, 0, 8), (0, 4, 0))]
    for o, a, b in quads:
        corners = np.array([o, np.add(o, a), np.add(np.add(o, a), b), np.add(o, b)], np.float32)
        d.add_mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    d.add_point_light((2.0, 2.0, 0.1), (9, 9, 9))
    return vc.Scene.from_description(d)


def test_connections_between_voxels_that_never_see_each_other_are_hardly_traced() -> None:
    scene = walled()
    camera = vc.look_at((0.0, 12.0, 0.01), (0, 0, 0), fov_deg=40)
    view: dict[str, Any] = {"size": (160, 100), "camera": camera}
    exact = vc.render(scene, vc.Direct(), **view)
    frame = vc.render(scene, vc.Direct(), visibility=vc.NeePlusPlus(), **view)
    queries, occluded = exact.counters["queries"], exact.counters["occluded"]
    assert 0.3 * queries < occluded
    assert frame.counters["discarded"] > 0.5 * occluded
    # What is seen is seen from voxels that see: its noise is confined to those the shadow cuts
    assert vc.metrics.rel_l1(frame.image, exact.image) < 0.05


def test_more_voxels_leave_less_noise_and_smaller_exponents_too(room: vc.Scene) -> None:
    exact = vc.render(room, vc.Direct(n_area=0), size=(64, 48))

    def error(**given: Any) -> float:
        settings = vc.NeePlusPlus(learn_pixels=1 << 12, **given)
        frame = vc.render(room, vc.Direct(n_area=0), size=(64, 48), visibility=settings)
        return vc.metrics.rel_l1(frame.image, exact.image)

    errors = [error(n_voxels=n) for n in (2, 6, 16)]
    assert errors[0] > 1.2 * errors[1] > 1.2 * 1.2 * errors[2] > 0
    assert error(n_voxels=2, exponent=0.25) < 0.7 * errors[0]
