"""Counters are one list: frames have its names, the help its texts, and parts add up."""

import inspect

import pytest

import viscache as vc
from viscache import _core

ROWS = _core.counter_rows()
#: What frames have beside the rows: sums, quotients, and what sources and the frame itself report.
BESIDE = {
    *("queries", "occluded", "rays", "ray_reduction", "occupancy", "vpls", "sha256", "audit"),
    *("non_finite_pixels", "pilot_alpha", "pilot_variance_ratio", "pilot_guided"),
    *("records", "records_inserted", "records_rays", "shadow_map_rays", "tile_sums"),
    *("discarded", "learning_rays", "voxel_bytes", "pairs_tested"),
}
FRAMES = {
    "waves": {"visibility": vc.Aqvc(c_e=8)},
    "pairs": {"visibility": vc.Aqvc(preset="paper", c_e=8)},
    "corrected": {"visibility": vc.Aqvc(c_e=8, exact_groups=()), "use": "correct"},
    "bdpt": {"integrator": vc.Bdpt(max_depth=3), "visibility": vc.Aqvc(c_e=8)},
    "maps": {"visibility": vc.VisMaps(n_startup=50), "env": 1.0},
    "kept": {"visibility": vc.Aqvc(c_e=8), "keep": vc.AqvcTable(table_bytes=1 << 16, check=0.5)},
}


@pytest.mark.parametrize("name", FRAMES)
def test_every_counter_of_a_frame_has_a_row(name):
    options = {"integrator": vc.Direct()} | FRAMES[name]
    integrator = options.pop("integrator")
    frame = vc.render("cube_on_plane", integrator, size=(16, 12), **options)
    assert set(frame.counters) - set(ROWS) <= BESIDE
    shown = {"camera_rays", "light_rays", "lookups", "cells", "non_finite", "groups"}
    assert shown <= set(frame.counters)
    assert ("product_points" in frame.counters) == (name == "maps")
    assert ("table_occupied" in frame.counters) == (name in ("bdpt", "kept"))
    assert ("reused_kept" in frame.counters) == (name == "kept")
    for counter in ("share_by_class", "corrections"):
        assert (counter in frame.counters) == (name == "corrected")


def test_the_help_of_frames_lists_every_counter():
    page = inspect.getdoc(vc.Frame) or ""
    for name, doc in ROWS.items():
        assert f'"{name}"\n' in page and " ".join(doc.split()[:4]) in page
