"""Alg. 2, one query at a time and in batches."""

import numpy as np
import pytest

from aqvc import tiles
from aqvc.test_waves import OPTIONS, grid_of
from reference import aqvc as reference
from viscache import _core


@pytest.mark.parametrize("kind", ["point", "directional", "vpl"])
@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_one_query_at_a_time_equals_the_transcription_of_algorithm_2(kind, options):
    eyes, far = tiles.eye_points(), tiles.lights(kind, 12)
    wanted = tiles.facing(eyes, far)
    run = tiles.tile_run(eyes, form="pairs", batch=1, storage="exact", **options)
    exact, _ = run.block(far, wanted, exact=True)
    levels = _core.aqvc.AqvcParameters(**options).level_list(far["group"])
    order, _ = run.order()
    want = reference.alg2(grid_of(options), eyes, levels, exact, wanted, order)
    visible, counters = run.block(far, wanted)
    np.testing.assert_array_equal(visible, want.visible)
    assert counters["rays_per_level"][: len(levels)] == want.rays_per_level
    assert counters["rays"] == want.rays < wanted.sum()


def test_larger_batches_trace_fewer_refinement_rays():
    """Batch mates cannot trigger refinement in each other."""
    eyes, far = tiles.eye_points(), tiles.lights("point", 12)
    wanted = tiles.facing(eyes, far)
    rays = [
        tiles.tile_run(eyes, form="pairs", storage="exact", c_e=16, batch=b).block(far, wanted)[1][
            "rays"
        ]
        for b in (1, 10000)
    ]
    assert rays[1] <= rays[0]
