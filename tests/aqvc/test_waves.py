"""Level waves: Alg. 2 level by level for whole light groups."""

import numpy as np
import pytest

from aqvc import tiles
from reference import aqvc as reference
from viscache import _core

OPTIONS = [
    {"c_e": 8},
    {"c_e": 16},
    {"c_e": 16, "level_step": 2, "c_finest": 1},
    {"c_e": 40, "c_z": 8, "c_r": 1.5},
    {"c_e": 12, "tangent_neighbours": False, "normal_mode": "floor", "grid_offset": False},
    {"c_e": 6, "refinement": "off"},
    {"c_e": 2000},
    {"c_e": 12, "normal_mode": "octahedral"},
    {"c_e": 12, "normal_mode": "single"},
    {"c_e": 16, "grid_seed": 3, "level_step": 2},
    {"c_e": 12, "scale_free": True},
]


def grid_of(options):
    """The transcription's grids for the C++ parameters."""
    return reference.Grid(
        np.float32(tiles.CENTER),
        tiles.RADIUS,
        c_z=options.get("c_z", 4),
        c_r=options.get("c_r", 1.2),
        mode=options.get("normal_mode", "round"),
        offset=reference.offset(options.get("grid_seed", 0), options.get("grid_offset", True)),
        tangent=options.get("tangent_neighbours", True),
        scale_free=options.get("scale_free", False),
    )


def assert_transcribed(options, eyes, far, worth=None, **given):
    """Values, rays of every level and leftover rays of a run are the transcription's."""
    wanted = tiles.facing(eyes, far)
    run = tiles.tile_run(eyes, **options)
    exact, _ = run.block(far, wanted, exact=True)
    lift = {} if worth is None else {"lift": 2}
    levels = _core.aqvc.AqvcParameters(**options).level_list(far["group"], **lift)
    want = reference.waves(grid_of(options), eyes, levels, exact, wanted, worth)
    visible, counters = run.block(far, wanted, **given)
    np.testing.assert_array_equal(visible, want.visible)
    assert counters["rays_per_level"][: len(levels)] == want.rays_per_level
    assert counters["leftover_rays"] == want.leftover
    assert counters["rays"] == want.rays
    return run, wanted, visible, counters


@pytest.mark.parametrize("kind", ["point", "directional", "vpl"])
@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_waves_equal_their_transcription(kind, options):
    eyes, far = tiles.eye_points(), tiles.lights(kind, 12)
    _, wanted, _, counters = assert_transcribed(options, eyes, far)
    assert counters["rays"] < wanted.sum()


def test_waves_of_nearer_and_farther_eye_points_share_rows_between_levels():
    """Where levels coincide, one eye point's R does not change, its neighbour's does."""
    eyes = tiles.eye_points(16, 16)
    eyes["density"] *= np.geomspace(1e-6, 1, len(eyes["density"])).astype(np.float32)
    assert_transcribed({"c_e": 64, "level_step": 1.5}, eyes, tiles.lights("point", 6))


def test_a_block_wider_than_one_row_of_512_bits_equals_its_parts():
    eyes, far = tiles.eye_points(16, 16), tiles.lights("point", 700)
    wanted = tiles.facing(eyes, far)
    run = tiles.tile_run(eyes, c_e=10)
    whole = run.block(far, wanted)[0]
    for part in (slice(0, 5), slice(500, 520), slice(650, 700)):
        some = {k: v[part] if isinstance(v, np.ndarray) else v for k, v in far.items()}
        np.testing.assert_array_equal(run.block(some, wanted[:, part])[0], whole[:, part])
