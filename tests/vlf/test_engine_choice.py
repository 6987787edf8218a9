"""The engine for aligned rays is predicted from the input only, with a reason."""

import numpy as np
import pytest

import viscache as vc
from viscache import _core
from vlf.aligned_scenes import frames_of, surface

#: The batch is taken below this share of Embree's predicted cost.
SHARE = 0.75
needs_avx512 = pytest.mark.skipif(
    _core.active_isa() != "avx512", reason="the batch is slower without AVX-512"
)


def seen_by_camera(scene, size):
    eyes = vc.connections(scene, vc.Direct(), size=size).eyes
    return eyes.positions, eyes.normals


def work(scene, points, normals, frames, t_max):
    """(bits, counts) of the batch."""
    return scene.aligned_batch().rows(scene._core, points, normals, frames, t_max=t_max)


@needs_avx512
@pytest.mark.parametrize("n_directions", [33, 513])
def test_many_points_before_large_triangles_go_through_the_batch(n_directions):
    """Large triangles block whole nodes of the tree of points: few tests per ray are left."""
    scene = vc.scenes.cornell_box()
    points, normals = seen_by_camera(scene, (96, 60))
    sample = scene.aligned_batch().sample(scene._core, points, normals, frames_of(n_directions))
    assert sample["tests"] < 0.5 and sample["blocks"] < 0.01
    rows = vc.vlf.trace_aligned(scene, points, normals, n_directions)
    assert rows.engine == "batch"


@pytest.mark.parametrize("t_max", [0.02, 0.1])
def test_short_rays_from_few_points_go_to_embree(t_max):
    """Each pass of the batch meets more blocks of triangles than it has packets of points."""
    scene = vc.scenes.bumpy_spheres(triangles=30_000)
    points, normals = seen_by_camera(scene, (96, 60))
    assert not _core.vlf.is_hopeless(scene._core, len(points), t_max)
    batch = scene.aligned_batch()
    sample = batch.sample(scene._core, points, normals, frames_of(513), t_max=t_max)
    assert sample["free"] > 0.5 and 16 * sample["blocks"] > 1
    rows = vc.vlf.trace_aligned(scene, points, normals, 513, t_max=t_max)
    assert rows.engine == "embree" and rows.reason.startswith("predicted ns per ray")


def test_the_chosen_engines_bits_are_returned():
    scene = vc.scenes.bumpy_spheres(triangles=3000)
    points, normals = surface(scene, 3000)
    rows = vc.vlf.trace_aligned(scene, points, normals, 129)
    asked = vc.vlf.trace_aligned(scene, points, normals, 129, engine=rows.engine)
    np.testing.assert_array_equal(rows.bits, asked.bits)
    assert f"{scene.triangles} triangles, 3000 points" in rows.reason


@pytest.mark.parametrize("t_max", [0.1, np.inf])
@pytest.mark.parametrize("n_directions", [33, 513])
def test_the_choice_depends_on_nothing_but_the_input(n_directions, t_max):
    scene = vc.scenes.bumpy_spheres(triangles=20_000)
    points, normals = surface(scene, 4000)
    batch, frames = scene.aligned_batch(), frames_of(n_directions)
    arguments = (scene._core, points, normals, frames)
    first = batch.choose(*arguments, t_max=t_max, threads=1)
    sample = batch.sample(*arguments, t_max=t_max, threads=1)
    assert 0 < first[1] < np.inf and 0 < first[2] < np.inf
    for threads in (2, 5):
        assert batch.choose(*arguments, t_max=t_max, threads=threads) == first
        assert batch.sample(*arguments, t_max=t_max, threads=threads) == sample


def test_a_sample_estimates_the_work_of_all_rays():
    scene = vc.scenes.bumpy_spheres(triangles=20_000)
    points, normals = seen_by_camera(scene, (160, 100))
    frames = frames_of(513)
    sample = scene.aligned_batch().sample(scene._core, points, normals, frames, t_max=0.3)
    bits, counts = work(scene, points, normals, frames_of(513, 65), 0.3)
    n_rays = 65 * len(points)
    assert abs(sample["free"] - np.bitwise_count(bits).sum() / n_rays) < 0.15
    for name in ("nodes", "pairs", "tests", "wide", "blocks"):
        assert 0.4 < sample[name] / (counts[name] / n_rays) < 2.5, name


def test_short_rays_pass_by_what_is_beyond_their_reach():
    scene = vc.scenes.random_triangles(triangles=5000, edge=0.05)
    points, normals = surface(scene, 2000)
    frames = frames_of(129, 17)
    before = np.inf
    for t_max in (np.inf, 0.3, 0.1, 0.03):
        bits, counts = work(scene, points, normals, frames, t_max)
        assert counts["pairs"] < (0.9 if t_max < 0.3 else 1) * before
        assert counts["wide"] <= counts["tests"]
        before = counts["pairs"]
        embree = _core.vlf.embree_rows(scene.caster(), points, normals, frames, t_max=t_max)
        assert np.bitwise_count(bits ^ embree).sum() <= 2
    # Long rays are dropped once they are blocked; short ones would go on without a limit of depth
    assert before < 0.5 * work(scene, points, normals, frames, np.inf)[1]["pairs"]


@needs_avx512
def test_predictions_follow_how_crowded_the_scene_is():
    """More triangles per point cost both engines more, and the batch loses its advantage."""
    costs = []
    for triangles in (2000, 20_000, 200_000):
        scene = vc.scenes.bumpy_spheres(triangles=triangles)
        points, normals = surface(scene, 5000)
        is_batch, batch, embree = scene.aligned_batch().choose(
            scene._core, points, normals, frames_of(513)
        )
        assert is_batch == (batch < SHARE * embree)
        costs.append((batch, embree))
    assert [c == tuple(sorted(c)) for c in zip(*costs, strict=True)] == [True] * 2
    few, many = costs[0], costs[-1]
    assert few[0] / few[1] < SHARE < many[0] / many[1]


def test_what_cannot_pay_is_not_even_probed():
    scene = vc.scenes.bumpy_spheres(triangles=100_000)
    hopeless = _core.vlf.is_hopeless
    assert hopeless(scene._core, 2000) and not hopeless(scene._core, 4000)
    assert hopeless(scene._core, 4000, 0.1) and not hopeless(scene._core, 20_000, 0.1)
    points, normals = surface(scene, 100)
    rows = vc.vlf.trace_aligned(scene, points, normals, 9)
    assert rows.engine == "embree" and rows.reason.startswith("too few points")
    assert "aligned_batch" not in scene._made


def test_an_order_that_misses_points_is_refused():
    scene = vc.scenes.cube_on_plane()
    points, normals = surface(scene, 20)
    order = _core.vlf.point_order(points)
    np.testing.assert_array_equal(np.sort(order), np.arange(20))
    for wrong in (order[:-1], np.zeros(20, np.uint32), order + 1):
        with pytest.raises(ValueError, match="order must hold the index of each point once"):
            scene.aligned_batch().rows(
                scene._core, points, normals, frames_of(9), order=wrong.astype(np.uint32)
            )
