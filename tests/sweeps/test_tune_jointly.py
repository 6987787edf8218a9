"""`vc.tune` over several parameters, by FLIP, by time and over passes."""

import dataclasses
import json
import math

import numpy as np
import pytest

import viscache as vc
from viscache import cli
from viscache.frame.emitted_light import light_on_surfaces
from viscache.settings.not_given import NotGiven
from viscache.sweeps.jointly import EACH, MOST_MORE, families, jointly
from viscache.sweeps.search import search
from viscache.sweeps.searched import C_E
from viscache.sweeps.tune import Pilot, Tuned

SIZE = (96, 60)
WHITTED = vc.Whitted(n_vpls=64)


def modelled(best):
    """A cache in which one family needs half of the rays at each error."""
    made = []

    def measure(value, also=None):
        also = dict(also or {})
        key = (also.get("c_finest", 4.0), also.get("bright", 0.0))
        error = 0.004 * value**0.7 * (key[0] / 4) ** 0.5 * (0.8 if key[1] else 1)
        rays = 0.4 * (0.01 / error) ** 0.8 * (0.5 if key == best else 1.0)
        made.append(Pilot(value, error, 1 / rays, "c_e", also))
        return made[-1]

    return measure, made


@pytest.mark.parametrize("best", [(4.0, 0.0), (4.0, 4.0), (2.0, 0.0), (2.0, 4.0), (1.0, 4.0)])
def test_the_family_with_the_fewest_rays_is_found_at_the_target(best):
    measure, made = modelled(best)
    tried = search(measure, 0.02, C_E)
    before = len(made)

    def others(**beside):
        return families(vc.Aqvc(), **beside)

    pilots, one = jointly(measure, tried, 0.02, C_E, others, lambda p: 1 / p.ray_reduction)
    found = (one.also.get("c_finest", 4.0), one.also.get("bright", 0.0))
    if best != (1.0, 4.0):  # it is looked at only beside a family with smaller cells
        assert found == best
    assert one.error == pytest.approx(0.02, rel=0.05) and one in pilots
    assert len(made) - before <= MOST_MORE and len(pilots) == len(made)
    assert EACH < MOST_MORE


def test_an_error_that_c_e_cannot_reach_is_not_searched_further():
    measure, made = modelled((2.0, 4.0))
    tried = search(measure, 1e-5, C_E)
    pilots, one = jointly(measure, tried, 1e-5, C_E, lambda **_: [{}], lambda p: 1.0)
    assert pilots == tried == made and one.value == C_E.low


def test_values_that_were_given_stay():
    assert [f["bright"] for f in families(vc.Aqvc(bright=6))] == [6]
    assert all(f["c_finest"] == 3 for f in families(vc.Aqvc(c_finest=3)))
    assert families(vc.Aqvc(c_finest=3, bright=6)) == []
    beside = {"c_finest": 4.0, "bright": 4.0}
    assert families(vc.Aqvc(), beside=beside, c_e=6) == []
    assert {"c_finest": 8.0, "bright": 0.0} in families(vc.Aqvc(), c_e=17)
    assert families(vc.Aqvc(), beside=beside, c_e=9) == [{"c_finest": 8.0, "bright": 4.0}]


def test_three_parameters_are_tuned_and_take_no_more_rays_than_one(room):
    given = {"rel_l1_reflected": 0.02, "size": (112, 70)}
    conference = vc.scenes.conference(triangles=20_000)
    found = vc.tune(conference, WHITTED, **given)
    alone = vc.tune(conference, WHITTED, parameter="c_e", **given)
    again = vc.tune(conference, WHITTED, threads=1, **given)
    assert "missed" not in (found.outcome, alone.outcome) and not alone.also
    assert found.visibility.c_finest == found.also.get("c_finest", 4)
    assert found.ray_reduction > 0.95 * alone.ray_reduction
    assert len(found.pilots) > len(alone.pilots)
    assert (again.value, again.also, again.error) == (found.value, found.also, found.error)
    assert found.as_dict()["c_e"] == found.c_e
    kept = vc.tune(room, WHITTED, rel_l1_reflected=0.02, size=SIZE, visibility=vc.Aqvc(c_finest=3))
    assert kept.visibility.c_finest == 3
    hashed = vc.Aqvc(paper=vc.PaperForm(form="pairs"))
    assert isinstance(
        vc.tune(
            room, vc.Direct(), rel_l1_reflected=0.05, size=(48, 30), visibility=hashed
        ).visibility.bright,
        NotGiven,
    )


def test_a_reached_target_is_confirmed_by_the_interval():
    def one(error, low):
        return Tuned(
            target=0.01, parameter="c_e", value=8.0, visibility=vc.Aqvc(c_e=8), rel_l1=error,
            rel_l1_reflected=error, interval=(low, 2 * error - low), ray_reduction=5.0,
            pilots=(Pilot(8.0, 0.01, 5.0),), samples=24, groups={}, seconds=1, seconds_exact=2,
        )  # fmt: skip

    assert one(0.012, 0.0099).outcome == one(0.0099, 0.0097).outcome == "within noise"
    assert one(0.012, 0.0101).outcome == one(0.0131, 0.005).outcome == "missed"
    assert one(0.0098, 0.0096).reached
    assert "is not confirmed" in one(0.012, 0.0101).message
    assert one(0.005, 0.004).reached and not one(0.0131, 0.005).reached


