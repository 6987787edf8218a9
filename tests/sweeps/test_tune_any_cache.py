"""`vc.tune` over any number of any cache: both directions, whole numbers, own oracles, refusals."""

import json
import math
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

import viscache as vc
from oracles.test_written import Grid
from viscache import cli
from viscache.sweeps.search import MOST_PILOTS, Span, best, search
from viscache.sweeps.tune import Pilot

SIZE = (96, 60)
WHITTED = vc.Whitted(n_vpls=32)


def error_of(scene, found, integrator=WHITTED, seed=7):
    exact = vc.render(scene, integrator, size=SIZE, seed=seed)
    frame = vc.render(
        scene, integrator, size=SIZE, seed=seed, visibility=found.visibility, use=found.use
    )
    return float(vc.metrics.compare(frame, exact, metrics=["rel_l1"])["rel_l1"])


POWERS = st.one_of(st.floats(0.4, 2.0), st.floats(-2.0, -0.4))


@given(
    power=POWERS, where=st.floats(0.05, 0.95), low=st.floats(0.01, 10), decades=st.floats(0.3, 3)
)
def test_the_search_finds_rising_and_falling_powers(power, where, low, decades):
    span = Span(low=low, high=low * 10**decades)
    wanted = span.along(span.low, span.high, where)
    tried = search(lambda v: Pilot(v, 0.02 * (v / wanted) ** power, 1.0), 0.02, span)
    assert best(tried, 0.02).error == pytest.approx(0.02, rel=0.05)
    assert len(tried) <= MOST_PILOTS
    assert all(span.low <= p.value <= span.high for p in tried)


@given(
    low=st.integers(-5, 40),
    steps=st.integers(1, 60),
    where=st.floats(0.0, 1.0),
    falls=st.booleans(),
)
def test_whole_numbers_are_tried_once_and_stay_in_range(low, steps, where, falls):
    span = Span(low=low, high=low + steps, whole=True)
    wanted = low + where * steps

    def error(value):
        away = (wanted - value if falls else value - wanted) / steps
        return 0.02 * 4**away

    tried = search(lambda v: Pilot(v, error(v), 1.0), 0.02, span)
    values = [p.value for p in tried]
    assert all(isinstance(v, int) and span.low <= v <= span.high for v in values)
    assert len(set(values)) == len(values) <= MOST_PILOTS
    found = best(tried, 0.02, whole=True)
    nearest = min(abs(math.log(error(v) / 0.02)) for v in range(low, low + steps + 1))
    assert abs(math.log(found.error / 0.02)) <= nearest + 2 * math.log(4) / steps + 0.04


def test_a_range_from_zero_is_walked_in_equal_steps_to_its_ends():
    span = Span(low=0, high=3)
    tried = search(lambda v: Pilot(v, 0.001 * (1 + v), 1.0), 0.5, span)
    assert [p.value for p in tried] == pytest.approx([1, 2, 2.5, 3])
    tried = search(lambda v: Pilot(v, 0.5 + v, 1.0), 0.01, span)
    assert [p.value for p in tried] == pytest.approx([1, 2, 0.5, 0])


def test_an_error_that_never_changes_is_looked_at_at_both_ends():
    tried = search(lambda v: Pilot(v, 0.1, 1.0), 0.02, Span(low=1, high=64))
    assert [p.value for p in tried] == pytest.approx([4, 16, 64, 1])
    late = search(lambda v: Pilot(v, 0.0 if v < 40 else v / 1000, 1.0), 0.05, Span(low=1, high=64))
    assert best(late, 0.05).error == pytest.approx(0.05, rel=0.05)


def test_of_whole_numbers_one_that_reaches_the_target_is_preferred():
    pilots = [Pilot(3, 0.004, 1.0), Pilot(4, 0.0132, 1.0)]
    assert best(pilots, 0.01, whole=True).value == 3
    assert best(pilots, 0.01).value == 4


def test_an_oracle_of_ones_own_is_tuned(room):
    """It does not work in parts of frames, so frames check it."""
    found = vc.tune(
        room,
        WHITTED,
        rel_l1_reflected=0.03,
        visibility=Grid(),
        parameter={"cell": (0.02, 2)},
        size=SIZE,
    )
    assert (found.parameter, found.samples) == ("cell", 24)
    assert found.visibility == Grid(cell=found.value) and 0.02 <= found.value <= 2
    assert found.outcome != "missed" and 0.03 / 1.3 < error_of(room, found) < 0.03 * 1.3
    assert found.pilots[0].error < found.pilots[-1].error  # it rises
    assert repr(found).startswith(f"Tuned(cell={found.value:.3g}, rel_l1_reflected=")
    assert "<th>cell</th>" in found._repr_html_()
    with pytest.raises(AttributeError, match="cell was searched, not c_e"):
        _ = found.c_e
    with pytest.raises(AttributeError, match="cell was searched, not c_e"):
        _ = found.pilots[0].c_e


