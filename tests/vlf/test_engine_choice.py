"""The engine for aligned rays is predicted from the input only, with a reason."""

from __future__ import annotations

import numpy as np

import viscache as vc
from viscache import _core
from vlf.aligned_scenes import frames_of, surface


def test_many_points_go_through_the_batch_and_few_through_embree() -> None:
    scene = vc.scenes.bumpy_spheres(triangles=100_000)
    # Without SIMD the predicted cost of the batch is four times as high
    many = "embree" if _core.active_isa() == "portable" else "batch"
    for n, engine in ((100_000, many), (500, "embree")):
        points, normals = surface(scene, n)
        rows = vc.vlf.trace_aligned(scene, points, normals, 33)
        assert rows.engine == engine
        assert f"{scene.triangles} triangles, {n} points" in rows.reason
        asked = vc.vlf.trace_aligned(scene, points, normals, 33, engine=engine)
        np.testing.assert_array_equal(rows.bits, asked.bits)


def test_the_choice_depends_on_nothing_but_the_input() -> None:
    scene = vc.scenes.bumpy_spheres(triangles=30_000)
    points, normals = surface(scene, 8000)
    first = scene.aligned_batch().choose(scene._core, points, normals, frames_of(513), threads=1)
    for threads in (1, 2, 5):
        again = scene.aligned_batch().choose(
            scene._core, points, normals, frames_of(513), threads=threads
        )
        assert again == first


def test_predictions_follow_how_crowded_the_scene_is() -> None:
    """More triangles per point cost both engines more; the batch's cost grows faster."""
    costs = []
    for triangles in (2000, 20_000, 200_000):
        scene = vc.scenes.bumpy_spheres(triangles=triangles)
        points, normals = surface(scene, 5000)
        is_batch, batch, embree = scene.aligned_batch().choose(
            scene._core, points, normals, frames_of(513)
        )
        assert is_batch == (batch <= 0.9 * embree)
        costs.append((batch, embree, batch / embree))
    assert [c == tuple(sorted(c)) for c in zip(*costs, strict=True)] == [True] * 3


def test_what_cannot_pay_is_not_even_probed() -> None:
    assert _core.vlf.is_hopeless(1_000_000, 1000)
    assert not _core.vlf.is_hopeless(1_000_000, 100_000)
    scene = vc.scenes.bumpy_spheres(triangles=100_000)
    points, normals = surface(scene, 100)
    rows = vc.vlf.trace_aligned(scene, points, normals, 9)
    assert rows.engine == "embree" and rows.reason.startswith("too few points")
    assert scene._batch is None
