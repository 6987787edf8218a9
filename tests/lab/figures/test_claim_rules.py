"""The interval of a claim follows from what the paper prints, by a rule that has a name.

The numbers of the papers are consistent.
"""

import math
import re

import pytest

from lab.figures.test_bands import EVERY
from viscache_lab.experiment import Band
from viscache_lab.experiment.claim_rules import RULES, Claim
from viscache_lab.figures import aqvc_printed as quantized
from viscache_lab.figures import vismap_printed as maps
from viscache_lab.figures import vlf_printed as field
from viscache_lab.figures.bands import aqvc, vismap, vlf

PLACE = re.compile(r"(Sec|Fig|Tab|Eq)\. [\d.]+")
#: Rules whose interval has nothing but the number that the paper prints.
OF_A_NUMBER = ("at_least", "at_most", "about", "exact")


def test_bands_that_quote_a_paper_have_a_rule_and_no_others():
    wrong = {
        name: band.source
        for name, band in EVERY.items()
        if bool(PLACE.match(band.source)) != (band.claimed is not None)
    }
    assert wrong == {}
    assert sum(band.claimed is not None for band in EVERY.values()) >= 75


def test_every_rule_is_known_and_used():
    used = {band.claimed.rule for band in EVERY.values() if band.claimed}
    assert used == set(RULES)


@pytest.mark.parametrize("name", [n for n, band in EVERY.items() if band.claimed])
def test_an_interval_is_the_one_of_its_rule(name):
    claimed = EVERY[name].claimed
    assert claimed is not None and claimed.low <= claimed.high
    assert bool(claimed.because) == (claimed.rule == "words")
    assert follows(claimed)


def follows(claim):
    """Whether the rule gives this interval."""
    numbers = {
        **dict.fromkeys(("at_least", "exact", "more"), (claim.low,)),
        **dict.fromkeys(("computed", "words"), (claim.low, claim.high)),
        "at_most": (claim.high,),
        "about": (claim.low / 0.9, claim.high / 1.1),
    }.get(claim.rule, ())
    made = Claim.by(claim.rule, *numbers, because=claim.because)
    return made.rule == claim.rule and (made.low, made.high) == pytest.approx(
        (claim.low, claim.high)
    )


def test_an_interval_of_another_rule_is_noticed():
    assert follows(Claim.by("nearly_none")) and not follows(Claim(0.0, 0.9, "nearly_none"))
    assert follows(Claim.by("at_least", 3.0)) and not follows(Claim(3.0, 9.0, "at_least"))
    assert follows(Claim.by("none")) and not follows(Claim(0.0, 1.3, "none"))


def printed_numbers(source):
    """Numbers of a quotation, without the place; powers of ten are written out."""
    said = PLACE.sub("", source.partition("; expected")[0]).replace("·10¹⁰", "e10").replace(",", "")
    said = re.sub(r"(\d)[–-](\d[\d.]*)(e10)", r"\1\3 \2\3", said)
    numbers = [float(n) for n in re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?:e10)?", said)]
    words = {"no other": 0.0, "only one": 1.0, "well below a few percent": 0.03}
    return numbers + [value for word, value in words.items() if word in said]


def of_the_quotation(band):
    """Whether the interval's number is one of the quotation, as it is or as percent."""
    claim, numbers = band.claimed, printed_numbers(band.source)
    about = [claim.low / 0.9, claim.high / 1.1]
    wanted = {"at_most": [claim.high], "about": about}.get(claim.rule, [claim.low])
    known = numbers + [number / 100 for number in numbers] + [1 + n / 100 for n in numbers]
    return all(any(value == pytest.approx(n, rel=1e-3) for n in known) for value in wanted)


#: Numbers that are not in the quotation: what an identity gives.
IDENTITIES = {
    "aqvc.SAMPLES_PER_CELL": 1.0,
    "aqvc.CELLS_FOLLOW_FOOTPRINT": 1.0,
    "aqvc.MIXED_NORMALS": 0.0,
    "aqvc.LEAKING_CELLS[round]": 0.0,
    "aqvc.LEAKING_CELLS[floor]": 0.0,
    "aqvc.LEAKING_CELLS[octahedral]": 0.0,
    "aqvc.HAIRBALL_RR": 50.0,
    "vlf.WALKS_DIFFER": 0.0,
    "vismap.PREVIEW_RAYS": 0.0,
}


