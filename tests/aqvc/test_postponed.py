"""The queue of postponed rays, against its transcription."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from aqvc import tiles
from reference import aqvc as reference
from reference.aqvc_postponed import postponed
from viscache import _core

QUEUES = [(64, 31), (64, 33), (64, 1), (16, 5), (6, 2), (2, 1)]
PAPER: dict[str, Any] = {"c_z": 8.0, "c_finest": "log2", "level_step": 2.0, "refinement": "on"}


def runs_of(run: Any) -> list[list[int]]:
    order, ends = run.order()
    return [order[a:b] for a, b in itertools.pairwise([0, *ends])]


def transcribed(
    run: Any,
    exact: npt.NDArray[np.bool_],
    wanted: npt.NDArray[np.bool_],
    eyes: Any,
    c_e: float,
    queue: int,
    c_w: int,
) -> reference.Result:
    grid = reference.Grid(tiles.CENTER, tiles.RADIUS, c_z=PAPER["c_z"])
    levels = _core.aqvc.AqvcParameters(c_e=c_e, **PAPER).level_list(0)
    return postponed(grid, eyes, levels, exact, wanted, runs_of(run), queue, c_w)


@pytest.mark.parametrize(("queue", "c_w"), QUEUES)
def test_postponed_rays_are_those_of_the_transcription(queue: int, c_w: int) -> None:
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


def test_a_warp_of_one_query_is_algorithm_2() -> None:
    eyes, far = tiles.eye_points(), tiles.lights("point", 12)
    wanted = tiles.facing(eyes, far)
    options: dict[str, Any] = {"c_e": 8, "form": "pairs", "storage": "exact", **PAPER}
    alone = tiles.tile_run(eyes, queue=2, c_w=1, **options).block(far, wanted)
    one_by_one = tiles.tile_run(eyes, batch=1, **options).block(far, wanted)
    np.testing.assert_array_equal(alone[0], one_by_one[0])
    assert alone[1]["rays_per_level"] == one_by_one[1]["rays_per_level"]


def test_a_queue_longer_than_a_call_is_a_batch() -> None:
    """All misses wait for the end of the call: the batched form of the same runs."""
    eyes, far = tiles.eye_points(8, 8), tiles.lights("point", 6)
    wanted = tiles.facing(eyes, far)
    options: dict[str, Any] = {"c_e": 5, "form": "pairs", "storage": "exact", **PAPER}
    queued = tiles.tile_run(eyes, queue=1024, c_w=1024, **options).block(far, wanted)
    batched = tiles.tile_run(eyes, **options).block(far, wanted)
    np.testing.assert_array_equal(queued[0], batched[0])
    assert queued[1]["rays_per_level"] == batched[1]["rays_per_level"]


def test_nothing_postponed_outlives_a_call_and_keyless_points_are_answered() -> None:
    eyes, far = tiles.eye_points(), tiles.lights("vpl", 12)
    wanted = tiles.facing(eyes, far)
    eyes["normal"][::3] = 0
    run = tiles.tile_run(eyes, c_e=1e-3, form="pairs", queue=64)
    visible, counters = run.block(far, wanted)
    exact, _ = run.block(far, wanted, exact=True)
    np.testing.assert_array_equal(visible, exact)
    assert counters["bypassed"] == wanted[::3].sum() > 0


def test_postponing_costs_few_rays_and_little_error() -> None:
    eyes, far = tiles.eye_points(64, 64), tiles.lights("point", 12)
    wanted = tiles.facing(eyes, far)
    options: dict[str, Any] = {"c_e": 12, "form": "pairs", "storage": "exact", **PAPER}
    alone = tiles.tile_run(eyes, batch=1, **options)
    exact, _ = alone.block(far, wanted, exact=True)
    one, c1 = alone.block(far, wanted)
    queued, c2 = tiles.tile_run(eyes, queue=64, **options).block(far, wanted)
    assert 0.8 < c2["rays"] / c1["rays"] < 1.1
    assert 0.6 < (queued != exact).sum() / (one != exact).sum() < 1.6
    assert (queued != one).any()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"queue": 63}, r"queue must be even and in \[0, 1024\], got 63"),
        ({"queue": -2}, "queue must be even"),
        ({"queue": 2048}, "queue must be even"),
        ({"c_w": 0}, r"c_w must be in \[1, 1024\], got 0"),
        ({"queue": 8.5}, "queue must be"),
    ],
)
def test_bad_queues_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        vc.PaperForm(**given)


def test_bidirectional_path_tracing_has_no_queue() -> None:
    scene = vc.scenes.cornell_box()
    with pytest.raises(ValueError, match=r"queue must be 0 .* got 64"):
        vc.render(scene, vc.Bdpt(), size=(4, 4), visibility=vc.Aqvc(paper=vc.PaperForm(queue=64)))
