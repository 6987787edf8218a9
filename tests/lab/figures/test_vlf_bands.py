"""Numbers of the visibility field's paper are consistent and lie in the bands."""

from __future__ import annotations

import pytest

from viscache_lab.figures import vlf_printed as printed
from viscache_lab.figures.bands import vlf as bands


@pytest.mark.parametrize("scene", printed.OCCLUSION)
def test_speedups_of_table_1_are_ratios_of_its_seconds(scene: str) -> None:
    row = printed.OCCLUSION[scene]
    assert row.crt_s / row.field_s == pytest.approx(row.speedup, abs=0.0051)
    assert row.speedup in bands.OCCLUSION_SPEEDUP


def test_the_churchs_rays_per_second_follow_from_its_seconds() -> None:
    """So 513 rays were traced from every pixel."""
    rays = printed.OCCLUSION_PIXELS * printed.OCCLUSION_RAYS / 1e6
    church = printed.OCCLUSION["church"]
    assert rays / church.crt_s == pytest.approx(printed.CHURCH_CRT, abs=0.05)
    assert rays / church.field_s == pytest.approx(printed.CHURCH_FIELD, abs=0.05)


def test_the_papers_gain_falls_with_the_triangles() -> None:
    rows = printed.OCCLUSION
    assert rows["tugboat"].speedup / rows["cow"].speedup in bands.OCCLUSION_DECLINE
