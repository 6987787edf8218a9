"""Single pixels estimated many times against the true sum of the texels."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import viscache as vc
from viscache import scenes
from viscache.bench.common import Outcome
from viscache.bench.vismap_variance import CASES, add_figures, all_ways, check_means
from viscache.variance import variance_ratio
from viscache.vismap import MapSettings, VisibilityMapCache
from viscache.vismap.simulation import PixelEstimates, Way, simulate

ONE, STEADY = Way(alpha=1.0), Way(alpha="previous_pass", passes=4)
PRODUCT, GUIDED = Way(), Way(alpha="previous_pass", eta=0.25, passes=4)


@cache
def window_room() -> VisibilityMapCache:
    made = VisibilityMapCache(scenes.window_room(), MapSettings(n_startup=400))
    made.update(size=(96, 72))
    return made


@cache
def estimates() -> PixelEstimates:
    return simulate(window_room(), [PRODUCT, ONE, STEADY, GUIDED], [30], size=(96, 72),
                    n_pixels=40, replicates=64)  # fmt: skip


def ratio(way: Way) -> float:
    rows = [[r[None, :, None] for r in estimates().estimates[w, 30]] for w in (way, PRODUCT)]
    return variance_ratio(*rows).ratio


def test_the_truth_is_what_the_renderer_finds() -> None:
    """The mean over pixels of a picture of the room, whose light is white and constant."""
    found = simulate(window_room(), [PRODUCT], [1], size=(28, 21), n_pixels=10**6, replicates=2)
    image = vc.render(scenes.window_room(), vc.Direct(n_environment=4000), size=(28, 21), seed=3)
    surface = image.layers["coverage"][:, :, 0] > 0
    assert found.truth.mean() == pytest.approx(image.image[surface].mean(), rel=0.05)


@pytest.mark.stat
def test_every_way_is_unbiased_and_a_wrong_truth_is_found() -> None:
    outcome = Outcome()
    check_means(outcome, "room", estimates())
    assert outcome.answers_hold
    shifted = PixelEstimates(truth=estimates().truth * 1.2, estimates=estimates().estimates)
    check_means(outcome, "shifted", shifted)
    assert [a["holds"] for a in outcome.answers] == [True, False]


def test_guiding_leaves_little_of_the_variance_and_the_control_variate_some() -> None:
    assert ratio(GUIDED) < 0.15
    assert 0.2 < ratio(ONE) < 1.1


def test_figures_have_the_goals_of_their_case_as_gains() -> None:
    case = next(c for c in CASES if c.name == "window_room")
    found = simulate(window_room(), all_ways(), [30], size=(96, 72), n_pixels=4, replicates=4)
    outcome = Outcome()
    add_figures(outcome, case, found, [30], len(window_room()))
    with_goal = [f for f in outcome.figures if f["goal"] is not None]
    assert [f["name"] for f in with_goal] == [
        "window_room, guided, rqmc, 30 samples vs product sampling"
    ]
    assert with_goal[0]["goal"] == pytest.approx(20)
    assert with_goal[0]["ratio"] == pytest.approx(1 / with_goal[0]["value"])
    assert with_goal[0]["low"] <= with_goal[0]["ratio"] <= with_goal[0]["high"]


def test_the_same_seed_gives_the_same_bytes_for_any_number_of_threads() -> None:
    one, three = (
        simulate(window_room(), [GUIDED], [10], size=(96, 72), n_pixels=3, replicates=5, threads=t)
        for t in (1, 3)
    )
    np.testing.assert_array_equal(one.estimates[GUIDED, 10], three.estimates[GUIDED, 10])


def test_what_cannot_be_estimated_is_refused() -> None:
    with pytest.raises(ValueError, match=r"eta must be in \(0, 1\], got 0"):
        Way(eta=0)
    with pytest.raises(ValueError, match='alpha="loo" needs points="iid", got \'rqmc\''):
        Way(alpha="loo")
    with pytest.raises(ValueError, match="replicates must be >= 2, got 1"):
        simulate(window_room(), [ONE], [1], replicates=1)
    lamps = VisibilityMapCache(scenes.cornell_box(), MapSettings(n_startup=10))
    with pytest.raises(ValueError, match="lit by its environment alone"):
        simulate(lamps, [ONE], [1])