@pytest.mark.parametrize(
    "name", [n for n, band in EVERY.items() if band.claimed and band.claimed.rule in OF_A_NUMBER]
)
def test_the_number_of_an_interval_is_in_the_quotation(name):
    assert of_the_quotation(EVERY[name]) or name in IDENTITIES


def test_a_number_that_the_paper_does_not_print_is_noticed():
    assert of_the_quotation(Band(0, 9, "Fig. 6: 3", claimed=Claim.by("at_least", 3.0)))
    assert not of_the_quotation(Band(0, 9, "Fig. 6: 3", claimed=Claim.by("at_least", 6.0)))
    assert not of_the_quotation(Band(0, 9, "Sec. 5.2: 32 %", claimed=Claim.by("about", 0.52)))
    assert not of_the_quotation(Band(0, 9, "Sec. 5.2: no number", claimed=Claim.by("exact", 5)))


def test_printed_numbers_lie_where_their_claims_are_found():
    def found(band, value):
        claim = band.claim
        inside = claim[0] <= value <= claim[1] or math.isclose(value, claim[0], rel_tol=1e-6)
        assert inside == (value in band) or band is vismap.AO_RAYS  # ours is above 57.9
        return inside

    ratios = {scene: [c.variance_ratio for c in costs] for scene, costs in maps.COSTS.items()}
    assert found(vismap.GARAGE_CONTROL_VARIATE, ratios["garage"][0])
    assert found(vismap.EQUAL_SAMPLES, ratios["garage"][-1])
    assert found(vismap.GARDEN_ONE, ratios["garden1"][-1])
    assert not found(vismap.GARDEN_PREVIOUS_PASS, ratios["garden1"][-1])
    assert found(vismap.EQUAL_TIME, maps.EQUAL_TIME_RATIO)
    assert found(vismap.AO_TIME, maps.AO_SECONDS / maps.AO_CACHE_SECONDS)
    assert found(vismap.AO_RAYS, maps.AO_RAYS / maps.AO_CACHE_RAYS)
    assert found(vismap.RECORD_BYTES, maps.RECORD_BYTES)
    for costs in maps.COSTS.values():
        overheads = [cost.overhead_s for cost in costs]
        ratio = round(max(overheads) / min(overheads), 2)
        assert found(vismap.OVERHEAD_IS_CONSTANT, ratio)
    speedups = {name: row.speedup for name, row in field.OCCLUSION.items()}
    assert all(found(vlf.OCCLUSION_SPEEDUP, value) for value in speedups.values())
    assert found(vlf.OCCLUSION_DECLINE, speedups["tugboat"] / speedups["cow"])
    assert found(vlf.CLASSROOM_TRIANGLES, field.CLASSROOM_TRIANGLES)


@pytest.mark.parametrize("scene", field.OCCLUSION)
def test_speedups_of_table_1_are_ratios_of_its_seconds(scene):
    row = field.OCCLUSION[scene]
    assert row.crt_s / row.field_s == pytest.approx(row.speedup, abs=0.0051)


def test_the_churchs_rays_per_second_follow_from_its_seconds():
    """So 513 rays were traced from every pixel."""
    rays = field.OCCLUSION_PIXELS * field.OCCLUSION_RAYS / 1e6
    church = field.OCCLUSION["church"]
    assert rays / church.crt_s == pytest.approx(field.CHURCH_CRT, abs=0.05)
    assert rays / church.field_s == pytest.approx(field.CHURCH_FIELD, abs=0.05)


@pytest.mark.parametrize("scene", maps.CACHES)
def test_rays_per_pixel_of_table_2_follow_from_its_records(scene):
    cache = maps.CACHES[scene]
    rays = cache.records * cache.map_size**2 / 2
    assert cache.rays_per_pixel * maps.PIXELS / rays in vismap.RAYS_OF_RECORDS
    whole_sphere = cache.rays_per_pixel * maps.PIXELS / (2 * rays)
    assert whole_sphere not in vismap.RAYS_OF_RECORDS


