"""Ratios, errors and verdicts of benches, on measurements made up by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray

from viscache_lab.bench import errors as errors_of_frames
from viscache_lab.bench import meter, vismap_variance, which_cache
from viscache_lab.bench.text import text
from viscache_lab.experiment import Trial, amounts


def test_a_limit_and_a_goal_hold_on_their_side_alone():
    for value, holds in ((0.5, True), (1.0, True), (1.5, False)):
        assert amounts.at_most_figure("x", value, "s", 1.0)["holds"] is holds
        assert amounts.figure("x", 1.0, "s", ratios=[value], goal=1.0)["holds"] is (value >= 1)
    assert amounts.at_most_figure("x", 9.0, "s", None)["holds"] is None
    assert amounts.figure("x", 1.0, "s", ratios=[9.0])["holds"] is None


def test_a_gain_is_error_times_time_of_exact_frames_over_that_of_the_other():
    n = 8
    found = {"exact": np.full((2, n), [[4.0], [6.0]]), "picks": np.ones((2, n))}
    seconds = {"exact": [3.0] * n, "picks": [2.0] * n}
    assert errors_of_frames.gain(found, seconds, "picks", 0) == pytest.approx((6, 6, 6))
    assert errors_of_frames.gain(found, seconds, "picks", 1) == pytest.approx((9, 9, 9))
    trial = Trial()
    passes = passes_of({"exact": (4.0, 6.0, 3.0), "a": (1.0, 1.0, 2.0)})
    which_cache.gain_figure(trial, "x", passes, "a")
    (made,) = trial.figures
    assert made["ratio"] == pytest.approx(6) and made["gain_rel"] == pytest.approx(9)
    # Both errors are known to a tenth: their ratio to a tenth of √2, in logarithms
    ends = [6 * np.exp(sign * 0.1 * np.sqrt(2)) for sign in (-1, 1)]
    assert [made["low"], made["high"]] == pytest.approx(ends)
    machine = {"processor": "p", "cores": 2}
    result = {"bench": "b", "machine": machine, "figures": [made], "skipped": [], "answers": []}
    printed = text(result)
    assert "6.00x [" in printed and "relMSE 9.00x" in printed
    assert (made["value"], made["baseline"]) == (1.0, 4.0)
    assert (made["cpu_s"], made["exact_cpu_s"]) == (2.0, 3.0)


def passes_of(settings):
    """One pass of each setting: its nmse, known to a tenth, relative error and seconds."""
    nmse, relative, seconds = np.array(list(settings.values())).T[:, :, None]
    rows = {"nmse": nmse, "nmse_high": 1.1 * nmse, "rel_mse": relative, "cpu_s": seconds}
    pictures = {"reference": (("row", "column"), np.ones((2, 2)))}
    return xarray.Dataset(
        {name: (("setting", "pass"), values) for name, values in rows.items()} | pictures,
        coords={"setting": list(settings), "pass": [1]},
    )


def test_an_interval_of_a_gain_covers_the_seeds():
    r = np.random.default_rng(0)
    found = {"exact": (4 + r.normal(0, 0.4, 64), r.random(64)), "a": (np.ones(64), r.random(64))}
    gain, low, high = errors_of_frames.gain(found, {"exact": [1.0] * 64, "a": [1.0] * 64}, "a", 0)
    # Four standard errors of the mean wide, within what a bootstrap leaves
    assert low < gain < high and high - low == pytest.approx(4 * 0.4 / 8, rel=0.25)


def test_the_noise_of_the_reference_is_taken_out_of_squared_errors():
    truth = np.full((2, 4, 4, 3), 2.0)
    truth[:, :2] = 4.0
    noise = np.array([0.5, -0.5])[:, None, None, None]
    errors = errors_of_frames.Errors(truth + noise)
    image = truth[:1] + 1.0
    # The mean of two references varies by 0.5²: of the square of 1 that much is left out
    nmse, relative = errors.of(image)
    assert nmse == pytest.approx((1 - 0.25) / 9)
    floor = (errors_of_frames.DARK * 3) ** 2
    assert relative == pytest.approx(0.75 * np.mean([1 / (4 + floor), 1 / (16 + floor)]))
    assert errors.of(truth[:1])[0] == pytest.approx(-0.25 / 9)


def test_the_energy_of_frames_is_judged_by_the_noise_of_their_differences():
    r = np.random.default_rng(1)
    exact = r.random((9, 4, 4, 3))
    off = np.linspace(-1, 1, 9)[:, None, None, None]
    t = 0.5 / (np.std(off, ddof=1) / 3)
    assert errors_of_frames.energy_z(off + 0.5 + 0 * exact) == pytest.approx(t)
    assert errors_of_frames.energy_z(off + 0 * exact) == pytest.approx(0, abs=1e-9)


def covered(error_seen):
    """Coverage by audits of a frame that errs everywhere, if its error were other by a factor."""
    r = np.random.default_rng(2)
    light = 1 + r.random((128, 128)).astype(np.float32)
    error = 0.1 * r.normal(size=(128, 128, 3))
    exact = 3 * light.astype(np.float64).sum() - error.sum()
    truth = {
        "rel_l1": error_seen * float(np.abs(error).sum()) / exact,
        "nrmse": error_seen * float(np.sqrt(np.square(error).mean())) * error.size / exact,
    }
    case = meter.Case(name="x", scene="", integrator=meter.VPLS, cache=meter.ALL, seeds=60)
    return meter._coverage(case, light, error, 3 * float(light.sum()), truth, 1024)


def test_a_coverage_is_the_share_of_intervals_that_hold_the_truth():
    right = covered(1.0)
    assert right["shown"] == 1 and 0.85 < right["coverage"] <= 1
    assert 0.85 < right["coverage_of_nrmse"] <= 1
    for factor in (0.5, 2.0):
        wrong = covered(factor)
        assert wrong["coverage"] == wrong["coverage_of_nrmse"] == 0


@pytest.mark.parametrize(("value", "holds"), [(0.92, False), (0.95, True), (0.99, False)])
def test_a_coverage_can_be_too_small_and_too_large(value, holds):
    trial = Trial()
    meter._check(trial, "coverage", value, meter.COVERAGE)
    assert trial.answers_hold is holds and len(trial.answers) == 2


def test_means_that_are_off_by_more_than_chance_are_found():
    r = np.random.default_rng(3)
    truth = r.random(20)
    for shift, holds in ((0.0, True), (0.05, False)):
        trial = Trial()
        estimates = {"way": truth + 0.1 * r.normal(size=(64, 20)) + shift}
        found = SimpleNamespace(truth=truth, estimates=estimates)
        vismap_variance.check_means(trial, "x", found)
        assert trial.answers_hold is holds


def test_a_persistent_error_is_told_from_noise():
    """A bias of a fifth of one pass' noise, over 64 passes; the first is nearly all noise."""
    r = np.random.default_rng(5)
    noise = r.normal(0, 0.5, (64, 64, 64, 3))
    squared, z = errors_of_frames.persistent_z(noise, 2.0)
    assert abs(z) < 4 and abs(errors_of_frames.energy_z(noise)) < 4
    # Of either sign, so that the energy does not show it
    bias = 0.1 * np.where(np.arange(64) % 2, 1.0, -1.0)[None, None, :, None]
    squared, z = errors_of_frames.persistent_z(noise + bias, 2.0)
    assert z > 10 and squared == pytest.approx(0.01 / 4, rel=0.2)
    assert abs(errors_of_frames.energy_z(noise + bias)) < 4
    assert errors_of_frames.energy_z(noise + 0.01) > 10


def test_passes_alone_are_those_of_the_running_mean():
    passes = np.random.default_rng(6).random((5, 4, 4, 3)).astype(np.float32)
    means = iter([SimpleNamespace(image=passes[: i + 1].mean(axis=0)) for i in range(5)])
    picture = SimpleNamespace(passes=lambda n: next(means))
    np.testing.assert_allclose(errors_of_frames.alone(picture, 5), passes, atol=1e-5)
