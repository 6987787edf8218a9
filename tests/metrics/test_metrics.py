"""Metrics against numbers calculated by hand and by other programs."""

import os
import subprocess
import sys

import flip_evaluator
import numpy as np
import pytest

from viscache.frame import Frame
from viscache.metrics import METRICS, compare, confidence_interval

RNG = np.random.default_rng(7)
B = RNG.random((24, 32, 3)) ** 2 * 3
A = np.maximum(B + 0.05 * RNG.standard_normal(B.shape), 0)


def test_the_sums_have_their_hand_computed_values():
    b = np.array([[[1.0, 2.0, 3.0]]])
    a = np.array([[[1.5, 2.0, 2.0]]])
    got = compare(a, b, metrics=["rmse", "rel_l1", "energy", "max_abs", "rel_mse"])
    assert got.rmse == pytest.approx(np.sqrt((0.25 + 1.0) / 3))
    assert got.rel_l1 == pytest.approx(1.5 / 6)
    assert got.energy == pytest.approx(-0.5 / 6)
    assert got.max_abs == 1.0
    floor = 0.02**2
    assert got["rel_mse"] == pytest.approx((0.25 / (1 + floor) + 1 / (9 + floor)) / 3)


def test_equal_images_have_no_error_and_full_similarity():
    got = compare(B, B).as_dict()
    assert set(got) == set(METRICS)
    assert got.pop("ssim") == pytest.approx(1.0)
    assert got.pop("rel_l1_reflected") is None  # arrays do not say what is emitted
    assert all(v == 0.0 for v in got.values()), got


def test_ssim_is_scikit_images_on_what_a_viewer_sees():
    from skimage.metrics import structural_similarity

    grey_a, grey_b = (i @ np.array([0.2126, 0.7152, 0.0722]) for i in (A, B))
    white = np.percentile(grey_b, 99)

    def seen(grey):
        x = np.minimum(grey / white, 1)
        return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)

    pair = (seen(grey_a), seen(grey_b))
    expected = structural_similarity(*pair, data_range=1, gaussian_weights=True)
    assert compare(A, B, metrics=["ssim"]).ssim == pytest.approx(expected, abs=1e-12)
    assert 0.3 < expected < 0.9999


def test_flip_is_the_evaluators_own_number_and_the_reference_comes_second():
    ppd = {"ppd": 67.0}
    a, b = A.astype(np.float32), B.astype(np.float32)
    _, mean, _ = flip_evaluator.evaluate(b, a, "HDR", False, False, True, ppd)
    assert compare(A, B, metrics=["flip"]).flip == pytest.approx(mean, abs=1e-7)
    _, swapped, _ = flip_evaluator.evaluate(a, b * 8, "HDR", False, False, True, ppd)
    assert compare(B * 8, A, metrics=["flip"]).flip == pytest.approx(swapped, abs=1e-7)


STAND_IN = """
import os
import numpy as np
seen = os.environ.get("OMP_WAIT_POLICY")
def evaluate(reference, *arguments, **options):
    return np.zeros(reference.shape[:2]), {"passive": 0.25, "active": 0.5}[seen], None
"""


CODE = """
import os, sys
sys.path.insert(0, sys.argv[1])
import numpy as np
from viscache.metrics import compare
value = compare(np.ones((4, 4, 3)), np.ones((4, 4, 3)), metrics=["flip"])["flip"]
print(value, os.environ.get("OMP_WAIT_POLICY"))
"""


