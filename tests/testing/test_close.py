"""`assert_close` passes what is within its limits, and says of the rest what is wrong."""

import math
import pickle

import numpy as np
import pytest

import viscache as vc
from viscache.metrics import METRICS
from viscache.testing import PictureError, assert_close
from viscache.testing.limits import Limit, checked, parsed


def picture(seed=0):
    """A picture with structure: a ramp and a box."""
    rows, columns = np.indices((40, 48))
    image = 0.2 + (rows + 2 * columns)[..., None] / 50 * np.array([1.0, 0.8, 0.5])
    image[10:20, 5:25] *= 0.3
    return image * np.random.default_rng(seed).uniform(0.95, 1.05, (40, 48, 1))


def message(*arguments, **limits):
    with pytest.raises(PictureError) as caught:
        assert_close(*arguments, **limits)
    return str(caught.value)


@pytest.mark.parametrize("metric", METRICS)
def test_every_metric_can_be_limited_from_both_sides_of_its_value(metric):
    b = vc.Frame(layers={"color": picture(), "seen_emitters": 0 * picture()})
    a = vc.Frame(layers={"color": b.image * 0.93, "seen_emitters": 0 * picture()})
    value = vc.metrics.compare(a, b)[metric]
    assert value is not None and value != 0
    looser, tighter = 1.01 * abs(value), 0.99 * abs(value)
    if metric == "ssim":
        looser, tighter = 0.999 * value, (1 + value) / 2
    assert assert_close(a, b, **{metric: looser})[metric] == value
    text = message(a, b, **{metric: tighter})
    assert f"{metric} must be" in text.splitlines()[0] and f"{value:.4g}" in text


def test_energy_is_limited_both_ways():
    b = picture()
    for a in (1.02 * b, 0.98 * b):
        assert_close(a, b, energy=0.021)
        assert "energy must be within ±0.019" in message(a, b, energy=0.019)


def test_without_limits_the_usual_ones_hold_and_given_ones_replace_them():
    b = picture()
    assert set(assert_close(1.005 * b, b)) == {"rel_l1", "energy"}
    assert "energy must be within ±0.01" in message(1.015 * b, b)
    assert "rel_l1 must be <= 0.02" in message(
        b * np.where(np.indices(b.shape)[0] % 2, 1.1, 0.9), b
    )
    assert set(assert_close(2 * b, b, rmse=10)) == {"rmse"}


def test_of_repeats_the_whole_interval_must_be_within_the_limit():
    b = [picture(s) for s in range(5)]
    a = [p * f for p, f in zip(b, (1.01, 1.02, 1.03, 1.04, 1.05), strict=True)]
    low, high = vc.metrics.compare(a, b, metrics=["energy"]).intervals["energy"]
    assert low < 0.03 < high < 0.06
    assert_close(a, b, energy=high + 1e-9)
    text = message(a, b, energy=0.04)  # above the mean, below the end of the interval
    assert "means of 5 pairs" in text and f"(95 %: {low:.4g} to {high:.4g})" in text
    with pytest.raises(PictureError) as caught:
        assert_close(a, b, energy=0.04)
    assert caught.value.picture is a[4] and caught.value.reference is b[4]  # the worst
    a[2] = 1.5 * b[2]
    with pytest.raises(PictureError) as caught:
        assert_close(a, b[0], rel_l1=0.04)
    assert caught.value.picture is a[2] and caught.value.reference is b[0]


def test_the_message_says_where_and_how_much():
    a, b = picture(), picture()
    a[7, 31] += [0.5, 0.25, 0]
    text = message(a, b, max_abs=0.1)
    assert "max_abs     0.5           must be <= 0.1, 5 times" in text
    assert "row 7, column 31: [" in text and "1 of 1920 differ (0.1%)" in text
    assert "48x40 pixels of unknown origin" in text


@pytest.mark.parametrize(
    ("spoilt", "says"),
    [
        (lambda b: 0.5 * b, "the picture is 1/2 of the exact one"),
        (lambda b: b[::-1], "upside down"),
        (lambda b: b[:, ::-1], "mirrored"),
        (lambda b: b[:, :, ::-1], "red and blue of the picture are swapped"),
    ],
)
def test_simple_changes_are_recognised(spoilt, says):
    b = picture()
    assert says in message(spoilt(b), b)
    noise = b + np.random.default_rng(1).normal(0, 0.2, b.shape)
    assert says not in message(noise, b)


def test_frames_that_do_not_fit_are_named():
    scene, size = vc.scenes.stairs(), (32, 20)
    exact = vc.render(scene, vc.Direct(), size=size)
    other = vc.render(scene, vc.Direct(n_area=4), size=size, seed=1, spp=2)
    text = message(other, exact, rel_l1=0)
    assert "the frames differ in integrator, spp (2, exact 1), seed (1, exact 0)" in text
    assert "32x20 pixels, stairs, Direct, Exact, spp 2, seed 1" in text


