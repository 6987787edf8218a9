"""A frame's corrections, one by one: they sum to the frame, and wrong rules show a bias."""

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from viscache.oracles.points import unpack

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

OPTIONS = {"size": (64, 40)}
LIGHTS = vc.Whitted(n_vpls=128, n_area=0)
CACHE = vc.Aqvc(c_e=16, exact_groups=("point",))
#: The same cells without finer ones.
COARSE = vc.Aqvc(c_e=16, refinement="off", exact_groups=("point",))
CERTAIN = 1 / 64
#: A sum further than so many standard errors from the truth is biased.
LIMIT = 4.0


@dataclasses.dataclass(frozen=True)
class Record:
    """Connections of eye points (rows) with virtual lights (columns)."""

    v: Floats  #: V: 1 where a ray sees the light
    cached: Floats  #: what the cache answers
    weight: Floats  #: what the frame counts: the cache's answer, or the corrected one
    light: Floats  #: contribution before visibility, summed over channels
    wanted: Bools  #: connections that the frame asks for

    @property
    def changed(self):
        """Answers that a check found wrong."""
        return np.asarray(self.wanted & (self.weight != self.cached))

    @property
    def inverse_share(self):
        """1/q where an answer was changed, else 1."""
        change = (self.weight - self.cached) / np.where(self.changed, self.v - self.cached, 1)
        return np.where(self.changed, change, 1)

    def z(self, weight):
        """How many standard errors Σ c·weight is from Σ c·V.

        The variance is Σ c²·(1 - q)/q over all wrong answers, by those found: each counts 1/q.
        """
        w = self.inverse_share
        variance = (np.square(self.light) * w * (w - 1))[self.changed].sum()
        away = (self.light * (weight - self.v))[self.wanted].sum()
        return float(away / np.sqrt(variance))


def recorded(scene, cache):
    asked = vc.connections(scene, LIGHTS, **OPTIONS)
    exact, cached = (np.asarray(asked.answers(v)["vpl"], float) for v in (vc.Exact(), cache))
    corrected = asked.answers(cache, use=vc.Correct(certain=CERTAIN))["vpl"]
    weight = np.where(corrected.visible, corrected.weights, 0).astype(np.float64)
    light = asked.contributions("vpl").astype(np.float64).sum(axis=2)
    wanted = unpack(asked.wanted("vpl"), len(asked.groups["vpl"]))
    return Record(exact, cached, weight, light, wanted)


@pytest.fixture(scope="module")
def fine(room):
    return recorded(room, CACHE)


@pytest.fixture(scope="module")
def coarse(room):
    return recorded(room, COARSE)


def test_recorded_corrections_sum_to_the_frame(room, fine):
    """Weights are V~ + xi·(V - V~)/q with q a power of two, and nothing else is in the picture."""
    share = fine.inverse_share[fine.changed]
    assert len(share) > 1000
    assert (fine.cached != fine.v)[fine.changed].all()
    np.testing.assert_array_equal(share, np.exp2(np.round(np.log2(share))))
    assert 1 <= share.min() < share.max() <= 256
    asked = vc.connections(room, LIGHTS, **OPTIONS)
    frame = vc.render(room, LIGHTS, visibility=CACHE, use=vc.Correct(certain=CERTAIN), **OPTIONS)
    whole = fine.cached + np.where(fine.changed, (fine.v - fine.cached) * fine.inverse_share, 0)
    light = np.einsum("nm,nmc->nc", whole, asked.contributions("vpl").astype(np.float64))
    total = frame.layers["vpl"].sum(axis=(0, 1), dtype=np.float64)
    np.testing.assert_allclose(light.sum(axis=0), total, rtol=1e-5)
    cached = vc.render(room, LIGHTS, visibility=CACHE, **OPTIONS)
    assert np.abs(cached.layers["vpl"].sum(axis=(0, 1)) / total - 1).max() > 1e-3
    # The frame's estimate of its own variance, too
    assert frame.counters["wrong"] == len(share)
    inverse = np.where(fine.changed, fine.inverse_share, 1)[..., None]
    squares = np.square(asked.contributions("vpl").astype(np.float64)) * inverse * (inverse - 1)
    found = frame.layers["variance"].sum(axis=(0, 1), dtype=np.float64)
    np.testing.assert_allclose(squares.sum(axis=(0, 1)), found, rtol=1e-4)


def test_the_recorded_sum_is_unbiased(fine, coarse):
    for record in (fine, coarse):
        assert abs(record.z(record.weight)) < LIMIT
        assert abs(record.z(record.cached)) > LIMIT


def test_a_class_that_is_never_checked_leaves_a_bias(fine):
    """Negative control: q = 0 where the cache answers "blocked", or "visible"."""
    for answer in (0, 1):
        unchecked = np.where(fine.cached == answer, fine.cached, fine.weight)
        assert abs(fine.z(unchecked)) > LIMIT


def test_the_weight_of_a_neighbouring_band_leaves_a_bias(coarse):
    """Negative control: answers count as if they had been checked twice or half as often.

    With finer cells, errors of both signs nearly cancel in the sum.
    """
    for factor in (0.5, 2):
        wrong = coarse.cached + (coarse.v - coarse.cached) * factor * coarse.inverse_share
        wrong = np.where(coarse.changed & (coarse.inverse_share > 1), wrong, coarse.weight)
        assert abs(coarse.z(wrong)) > LIMIT
