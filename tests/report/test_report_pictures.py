"""Pictures packed for the report's page: nothing lost that is promised, and maps that are true."""

import flip_evaluator
import numpy as np
import pytest

from reference import report_pictures as page
from viscache import metrics, report
from viscache.report import embed, pictures
from viscache.sweeps.store import Store
from viscache.sweeps.sweep import sweep

pytestmark = pytest.mark.usefixtures("fake_vc", "without_netcdf")


def random_picture(seed, shape=(9, 14, 3)):
    rng = np.random.default_rng(seed)
    return (10 ** rng.uniform(-6, 3, shape) * rng.choice([-1, 1, 1, 1], shape)).astype(np.float32)


def data_of(a, b, step):
    """The page's data of one picture and its reference."""
    packed = {"difference": pictures.pack_difference(a, b, step), "reference": "r"}
    data = {
        "frame": {"width": b.shape[1]},
        "step": step,
        "pictures": {"r": pictures.pack_reference(b)},
    }
    return data, packed


def test_codes_are_half_floats_that_order_as_values_do():
    values = random_picture(1)
    codes = pictures.codes(values, 2.0)
    np.testing.assert_array_equal(page.values(codes), (2 * values).astype(np.float16))
    order = np.argsort(values.ravel())
    assert (np.diff(codes.ravel()[order]) >= 0).all()
    odd = np.array([[[np.nan, np.inf, 1e9], [-np.inf, -1e9, -0.0]]])
    largest = 0x7BFF  # of 65504
    nan = pictures.NAN_CODE
    np.testing.assert_array_equal(
        pictures.codes(odd, 1.0), [[[nan, nan, largest], [nan, -largest, 0]]]
    )


def test_packed_pictures_come_back_bit_for_bit():
    a, b = (pictures.codes(random_picture(seed), 1.0) for seed in (1, 2))
    a[3, 4] = pictures.NAN_CODE, -0x7BFF, 0x7BFF  # steps beyond 16 bits
    b[3, 4] = -0x7BFF, 0x7BFF, pictures.NAN_CODE
    data, setting = data_of(a, b, 1)
    np.testing.assert_array_equal(page.reference(data, "r"), b)
    np.testing.assert_array_equal(page.picture(data, setting), a)


def test_coarse_pictures_are_off_by_half_a_step_at_most():
    b = pictures.codes(np.abs(random_picture(3)), 1.0)
    a = pictures.codes(np.abs(random_picture(3)) * np.linspace(0.9, 1.1, 14)[:, None], 1.0)
    data, setting = data_of(a, b, pictures.COARSE_STEP)
    off = page.picture(data, setting).astype(int) - a
    assert 0 < np.abs(off).max() <= pictures.COARSE_STEP // 2
    assert len(setting["difference"]) < len(pictures.pack_difference(a, b))


def test_shrunk_pictures_keep_their_mean_radiance():
    image = np.abs(random_picture(4, (40, 60, 3)))
    small = pictures.shrunk(image, 15)
    assert small.shape == (10, 15, 3)
    np.testing.assert_allclose(small[2, 3], image[8:12, 12:16].mean((0, 1)), rtol=1e-5)
    assert pictures.shrunk(image, 60) is image


def lightness(colors):
    """CIELAB of (N, 3) sRGB colours in 0 … 255."""
    from skimage.color import rgb2lab

    return np.asarray(rgb2lab(colors[None] / 255.0))[0]


def test_the_signed_scale_is_symmetric_about_zero():
    colors = pictures.scale_colors("RdBu_r").astype(float)
    light = lightness(colors)[:, 0]
    assert light[127] > 96 and light[128] > 96  # 0 is white
    assert np.abs(light - light[::-1]).max() < 8  # of 100
    assert (np.diff(light[:128]) > -0.1).all() and (np.diff(light[128:]) < 0.1).all()


def run(directory, metrics=("rel_l1",), flip_maps=0):
    over = {"c_e": [4, 8, 16], "c_n": [4, 8]}
    sweep("room", "whitted", over=over, size=(48, 32), metrics=list(metrics), directory=directory)
    return report.write(directory, flip_maps=flip_maps).read_text("utf-8")


def frames_of(directory, setting):
    with Store(directory) as store:
        point = next(p for p in store.definition()["points"] if p["index"][:-1] == setting["index"])
        return store.frame(point["key"]).image, store.frame(point["paired"]).image