@pytest.mark.parametrize("scene", maps.COSTS)
def test_overheads_of_table_3_are_differences_of_its_times(scene):
    for cost in maps.COSTS[scene]:
        assert cost.cache_s - cost.product_s == pytest.approx(cost.overhead_s, abs=0.051)
        percent = 100 * cost.overhead_s / cost.product_s
        assert cost.overhead_percent == pytest.approx(percent, abs=0.1), "rounded or cut"


def test_the_maps_own_results_lie_in_the_bands():
    for scene in ("garage", "dynamics"):
        ratios = {cost.samples: cost.variance_ratio for cost in maps.COSTS[scene]}
        assert ratios[300] / ratios[10] in vismap.RQMC_RISES
        assert ratios[300] / ratios[10] not in vismap.IID_IS_FLAT
    megabytes = maps.CACHES["garage"].records * maps.RECORD_BYTES / 1e6
    assert megabytes == pytest.approx(maps.CACHE_MEGABYTES, abs=0.1)


def test_the_weighting_function_of_figure_5_has_the_values_of_its_bands():
    def weight(distance, theta_deg):
        return (1 - theta_deg / 180) * (1 - distance / (1 + maps.STEEPNESS * distance))

    assert weight(1, maps.THETA_MAX_DEG) in vismap.LEAST_WEIGHT
    assert weight(1, 0) in vismap.EDGE_WEIGHT
    assert weight(0, maps.THETA_MAX_DEG) in vismap.EDGE_WEIGHT
    assert (weight(1e-4, 0) - 1) / 1e-4 in vismap.FIRST_SLOPE


def test_the_quantized_caches_speedups_are_its_ratios_and_lie_in_the_bands():
    implied = {name: scene.implied_speedup for name, scene in quantized.SCENES.items()}
    known = {"apartment": 4.8, "delta": 5.3, "conference": 2.4, "san miguel": 7.9, "hairball": 3.9}
    assert {name: round(value, 1) for name, value in implied.items()} == known
    assert max(implied.values()) == pytest.approx(quantized.SPEEDUP, abs=0.15)
    share, bound = quantized.CPU_SHADING_SHARE, quantized.CPU_BOUND
    assert share * bound == pytest.approx(1, abs=0.05)
    left = 1 / (quantized.RAY_REDUCTION + 1)
    assert left < 0.02
    for value, band in (
        (max(implied.values()), aqvc.LARGEST_SPEEDUP),
        (implied["conference"] / implied["apartment"], aqvc.CONFERENCE_GAINS_LESS),
        (quantized.HAIRBALL_SPEEDUP, aqvc.HAIRBALL_SPEEDUP),
        (implied["hairball"], aqvc.HAIRBALL_SPEEDUP),
        (quantized.RAY_REDUCTION + 1, aqvc.LARGEST_REDUCTION),
        (left, aqvc.H1_RAYS_LEFT),
        (share, aqvc.H2_SHADING_SHARE),
        (quantized.BIDIRECTIONAL_REDUCTION, aqvc.BIDIRECTIONAL_RR),
        (quantized.MAPS_SLOWER, aqvc.MAPS_SLOWER),
        (quantized.LARGER_TABLE, aqvc.H3_LARGE_TABLES),
        # Of the prototype
        (0.0241 / 0.0092, aqvc.REFINEMENT_GAIN["paper"]),
        (107 / 32.8, aqvc.REFINEMENT_COST),
        (0.0159 / 0.0092, aqvc.SCANLINE_HURTS_REFINEMENT),
        (61 / 78, aqvc.H6_REDUCTION["c_z"]),
        (84 / 62, aqvc.H6_REDUCTION["c_r"]),
    ):
        assert value in band, band.source
    assert 1.0 not in aqvc.H8_FLICKER and 1.0 not in aqvc.REFINEMENT_GAIN["default"]
