"""Bit rows in pixel order, and the pairs they must equal."""

import numpy as np
import pytest

from aqvc import tiles
from aqvc.test_waves import OPTIONS, grid_of
from reference import aqvc as reference
from viscache import _core


@pytest.mark.parametrize("form", ["rows", "pairs"])
@pytest.mark.parametrize("kind", ["point", "directional", "vpl"])
@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_one_query_at_a_time_equals_the_transcription_of_algorithm_2(form, kind, options):
    """T3: values and rays of every level of rows and pairs with batch = 1."""
    eyes, far = tiles.eye_points(), tiles.lights(kind, 12)
    wanted = tiles.facing(eyes, far)
    run = tiles.tile_run(eyes, form=form, batch=1, storage="exact", **options)
    exact, _ = run.block(far, wanted, exact=True)
    levels = _core.aqvc.AqvcParameters(**options).level_list(far["group"])
    order, _ = run.pair_order()
    want = reference.alg2(grid_of(options), eyes, levels, exact, wanted, order)
    visible, counters = run.block(far, wanted)
    np.testing.assert_array_equal(visible, want.visible)
    assert counters["rays_per_level"][: len(levels)] == want.rays_per_level
    assert counters["rays"] == want.rays < wanted.sum()


@pytest.mark.parametrize("batch", [0, 1, 7, 64, 10000])
@pytest.mark.parametrize("order", ["hm", "scanline", "random"])
def test_rows_equal_pairs_of_the_same_batch(batch, order):
    """T15: `batched` storage and bit rows are one algorithm."""
    eyes, far = tiles.eye_points(), tiles.lights("point", 12)
    wanted = tiles.facing(eyes, far)
    automatic = {"batch": batch} if batch else {"batch": 256}
    rows = tiles.tile_run(eyes, form="rows", c_e=10, order=order, batch=batch)
    pairs = tiles.tile_run(eyes, form="pairs", storage="exact", c_e=10, order=order, **automatic)
    (v, c), (v2, c2) = rows.block(far, wanted), pairs.block(far, wanted)
    np.testing.assert_array_equal(v, v2)
    for name in ("rays_per_level", "lookups", "hits", "boundary_queries", "groups"):
        assert c[name] == c2[name]


def test_larger_batches_trace_fewer_refinement_rays():
    """Batch mates cannot trigger refinement in each other."""
    eyes, far = tiles.eye_points(), tiles.lights("point", 12)
    wanted = tiles.facing(eyes, far)
    rays = [
        tiles.tile_run(eyes, form="rows", c_e=16, batch=b).block(far, wanted)[1]["rays"]
        for b in (1, 10000)
    ]
    assert rays[1] <= rays[0]