def test_flip_is_judged_on_the_frame_itself(room):
    found = vc.tune(room, WHITTED, flip=0.03, size=SIZE, seed=3)
    exact = vc.render(room, WHITTED, size=SIZE, seed=3)
    frame = vc.render(room, WHITTED, visibility=found.visibility, size=SIZE, seed=3)
    flip = vc.metrics.compare(frame, exact, metrics=["flip"])["flip"]
    assert found.metric == "flip" and found.error == found.flip == pytest.approx(flip, rel=1e-5)
    assert found.interval[0] < flip < found.interval[1] and found.samples > 10
    assert found.outcome != "missed" and 0.03 / 1.3 < flip < 0.03 * 1.3
    assert "flip=" in repr(found) and found.as_dict()["metric"] == "flip"


def test_a_time_gives_an_exact_frame_where_it_fits_and_else_a_cached_one(room):
    long = vc.tune(room, WHITTED, seconds=600, size=SIZE)
    assert long.is_exact and long.error == 0 and long.reached and "which fits" in long.message
    assert repr(long).startswith("Tuned(exact,") and "target=600 s" in repr(long)
    short = vc.tune(room, WHITTED, seconds=1e-4, size=SIZE)
    assert not short.is_exact and not short.reached and short.wanted == "seconds"
    assert "No C_E that was tried takes 0.0001 s" in short.message


def test_passes_have_the_error_that_was_asked_for(room):
    size = (48, 30)

    def light(integrator, passes, **given):
        picture = vc.Progressive(room, integrator, size=size, **given).passes(passes)
        return np.asarray(light_on_surfaces(picture), float)

    def error(found):
        mine = light(found.integrator, found.passes, visibility=found.visibility, use=found.use)
        return float(np.abs(mine - truth).sum() / truth.sum())

    truth = light(WHITTED, 128, visibility="exact", first_pass=1 << 12)
    found = vc.tune(room, WHITTED, rel_l1_reflected=0.03, passes=True, size=size)
    assert found.passes == found.value and found.parameter == "passes"
    assert found.outcome != "missed"
    assert [p.also for p in found.pilots] == [{}, {}, {"pick": 16}, {"pick": 64}]
    assert f"{found.passes} passes" in repr(found)
    assert 0.03 / 1.6 < error(found) < 0.03 * 1.3
    again = vc.tune(room, WHITTED, rel_l1_reflected=0.03, passes=True, size=size, threads=1)
    assert (again.passes, again.is_exact) == (found.passes, found.is_exact)
    timed = vc.tune(room, WHITTED, seconds=1, passes=True, size=size)
    assert timed.wanted == "seconds" and timed.passes is not None and timed.passes >= 1


def test_picks_that_were_given_stay(room):
    few = vc.Whitted(n_vpls=64, pick=5)
    found = vc.tune(room, few, rel_l1_reflected=0.2, passes=True, size=(32, 20))
    assert found.integrator == few and [p.also for p in found.pilots] == [{}, {}]


def test_picks_are_chosen_where_many_lights_cost_many_rays(room):
    """Few passes are enough, in which a cache learns little."""
    many = vc.Whitted(n_vpls=1024, n_area=0)
    found = vc.tune(room, many, rel_l1_reflected=0.25, passes=True, size=(32, 20))
    assert found.also == {"pick": 16} and found.integrator == dataclasses.replace(many, pick=16)
    assert found.is_exact and found.outcome != "missed" and "passes of picks" in repr(found)
    assert found.as_dict()["pick"] == 16


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"rel_l1": 0.1, "flip": 0.1}, "one target must be given: rel_l1_reflected or rel_l1"),
        ({"rel_l1": 0.1, "passes": True}, "passes are tuned by rel_l1_reflected"),
        ({"flip": 1}, r"flip must lie in \(0, 1\), got 1"),
        ({"seconds": 0}, "seconds must be > 0 and finite, got 0"),
        ({"seconds": math.inf}, "seconds must be > 0"),
        ({"passes": 3}, "passes must be True or False, got 3"),
        ({"passes": True, "parameter": "c_e"}, "must be left out with passes"),
        ({"passes": True, "use": "replace"}, "must be left out with passes"),
        ({"passes": True, "flip": 0.1}, "passes are tuned by rel_l1_reflected"),
    ],
)
def test_targets_that_do_not_go_together_are_refused(room, arguments, says):
    with pytest.raises(ValueError, match=says):
        vc.tune(room, WHITTED, size=(16, 16), **arguments)


def test_the_command_takes_every_target(capsys):
    words = ["tune", "room?triangles=2000", "--integrator", "direct", "--size", "48x30", "--json"]
    for more, wanted in (
        (["--target", "flip<=0.05"], {"metric": "flip", "target": 0.05}),
        (["--target", "seconds<=600"], {"wanted": "seconds", "visibility": repr(vc.Exact())}),
        (["--error", "0.05", "--passes"], {"parameter": "passes", "wanted": "error"}),
    ):
        assert cli.main([*words, *more]) == 0
        got = json.loads(capsys.readouterr().out)
        assert {name: got[name] for name in wanted} == wanted