@pytest.mark.parametrize(
    ("visibility", "use", "says"),
    [
        (vc.Aqvc(c_e=12, exact_groups=()), "replace", "a smaller c_e (now 12)"),
        (vc.Aqvc(c_e=12, exact_groups=()), vc.Correct(share=0.1), "corrected frames err by noise"),
        (vc.ShadowMap(resolution=16), None, "a higher resolution (now 16)"),
        (vc.NeePlusPlus(learn_pixels=16), None, "its error is noise"),
        (vc.Unoccluded(), None, "leaves all shadows out"),
    ],
)
def test_advice_follows_from_the_settings(visibility, use, says):
    scene, size = vc.scenes.build("room?triangles=3000"), (48, 30)
    exact = vc.render(scene, vc.Direct(), size=size)
    frame = vc.render(scene, vc.Direct(), size=size, visibility=visibility, use=use)
    text = message(frame, exact, rel_l1=1e-6)
    assert says in text and "differ in" not in text


def test_what_cannot_be_compared_fails_and_says_why():
    a, b = picture(), picture()
    assert "must have one shape" in message(a[:20], b)
    a[3, 5, 1] = np.nan
    assert "non-finite pixel(s), the first at row 3, column 5" in message(a, b)
    assert "rel_l1      undefined     must be <= 0.02" in message(b, 0 * b)
    for metric in ("rel_l1", "energy"):
        assert "the sum of its pixels above 0, got -" in message(b, -b, **{metric: 0.02})
    assert "rel_l1_reflected" in message(b, b, rel_l1_reflected=0.5)  # arrays have no layers


@pytest.mark.parametrize(
    ("limits", "says"),
    [
        ({"rel_l1": -0.1}, "rel_l1 must be a limit >= 0, got -0.1"),
        ({"rel_l1": math.nan}, "rel_l1 must be a limit"),
        ({"rmse": math.inf}, "rmse must be a limit"),
        ({"ssim": 1.5}, "ssim must be a limit >= 0 and <= 1, got 1.5"),
        ({"flip": True}, "flip must be a limit"),
    ],
)
def test_limits_that_nothing_or_everything_meets_are_refused(limits, says):
    with pytest.raises(ValueError, match=says.replace("(", r"\(")):
        assert_close(picture(), picture(), **limits)
    with pytest.raises(TypeError, match="did you mean 'rel_l1'"):
        assert_close(picture(), picture(), rell1=0.1)


def test_the_page_shows_both_pictures_and_the_numbers(tmp_path):
    scene, size = vc.scenes.stairs(), (48, 30)
    exact = vc.render(scene, vc.Direct(), size=size)
    cached = vc.render(scene, vc.Direct(), size=size, visibility=vc.Unoccluded())
    with pytest.raises(PictureError) as caught:
        assert_close(cached, exact)
    page = caught.value.write(tmp_path / "diff.html", title="test_stairs")
    assert page == tmp_path / "diff.html"
    text = page.read_text("utf-8")
    assert "<title>test_stairs − exact</title>" in text and text.count("must be") >= 2
    assert cached.sha256 in text and '"reference"' in text and 'src="' not in text
    broken = cached.image.copy()
    broken[0, 0] = np.inf
    with pytest.raises(PictureError) as caught:
        assert_close(broken, exact)
    assert caught.value.write(tmp_path / "none.html") is None
    assert not (tmp_path / "none.html").exists()


def test_the_error_travels_between_processes():
    error = PictureError("message", picture(), picture(), {"rel_l1": "0.1"})
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == "message" and isinstance(again, AssertionError)
    assert again.numbers == {"rel_l1": "0.1"}


def test_limits_are_read_from_text():
    assert parsed("rel_l1<=0.02") == Limit("rel_l1", 0.02)
    assert parsed(" ssim >= .98 ") == Limit("ssim", 0.98)
    assert parsed("energy<=1e-3") == Limit("energy", 0.001)
    for text, says in (
        ("rel_l1", 'a limit must be like "rel_l1<=0.02"'),
        ("rel_l1>=0.02", "a limit of rel_l1 must be rel_l1<=NUMBER"),
        ("ssim<=0.9", "a limit of ssim must be ssim>=NUMBER"),
        ("rell1<=0.02", "did you mean 'rel_l1'"),
        ("rel_l1<=much", "rel_l1 must be a limit >= 0"),
    ):
        with pytest.raises(ValueError, match=says.replace("(", r"\(")):
            parsed(text)
    with pytest.raises(ValueError, match="a limit of at least one metric"):
        checked({"rel_l1": None})
