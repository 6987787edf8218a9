"""The queue of postponed rays, against its transcription."""

import itertools

import numpy as np
import pytest

import viscache as vc
from aqvc import tiles
from reference import aqvc as reference
from reference.aqvc_postponed import postponed
from viscache import _core

QUEUES = [(64, 31), (64, 33), (64, 1), (16, 5), (6, 2), (2, 1)]
PAPER = {"c_z": 8.0, "c_finest": "log2", "level_step": 2.0, "refinement": "on"}


def runs_of(run):
    order, ends = run.order()
    return [order[a:b] for a, b in itertools.pairwise([0, *ends])]


def transcribed(run, exact, wanted, eyes, c_e, queue, c_w):
    grid = reference.Grid(tiles.CENTER, tiles.RADIUS, c_z=PAPER["c_z"])
    levels = _core.aqvc.AqvcParameters(c_e=c_e, **PAPER).level_list(0)
    return postponed(grid, eyes, levels, exact, wanted, runs_of(run), queue, c_w)


@pytest.mark.parametrize(("queue", "c_w"), QUEUES)
def test_postponed_rays_are_those_of_the_transcription(queue, c_w):
    eyes, far = tiles.eye_points(20, 20), tiles.lights("point", 7)
    wanted = tiles.facing(eyes, far)
    run = tiles.tile_run(eyes, c_e=7, form="pairs", storage="exact", queue=queue, c_w=c_w, **PAPER)
    exact, _ = run.block(far, wanted, exact=True)
    run.begin_tile()
    visible, counters = run.block(far, wanted)
    want = transcribed(run, exact, wanted, eyes, 7, queue, c_w)
    np.testing.assert_array_equal(visible, want.visible & wanted)
    assert counters["rays_per_level"][: len(want.rays_per_level)] == want.rays_per_level
    assert 0 < counters["rays"] < wanted.sum() and (visible != exact).any()


def test_a_warp_of_one_query_is_algorithm_2():
    eyes, far = tiles.eye_points(), tiles.lights("point", 12)
    wanted = tiles.facing(eyes, far)
    options = {"c_e": 8, "form": "pairs", "storage": "exact", **PAPER}
    alone = tiles.tile_run(eyes, queue=2, c_w=1, **options).block(far, wanted)
    one_by_one = tiles.tile_run(eyes, batch=1, **options).block(far, wanted)
    np.testing.assert_array_equal(alone[0], one_by_one[0])
    assert alone[1]["rays_per_level"] == one_by_one[1]["rays_per_level"]


def test_a_queue_longer_than_a_call_is_a_batch():
    eyes, far = tiles.eye_points(8, 8), tiles.lights("point", 6)
    wanted = tiles.facing(eyes, far)
    options = {"c_e": 5, "form": "pairs", "storage": "exact", **PAPER}
    queued = tiles.tile_run(eyes, queue=1024, c_w=1024, **options).block(far, wanted)
    batched = tiles.tile_run(eyes, **options).block(far, wanted)
    np.testing.assert_array_equal(queued[0], batched[0])
    assert queued[1]["rays_per_level"] == batched[1]["rays_per_level"]


def test_nothing_postponed_outlives_a_call_and_keyless_points_are_answered():
    eyes, far = tiles.eye_points(), tiles.lights("vpl", 12)
    wanted = tiles.facing(eyes, far)
    eyes["normal"][::3] = 0
    run = tiles.tile_run(eyes, c_e=1e-3, form="pairs", queue=64)
    visible, counters = run.block(far, wanted)
    exact, _ = run.block(far, wanted, exact=True)
    np.testing.assert_array_equal(visible, exact)
    assert counters["bypassed"] == wanted[::3].sum() > 0


def test_bidirectional_path_tracing_has_no_queue():
    scene = vc.scenes.cornell_box()
    with pytest.raises(ValueError, match=r"queue must be 0 .* got 64"):
        vc.render(scene, vc.Bdpt(), size=(4, 4), visibility=vc.Aqvc(paper=vc.PaperForm(queue=64)))
