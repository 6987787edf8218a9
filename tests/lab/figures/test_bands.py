"""Bands name their source, and the numbers that the papers print are consistent and in them."""

from __future__ import annotations

import math
from types import ModuleType

import pytest

from lab.figures.every_band import all_bands
from viscache_lab.figures import (
    aqvc_bands,
    aqvc_printed,
    trade_bands,
    vismap_bands,
    vismap_printed,
    vlf_bands,
    vlf_printed,
)

SOURCES = ("Eq. ", "Fig. ", "Sec. ", "Tab. ", "expected: ")


@pytest.mark.parametrize(
    ("bands", "some"),
    [
        (aqvc_bands, {"SAMPLES_PER_CELL", "REFINEMENT_GAIN[paper]", "H8_FLICKER"}),
        (vlf_bands, {"OCCLUSION_SPEEDUP", "CHORD_TILES[513]", "UPDATE_PAYS"}),
        (trade_bands, {"GAIN[room]", "NEVER_WORSE", "UNBIASED"}),
        (vismap_bands, {"GARAGE_GUIDED[10]", "GARAGE_GUIDED[30]", "LEAST_WEIGHT"}),
    ],
)
def test_bands_are_not_empty_and_name_their_source(bands: ModuleType, some: set[str]) -> None:
    assert some <= set(all_bands(bands))
    for name, band in all_bands(bands).items():
        assert band.low <= band.high, name
        assert math.isfinite(band.low) or math.isfinite(band.high), name
        assert band.source.startswith(SOURCES), name


def test_the_papers_speedups_are_its_ratios_and_lie_in_the_bands() -> None:
    implied = {name: scene.implied_speedup for name, scene in aqvc_printed.SCENES.items()}
    rounded = {name: round(value, 1) for name, value in implied.items()}
    assert rounded == {
        "apartment": 4.8,
        "delta": 5.3,
        "conference": 2.4,
        "san miguel": 7.9,
        "hairball": 3.9,
    }
    assert max(implied.values()) == pytest.approx(aqvc_printed.SPEEDUP, abs=0.15)
    assert max(implied.values()) in aqvc_bands.LARGEST_SPEEDUP
    assert implied["conference"] / implied["apartment"] in aqvc_bands.CONFERENCE_GAINS_LESS
    assert aqvc_printed.HAIRBALL_SPEEDUP in aqvc_bands.HAIRBALL_SPEEDUP
    assert implied["hairball"] in aqvc_bands.HAIRBALL_SPEEDUP


def test_the_papers_other_numbers_lie_in_the_bands() -> None:
    assert aqvc_printed.RAY_REDUCTION + 1 in aqvc_bands.LARGEST_REDUCTION
    left = 1 / (aqvc_printed.RAY_REDUCTION + 1)
    assert left < 0.02 and left in aqvc_bands.H1_RAYS_LEFT
    share, bound = aqvc_printed.CPU_SHADING_SHARE, aqvc_printed.CPU_BOUND
    assert share * bound == pytest.approx(1, abs=0.05)
    assert aqvc_printed.CPU_SHADING_SHARE in aqvc_bands.H2_SHADING_SHARE
    assert aqvc_printed.BIDIRECTIONAL_REDUCTION in aqvc_bands.BIDIRECTIONAL_RR
    assert aqvc_printed.MAPS_SLOWER in aqvc_bands.MAPS_SLOWER
    assert aqvc_printed.LARGER_TABLE in aqvc_bands.H3_LARGE_TABLES


def test_the_prototypes_numbers_lie_in_the_bands() -> None:
    assert 0.0241 / 0.0092 in aqvc_bands.REFINEMENT_GAIN["paper"]
    assert 107 / 32.8 in aqvc_bands.REFINEMENT_COST
    assert 0.0159 / 0.0092 in aqvc_bands.SCANLINE_HURTS_REFINEMENT
    assert 61 / 78 in aqvc_bands.H6_REDUCTION["c_z"] and 84 / 62 in aqvc_bands.H6_REDUCTION["c_r"]
    assert 1.0 not in aqvc_bands.H8_FLICKER and 1.0 not in aqvc_bands.REFINEMENT_GAIN["default"]


