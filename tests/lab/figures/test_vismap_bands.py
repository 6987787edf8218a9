"""Numbers of the visibility-map paper are consistent."""

from __future__ import annotations

import pytest

from viscache_lab.figures import vismap_printed as printed
from viscache_lab.figures.bands import vismap as bands


@pytest.mark.parametrize("scene", printed.CACHES)
def test_rays_per_pixel_of_table_2_follow_from_its_records(scene: str) -> None:
    cache = printed.CACHES[scene]
    rays = cache.records * cache.map_size**2 / 2
    assert cache.rays_per_pixel * printed.PIXELS / rays in bands.RAYS_OF_RECORDS
    whole_sphere = cache.rays_per_pixel * printed.PIXELS / (2 * rays)
    assert whole_sphere not in bands.RAYS_OF_RECORDS


@pytest.mark.parametrize("scene", printed.COSTS)
def test_overheads_of_table_3_are_differences_of_its_times(scene: str) -> None:
    for cost in printed.COSTS[scene]:
        assert cost.cache_s - cost.product_s == pytest.approx(cost.overhead_s, abs=0.051)
        percent = 100 * cost.overhead_s / cost.product_s
        assert cost.overhead_percent == pytest.approx(percent, abs=0.1), "rounded or cut"
    overheads = [cost.overhead_s for cost in printed.COSTS[scene]]
    assert max(overheads) / min(overheads) in bands.OVERHEAD_IS_CONSTANT


def test_the_papers_own_results_lie_in_the_bands() -> None:
    ratios = {
        scene: {cost.samples: cost.variance_ratio for cost in costs}
        for scene, costs in printed.COSTS.items()
    }
    assert ratios["garage"][10] in bands.GARAGE_CONTROL_VARIATE
    assert ratios["garden1"][300] in bands.GARDEN_ONE
    assert ratios["garden1"][300] not in bands.GARDEN_PREVIOUS_PASS
    for scene in ("garage", "dynamics"):
        assert ratios[scene][300] / ratios[scene][10] in bands.RQMC_RISES
        assert ratios[scene][300] / ratios[scene][10] not in bands.IID_IS_FLAT
    assert printed.EQUAL_TIME_RATIO in bands.EQUAL_TIME
    assert printed.AO_SECONDS / printed.AO_CACHE_SECONDS in bands.AO_TIME
    assert printed.RECORD_BYTES in bands.RECORD_BYTES
    megabytes = printed.CACHES["garage"].records * printed.RECORD_BYTES / 1e6
    assert megabytes == pytest.approx(printed.CACHE_MEGABYTES, abs=0.1)


def test_the_weighting_function_of_figure_5_has_the_values_of_its_bands() -> None:
    def weight(distance: float, theta_deg: float) -> float:
        return (1 - theta_deg / 180) * (1 - distance / (1 + printed.STEEPNESS * distance))

    assert weight(1, printed.THETA_MAX_DEG) in bands.LEAST_WEIGHT
    assert weight(1, 0) in bands.EDGE_WEIGHT
    assert weight(0, printed.THETA_MAX_DEG) in bands.EDGE_WEIGHT
    assert (weight(1e-4, 0) - 1) / 1e-4 in bands.FIRST_SLOPE