@pytest.mark.parametrize(("asked", "found"), [(None, 0.25), ("active", 0.5)])
def test_flips_threads_sleep_while_they_wait_unless_told_otherwise(tmp_path, asked, found):
    (tmp_path / "flip_evaluator.py").write_text(STAND_IN, encoding="utf-8")
    environment = {k: v for k, v in os.environ.items() if k != "OMP_WAIT_POLICY"}
    environment |= {"OMP_WAIT_POLICY": asked} if asked else {}
    command = [sys.executable, "-c", CODE, str(tmp_path)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [str(found), str(asked)]


def test_a_reference_too_dark_for_the_flip_evaluator_is_compared_all_the_same():
    plain = compare(A, B, metrics=["flip"]).flip
    assert compare(A * 1e-9, B * 1e-9, metrics=["flip"]).flip == pytest.approx(plain, abs=1e-3)


@pytest.mark.parametrize("metric", ["rel_l1", "energy", "rel_mse", "flip"])
def test_a_black_reference_leaves_relative_metrics_undefined(metric):
    got = compare(A, np.zeros_like(A))
    assert got[metric] is None
    assert got.rmse == pytest.approx(np.sqrt(np.mean(A**2)))


@pytest.mark.parametrize("metric", ["rel_l1", "rel_l1_reflected", "energy"])
@pytest.mark.parametrize(("first", "given"), [(-2.0, "-1.0"), (-1.0, "0.0")])
def test_a_reference_whose_sum_is_not_above_0_is_refused(metric, first, given):
    """Its shares would be negative, and so below any limit."""
    b = np.zeros((1, 2, 3))
    b[0, 0, 0], b[0, 1, 2] = first, 1.0
    frames = [
        Frame(layers={"color": image, "emitted": np.zeros_like(image)}) for image in (np.abs(b), b)
    ]
    must = f"the reference must be black, or the sum of its pixels above 0, got {given}"
    with pytest.raises(ValueError, match=must):
        compare(*frames, metrics=[metric])
    with pytest.raises(ValueError, match=must):
        METRICS[metric](np.abs(b), b)
    assert compare(*frames, metrics=["rmse", "max_abs"]).max_abs == 2 * abs(first)


def test_ssim_of_an_image_smaller_than_its_window_is_undefined():
    assert compare(A[:8], B[:8]).ssim is None


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("which", [0, 1])
def test_a_non_finite_pixel_is_an_error_that_says_where(value, which):
    pair = [A.copy(), B.copy()]
    pair[which][3, 5, 1] = value
    with pytest.raises(ValueError, match=rf"{'ab'[which]} must be finite.*row 3, column 5"):
        compare(*pair)


@pytest.mark.parametrize(
    ("a", "b", "asked", "says"),
    [
        (A, B[:, :31], None, r"one shape, got \(24, 32, 3\) and \(24, 31, 3\)"),
        (A, B, ["relmse"], "did you mean 'rel_mse'"),
        ([A, A], [B, B, B], None, "same number of repeats, got 2 and 3"),
    ],
    ids=["sizes", "name", "repeats"],
)
def test_what_cannot_be_compared_is_refused(a, b, asked, says):
    with pytest.raises(ValueError, match=says):
        compare(a, b, metrics=asked)


def test_repeats_give_the_mean_and_students_interval():
    # Four samples 1, 2, 3, 4: mean 2.5, s = 1.2910, t(0.975, 3) = 3.1824, half = 2.0543.
    assert confidence_interval([1, 2, 3, 4]) == pytest.approx((0.4457, 4.5543), abs=1e-4)
    shots = [Frame(layers={"color": B + d}) for d in (0.01, 0.02, 0.04)]
    got = compare(shots, Frame(layers={"color": B}), metrics=["rel_l1"])
    singles = [compare(s, B, metrics=["rel_l1"]).rel_l1 for s in shots]
    assert got.repeats == 3 and got.rel_l1 == pytest.approx(np.mean(singles))
    low, high = got.intervals["rel_l1"]
    assert low < got.rel_l1 < high
    assert (low, high) == pytest.approx(confidence_interval(singles), abs=1e-6)


def test_metrics_are_a_mapping_that_knows_what_was_asked_for():
    got = compare(A, B, metrics=["rmse"])
    assert list(got) == ["rmse"] and "flip" not in got
    with pytest.raises(AttributeError, match="flip was not asked for"):
        _ = got.flip
    assert "rmse" in got._repr_html_()


def test_a_change_of_one_percent_is_seen_by_every_metric():
    got = compare(B * 1.01, B)
    assert got.energy == pytest.approx(0.01) and got.rel_l1 == pytest.approx(0.01)
    assert got.rel_mse > 0 and got.flip > 1e-3 and got.ssim < 1 - 1e-6


def test_progress_counts_the_metrics_of_all_pairs():
    told = []
    image = np.ones((8, 8, 3))
    compare([image] * 2, image, metrics=["rmse", "rel_l1"], progress=lambda *at: told.append(at))
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]