@pytest.mark.parametrize("scene", vismap_printed.CACHES)
def test_rays_per_pixel_of_table_2_follow_from_its_records(scene: str) -> None:
    cache = vismap_printed.CACHES[scene]
    rays = cache.records * cache.map_size**2 / 2
    assert cache.rays_per_pixel * vismap_printed.PIXELS / rays in vismap_bands.RAYS_OF_RECORDS
    whole_sphere = cache.rays_per_pixel * vismap_printed.PIXELS / (2 * rays)
    assert whole_sphere not in vismap_bands.RAYS_OF_RECORDS


@pytest.mark.parametrize("scene", vismap_printed.COSTS)
def test_overheads_of_table_3_are_differences_of_its_times(scene: str) -> None:
    for cost in vismap_printed.COSTS[scene]:
        assert cost.cache_s - cost.product_s == pytest.approx(cost.overhead_s, abs=0.051)
        percent = 100 * cost.overhead_s / cost.product_s
        assert cost.overhead_percent == pytest.approx(percent, abs=0.1), "rounded or cut"
    overheads = [cost.overhead_s for cost in vismap_printed.COSTS[scene]]
    assert max(overheads) / min(overheads) in vismap_bands.OVERHEAD_IS_CONSTANT


def test_the_papers_own_results_lie_in_the_bands() -> None:
    ratios = {
        scene: {cost.samples: cost.variance_ratio for cost in costs}
        for scene, costs in vismap_printed.COSTS.items()
    }
    assert ratios["garage"][10] in vismap_bands.GARAGE_CONTROL_VARIATE
    assert ratios["garden1"][300] in vismap_bands.GARDEN_ONE
    assert ratios["garden1"][300] not in vismap_bands.GARDEN_PREVIOUS_PASS
    for scene in ("garage", "dynamics"):
        assert ratios[scene][300] / ratios[scene][10] in vismap_bands.RQMC_RISES
        assert ratios[scene][300] / ratios[scene][10] not in vismap_bands.IID_IS_FLAT
    assert vismap_printed.EQUAL_TIME_RATIO in vismap_bands.EQUAL_TIME
    assert vismap_printed.AO_SECONDS / vismap_printed.AO_CACHE_SECONDS in vismap_bands.AO_TIME
    assert vismap_printed.RECORD_BYTES in vismap_bands.RECORD_BYTES
    megabytes = vismap_printed.CACHES["garage"].records * vismap_printed.RECORD_BYTES / 1e6
    assert megabytes == pytest.approx(vismap_printed.CACHE_MEGABYTES, abs=0.1)


def test_the_weighting_function_of_figure_5_has_the_values_of_its_bands() -> None:
    def weight(distance: float, theta_deg: float) -> float:
        return (1 - theta_deg / 180) * (1 - distance / (1 + vismap_printed.STEEPNESS * distance))

    assert weight(1, vismap_printed.THETA_MAX_DEG) in vismap_bands.LEAST_WEIGHT
    assert weight(1, 0) in vismap_bands.EDGE_WEIGHT
    assert weight(0, vismap_printed.THETA_MAX_DEG) in vismap_bands.EDGE_WEIGHT
    assert (weight(1e-4, 0) - 1) / 1e-4 in vismap_bands.FIRST_SLOPE


@pytest.mark.parametrize("scene", vlf_printed.OCCLUSION)
def test_speedups_of_table_1_are_ratios_of_its_seconds(scene: str) -> None:
    row = vlf_printed.OCCLUSION[scene]
    assert row.crt_s / row.field_s == pytest.approx(row.speedup, abs=0.0051)
    assert row.speedup in vlf_bands.OCCLUSION_SPEEDUP


def test_the_churchs_rays_per_second_follow_from_its_seconds() -> None:
    """So 513 rays were traced from every pixel."""
    rays = vlf_printed.OCCLUSION_PIXELS * vlf_printed.OCCLUSION_RAYS / 1e6
    church = vlf_printed.OCCLUSION["church"]
    assert rays / church.crt_s == pytest.approx(vlf_printed.CHURCH_CRT, abs=0.05)
    assert rays / church.field_s == pytest.approx(vlf_printed.CHURCH_FIELD, abs=0.05)


def test_the_papers_gain_falls_with_the_triangles() -> None:
    rows = vlf_printed.OCCLUSION
    assert rows["tugboat"].speedup / rows["cow"].speedup in vlf_bands.OCCLUSION_DECLINE
