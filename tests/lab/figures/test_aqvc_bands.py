"""Numbers of the quantized cache's paper are consistent and lie in the bands."""

import pytest

from viscache_lab.figures import aqvc_printed as printed
from viscache_lab.figures.bands import aqvc as bands


def test_the_papers_speedups_are_its_ratios_and_lie_in_the_bands():
    implied = {name: scene.implied_speedup for name, scene in printed.SCENES.items()}
    rounded = {name: round(value, 1) for name, value in implied.items()}
    assert rounded == {
        "apartment": 4.8,
        "delta": 5.3,
        "conference": 2.4,
        "san miguel": 7.9,
        "hairball": 3.9,
    }
    assert max(implied.values()) == pytest.approx(printed.SPEEDUP, abs=0.15)
    assert max(implied.values()) in bands.LARGEST_SPEEDUP
    assert implied["conference"] / implied["apartment"] in bands.CONFERENCE_GAINS_LESS
    assert printed.HAIRBALL_SPEEDUP in bands.HAIRBALL_SPEEDUP
    assert implied["hairball"] in bands.HAIRBALL_SPEEDUP


def test_the_papers_other_numbers_lie_in_the_bands():
    assert printed.RAY_REDUCTION + 1 in bands.LARGEST_REDUCTION
    left = 1 / (printed.RAY_REDUCTION + 1)
    assert left < 0.02 and left in bands.H1_RAYS_LEFT
    share, bound = printed.CPU_SHADING_SHARE, printed.CPU_BOUND
    assert share * bound == pytest.approx(1, abs=0.05)
    assert printed.CPU_SHADING_SHARE in bands.H2_SHADING_SHARE
    assert printed.BIDIRECTIONAL_REDUCTION in bands.BIDIRECTIONAL_RR
    assert printed.MAPS_SLOWER in bands.MAPS_SLOWER
    assert printed.LARGER_TABLE in bands.H3_LARGE_TABLES


def test_the_prototypes_numbers_lie_in_the_bands():
    assert 0.0241 / 0.0092 in bands.REFINEMENT_GAIN["paper"]
    assert 107 / 32.8 in bands.REFINEMENT_COST
    assert 0.0159 / 0.0092 in bands.SCANLINE_HURTS_REFINEMENT
    assert 61 / 78 in bands.H6_REDUCTION["c_z"] and 84 / 62 in bands.H6_REDUCTION["c_r"]
    assert 1.0 not in bands.H8_FLICKER and 1.0 not in bands.REFINEMENT_GAIN["default"]
