"""vc.pareto: which settings of a sweep another one beats."""

import json

import numpy as np
import pytest
import xarray

import viscache as vc
from viscache.sweeps.bias import bias_and_variance


def sweep_of(cost, error):
    """A sweep over c_e with repeats, as `viscache.sweep` returns it."""
    data = {"total_s": (("c_e", "repeat"), cost), "rel_l1": (("c_e", "repeat"), error)}
    return xarray.Dataset(
        data, coords={"c_e": np.arange(len(cost))}, attrs={"metrics": json.dumps(["rel_l1"])}
    )


def test_what_another_setting_beats_is_dominated():
    ds = sweep_of([[1.0], [2.0], [3.0], [3.0]], [[0.5], [0.6], [0.1], [0.1]])
    front = vc.pareto(ds)
    assert [(s.values["c_e"], s.dominated) for s in front] == [
        (0, False),
        (1, True),
        (2, False),
        (3, False),  # equal in both: neither beats the other
    ]
    assert [s.values["c_e"] for s in front.best] == [0, 2, 3]
    assert [s.certain for s in front] == [False, True, False, False]
    found = front.cheapest(0.3)
    assert found is not None
    assert found.values["c_e"] == 2
    assert front.cheapest(0.01) is None


def test_intervals_that_overlap_leave_it_open():
    clear = sweep_of([[1.0, 1.01], [2.0, 2.01]], [[0.1, 0.101], [0.2, 0.201]])
    noisy = sweep_of([[1.0, 1.9], [2.0, 1.1]], [[0.1, 0.3], [0.25, 0.2]])
    assert [s.certain for s in vc.pareto(clear)] == [False, True]
    assert [s.dominated for s in vc.pareto(noisy)] == [False, True]
    assert not any(s.certain for s in vc.pareto(noisy))
    assert "dominated?" in str(vc.pareto(noisy))
    assert "±" in str(vc.pareto(noisy))


def test_unfinished_settings_are_left_out_and_tables_are_whole():
    ds = sweep_of([[1.0], [np.nan]], [[0.5], [np.nan]])
    front = vc.pareto(ds)
    assert len(front) == 1
    assert "<table>" in front._repr_html_()
    assert str(front).splitlines()[0].split() == ["c_e", "total_s", "rel_l1"]


def test_wrong_input_is_refused():
    ds = sweep_of([[1.0]], [[0.5]])
    with pytest.raises(ValueError, match="cost must be a variable of the sweep, got 'joules'"):
        vc.pareto(ds, cost="joules")
    with pytest.raises(ValueError, match="error must be one of the sweep's metrics"):
        vc.pareto(ds, error="flip")
    with pytest.raises(ValueError, match="ds must have a finished setting"):
        vc.pareto(sweep_of([[np.nan]], [[0.5]]))


def test_bias_and_variance_are_told_apart_by_the_seeds():
    rng = np.random.default_rng(5)
    exact = [np.full((48, 48, 3), 2.0) + rng.normal(0, 0.3, (48, 48, 3)) for _ in range(6)]
    covered = 0
    for _ in range(40):
        frames = [e + 0.1 + rng.normal(0, 0.4, e.shape) for e in exact]
        bias2, variance = bias_and_variance(frames, exact)
        assert variance[0] == pytest.approx(0.16 / 4, rel=0.05)
        covered += bias2[1] <= 0.01 / 4 <= bias2[2]
    assert covered >= 33
    unbiased, _ = bias_and_variance([e + rng.normal(0, 0.4, e.shape) for e in exact], exact)
    assert abs(unbiased[0]) < 0.001
    squared = np.mean([np.square(f - e).mean() for f, e in zip(frames, exact, strict=True)])
    assert bias2[0] + variance[0] == pytest.approx(squared / np.mean(exact) ** 2, rel=1e-6)


def test_a_sweep_with_repeats_has_both_and_the_cache_is_biased(tmp_path):
    ds = vc.sweep(
        "room?triangles=2000", vc.Whitted(n_vpls=32), over={"c_e": [8, 64]}, size=(48, 32),
        visibility=vc.Aqvc(exact_groups=()), repeats=4, directory=tmp_path / "s",
    )  # fmt: skip
    front = vc.pareto(ds, cost="rays")
    for setting in front:
        assert setting.bias2 is not None and setting.variance is not None
        assert setting.bias2[1] <= setting.bias2[0] <= setting.bias2[2]
        assert setting.variance[0] > 0
    by_c_e = {s.values["c_e"]: s for s in front}
    assert by_c_e[64].bias2[0] > by_c_e[8].bias2[0]
    assert str(front).splitlines()[0].split() == ["c_e", "rays", "rel_l1", "bias²", "variance"]
    assert "bias²" in front._repr_html_()
    assert all(s.bias2 is None for s in vc.pareto(ds, cost="rays", split=False))
    with pytest.raises(ValueError, match="split needs a sweep with a directory and repeats"):
        vc.pareto(sweep_of([[1.0]], [[0.5]]), split=True)