def test_shadow_maps_and_the_share_of_a_correction(room):
    direct = vc.Direct()
    maps = vc.tune(
        room,
        direct,
        rel_l1_reflected=0.03,
        visibility="shadow_map",
        parameter={"resolution": (8, 128)},
        size=SIZE,
    )
    assert maps.outcome != "missed" and maps.visibility == vc.ShadowMap(resolution=int(maps.value))
    assert all(isinstance(p.value, int) for p in maps.pilots)
    assert maps.pilots[0].error > maps.pilots[-1].error  # it falls
    assert error_of(room, maps, direct) < 0.03 * 1.3
    share = vc.tune(
        room,
        WHITTED,
        rel_l1_reflected=0.03,
        visibility=vc.Aqvc(exact_groups=()),
        use=vc.Correct(),
        parameter={"use.share": (0.02, 1)},
        size=SIZE,
    )
    assert isinstance(share.visibility, vc.Aqvc) and share.use == vc.Correct(share=share.value)
    assert share.pilots[0].error > share.pilots[-1].error
    assert share.outcome != "missed"


@dataclass(frozen=True)
class TwoNumbers(Grid):
    levels: int = 3
    name: str = "grid"


class NoFields:
    def block(self, eyes, lamps, wanted):
        return eyes.trace(lamps, wanted)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (
            {"visibility": Grid(), "parameter": "cel"},
            "no parameter 'cel'; did you mean 'cell'",
        ),
        ({"parameter": "c_ee"}, "no parameter 'c_ee'; did you mean 'c_e'"),
        ({"use": vc.Correct(), "parameter": "share"}, "did you mean 'use.share'"),
        (
            {"visibility": Grid()},
            r"parameter must be \{name: \(low, high\)\}, two numbers .* got None",
        ),
        ({"visibility": TwoNumbers()}, "parameter must be one of cell, levels, got None"),
        (
            {"visibility": TwoNumbers(), "parameter": "name"},
            "parameter must be a number: one of cell, levels, got 'name'",
        ),
        ({"visibility": NoFields()}, "must have a parameter that is a number"),
        ({"visibility": 3}, "visibility must be vc.Exact"),
        ({"parameter": "preset"}, "parameter must be a number: one of c_e, c_l"),
        ({"parameter": 3}, "parameter must be a name, got 3"),
        ({"parameter": {"c_e": (1, 2), "c_n": (1, 2)}}, "parameter must have one name"),
        ({"parameter": {"c_e": (4, 4)}}, "with low < high"),
        ({"parameter": {"c_e": (1, math.inf)}}, "with low < high"),
        ({"parameter": {"c_e": "ab"}}, "parameter must be"),
        ({"parameter": {"c_e": (-1, 4)}}, "c_e must be"),
        ({"parameter": {"c_n": (1.5, 4)}}, "two whole numbers with low < high"),
        ({"use": "repair"}, "use must be"),
        ({"use": vc.Correct(), "parameter": {"use.share": (0.1, 2)}}, r"share must be in \(0, 1\]"),
    ],
)
def test_what_cannot_be_searched_is_refused(arguments, says):
    with pytest.raises(ValueError, match=says):
        vc.tune("slits", "direct", **arguments)


def test_what_does_not_combine_is_refused_before_a_frame_is_rendered():
    product = vc.Direct(environment="product")
    with pytest.raises(ValueError, match='with environment="product"'):
        vc.tune("slits", product, visibility=Grid(), parameter={"cell": (0.1, 1)})


def test_the_command_searches_any_number(capsys):
    words = ["tune", "room?triangles=2000", "--integrator", "direct", "--size", "64x40"]
    maps = ["--visibility", "shadow_map", "--parameter", "resolution", "--between", "8", "128"]
    assert cli.main([*words, *maps, "--target", "rel_l1<=0.03", "--json"]) == 0
    got = json.loads(capsys.readouterr().out)
    assert got["parameter"] == "resolution" and isinstance(got["resolution"], int)
    assert got["target"] == 0.03 and got["rel_l1"] <= 0.039
    assert cli.main([*words, *maps, "--error", "0.03"]) == 0
    assert "resolution" in capsys.readouterr().out
    assert cli.main([*words, "--visibility", "shadow_map"]) == 2
    assert "parameter must be one of resolution, bias" in capsys.readouterr().err
    assert cli.main([*words, "--target", "rmse<=0.03"]) == 2
    assert "or seconds<=NUMBER, got" in capsys.readouterr().err