def test_the_page_has_every_settings_radiance_and_flip_map(tmp_path):
    data = page.model(run(tmp_path, ("rel_l1", "flip"), flip_maps=9))
    assert data["frame"] == {"width": 48, "height": 32} and data["step"] == 1
    for setting in data["settings"]:
        image, reference = frames_of(tmp_path, setting)
        for found, true in (
            (page.picture(data, setting), image),
            (page.reference(data, setting["reference"]), reference),
        ):
            np.testing.assert_allclose(page.values(found) * data["white"], true, rtol=6e-4)
        errors, mean, _ = flip_evaluator.evaluate(
            reference, image, "HDR", inputsRGB=False, applyMagma=False, parameters={"ppd": 67.0}
        )
        np.testing.assert_allclose(page.flip(data, setting), errors[:, :, 0], atol=0.5 / 255 + 1e-6)
        assert setting["flip"]["mean"] == pytest.approx(float(mean), rel=1e-6)
        assert setting["flip"]["mean"] == pytest.approx(setting["cells"]["flip"][0], rel=1e-6)


def test_flip_maps_are_made_for_what_nothing_beats_first(tmp_path):
    text = run(tmp_path, flip_maps=2)
    data = page.model(text)
    mapped = [s["values"] for s in data["settings"] if "flip" in s]
    assert len(mapped) == 2 and "2 settings have one" in text
    # Error and rays of the stand-in do not depend on c_n: of two equals the first is on the front.
    on_front = embed._best_first(data)
    assert mapped == sorted((s["values"] for s in on_front[:2]), key=lambda v: (v["c_e"], v["c_n"]))
    assert not any("flip" in s for s in page.model(run(tmp_path))["settings"])
    with pytest.raises(ValueError, match="flip_maps must be >= 0, got -1"):
        report.write(tmp_path, flip_maps=-1)


def test_wide_frames_are_shown_by_means_and_the_page_says_so(tmp_path):
    run(tmp_path)
    text = report.write(tmp_path, width=24, flip_maps=1).read_text("utf-8")
    data = page.model(text)
    assert data["frame"] == {"width": 24, "height": 16}
    assert "Frames of 48×32 are shown by means at 24×16." in text
    image, _ = frames_of(tmp_path, data["settings"][3])
    means = image.reshape(16, 2, 24, 2, 3).mean((1, 3))
    found = page.values(page.picture(data, data["settings"][3])) * data["white"]
    np.testing.assert_allclose(found, means, rtol=6e-4)
    mapped = next(s for s in data["settings"] if "flip" in s)
    assert page.flip(data, mapped).shape == (16, 24)
    with pytest.raises(ValueError, match="width must be >= 1, got 0"):
        report.write(tmp_path, width=0)


def test_a_page_of_two_pictures_has_their_radiance_and_errors(tmp_path):
    reference = np.random.default_rng(5).uniform(0.01, 10, (12, 20, 1))
    image = reference * 1.25
    path = report.write_difference(image, reference, tmp_path / "p.html", name="<a>", width=20)
    text = path.read_text("utf-8")
    data = page.model(text)
    found = page.values(page.picture(data, data["settings"][0])) * data["white"]
    np.testing.assert_allclose(found, np.repeat(image, 3, 2), rtol=6e-4)
    assert data["settings"][0]["cells"]["rel_l1"][0] == pytest.approx(0.25, rel=1e-5)
    assert "<a>" not in text and "&lt;a&gt;" in text and "default-src 'none'" in text
    with pytest.raises(ValueError, match="one shape"):
        report.write_difference(image, reference[:6], tmp_path / "q.html")


def test_many_pixels_are_kept_coarsely_and_the_page_says_so(tmp_path, monkeypatch):
    exact = run(tmp_path)
    monkeypatch.setattr(pictures, "MOST_EXACT_PIXELS", 48 * 32)
    text = run(tmp_path)
    assert "errors are rounded to 1.6%" in text and "rounded" not in exact
    data = page.model(text)
    image, _ = frames_of(tmp_path, data["settings"][5])
    found = page.values(page.picture(data, data["settings"][5])) * data["white"]
    np.testing.assert_allclose(found, image, rtol=0.009)


def test_flip_maps_are_undefined_where_flip_is():
    black, grey = np.zeros((12, 12, 3)), np.full((12, 12, 3), 0.5)
    assert metrics.flip_map(grey, black) is None and pictures.flip_map(grey, black) is None
    assert pictures.flip_map(np.where(grey == 0.5, np.nan, 0), grey) is None
    found = metrics.flip_map(grey, grey)
    assert found is not None and found[1] == 0 and not found[0].any()
    assert metrics.flip(grey, grey) == 0
