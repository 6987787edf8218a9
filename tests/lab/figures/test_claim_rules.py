"""The interval of a claim follows from what the paper prints, by a rule that has a name."""

from __future__ import annotations

import re

import pytest

from lab.figures.every_band import all_bands
from viscache_lab.experiment import Band
from viscache_lab.experiment.claim_rules import RULES, Claim
from viscache_lab.figures import aqvc_bands, vismap_bands, vlf_bands

EVERY = {
    f"{bands.__name__.rpartition('.')[2]}.{name}": band
    for bands in (aqvc_bands, vlf_bands, vismap_bands)
    for name, band in all_bands(bands).items()
}
PLACE = re.compile(r"(Sec|Fig|Tab|Eq)\. [\d.]+")
#: Rules whose interval has nothing but the number that the paper prints.
OF_A_NUMBER = ("at_least", "at_most", "about", "exact")


def test_bands_that_quote_a_paper_have_a_rule_and_no_others() -> None:
    wrong = {
        name: band.source
        for name, band in EVERY.items()
        if bool(PLACE.match(band.source)) != (band.claimed is not None)
    }
    assert wrong == {}
    assert sum(band.claimed is not None for band in EVERY.values()) >= 75


def test_every_rule_is_known_and_used() -> None:
    used = {band.claimed.rule for band in EVERY.values() if band.claimed}
    assert used == set(RULES)


@pytest.mark.parametrize("name", [n for n, band in EVERY.items() if band.claimed])
def test_an_interval_is_the_one_of_its_rule(name: str) -> None:
    claimed = EVERY[name].claimed
    assert claimed is not None and claimed.low <= claimed.high
    assert bool(claimed.because) == (claimed.rule == "words")
    assert follows(claimed)


def follows(claim: Claim) -> bool:
    """Whether the rule gives this interval."""
    made = {
        "at_least": lambda: Claim.at_least(claim.low),
        "at_most": lambda: Claim.at_most(claim.high),
        "exact": lambda: Claim.exact(claim.low),
        "more": lambda: Claim.more(claim.low),
        "about": lambda: Claim.about(claim.low / 0.9, claim.high / 1.1),
        "computed": lambda: Claim.computed(claim.low, claim.high),
        "words": lambda: Claim.words(claim.low, claim.high, because=claim.because),
    }.get(claim.rule, lambda: getattr(Claim, claim.rule)())()
    return made.rule == claim.rule and (made.low, made.high) == pytest.approx(
        (claim.low, claim.high)
    )


def test_an_interval_of_another_rule_is_noticed() -> None:
    assert follows(Claim.nearly_none()) and not follows(Claim(0.0, 0.9, "nearly_none"))
    assert follows(Claim.at_least(3.0)) and not follows(Claim(3.0, 9.0, "at_least"))
    assert follows(Claim.none()) and not follows(Claim(0.0, 1.3, "none"))


def printed_numbers(source: str) -> list[float]:
    """Numbers of a quotation, without the place; powers of ten are written out."""
    said = PLACE.sub("", source.partition("; expected")[0]).replace("·10¹⁰", "e10").replace(",", "")
    said = re.sub(r"(\d)[–-](\d[\d.]*)(e10)", r"\1\3 \2\3", said)
    numbers = [float(n) for n in re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?:e10)?", said)]
    words = {"no other": 0.0, "only one": 1.0, "well below a few percent": 0.03}
    return numbers + [value for word, value in words.items() if word in said]


def of_the_quotation(band: Band) -> bool:
    """Whether the interval's number is one of the quotation, as it is or as percent."""
    claim, numbers = band.claimed, printed_numbers(band.source)
    assert claim is not None
    wanted = {
        "at_least": [claim.low],
        "exact": [claim.low],
        "at_most": [claim.high],
        "about": [claim.low / 0.9, claim.high / 1.1],
    }[claim.rule]
    known = numbers + [number / 100 for number in numbers] + [1 + n / 100 for n in numbers]
    return all(any(value == pytest.approx(n, rel=1e-3) for n in known) for value in wanted)


#: Numbers that are not in the quotation: what an identity gives.
IDENTITIES = {
    "aqvc_bands.SAMPLES_PER_CELL": 1.0,
    "aqvc_bands.CELLS_FOLLOW_FOOTPRINT": 1.0,
    "aqvc_bands.MIXED_NORMALS": 0.0,
    "aqvc_bands.LEAKING_CELLS[round]": 0.0,
    "aqvc_bands.LEAKING_CELLS[floor]": 0.0,
    "aqvc_bands.LEAKING_CELLS[octahedral]": 0.0,
    "aqvc_bands.HAIRBALL_RR": 50.0,
    "vlf_bands.WALKS_DIFFER": 0.0,
    "vismap_bands.PREVIEW_RAYS": 0.0,
}


@pytest.mark.parametrize(
    "name",
    [n for n, band in EVERY.items() if band.claimed and band.claimed.rule in OF_A_NUMBER],
)
def test_the_number_of_an_interval_is_in_the_quotation(name: str) -> None:
    assert of_the_quotation(EVERY[name]) or name in IDENTITIES


def test_a_number_that_the_paper_does_not_print_is_noticed() -> None:
    assert of_the_quotation(Band(0, 9, "Fig. 6: 3", claimed=Claim.at_least(3.0)))
    assert not of_the_quotation(Band(0, 9, "Fig. 6: 3", claimed=Claim.at_least(6.0)))
    assert not of_the_quotation(Band(0, 9, "Sec. 5.2: 32 %", claimed=Claim.about(0.52)))
    assert not of_the_quotation(Band(0, 9, "Sec. 5.2: no number", claimed=Claim.exact(5)))
