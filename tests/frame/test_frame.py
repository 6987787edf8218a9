"""Frames: values in memory and on disk."""

import hashlib
import json

import numpy as np
import OpenEXR
import pytest

from viscache.base.tonemap import auto_exposure, difference8, srgb_curve, to_srgb8
from viscache.frame import Frame


def make(height=6, width=9):
    rng = np.random.default_rng(1)
    color = rng.random((height, width, 3), np.float32)
    color[0, 0] = (np.nan, np.inf, -np.inf)
    color[1, 1] = (-0.0, 1e-45, 3e38)
    shapes = {"position": (3,), "depth": (), "uv": (2,), "odd": (5,)}
    layers = {n: rng.random((height, width, *last), np.float32) for n, last in shapes.items()}
    return Frame(
        layers={"position": layers.pop("position"), "color": color, **layers},
        counters={"queries": 2**60 + 1, "groups": {"vpl": {"rays": 3}}, "levels": [1, 2]},
        timings={"total_s": 0.1},
        parameters={"c_e": 4, "ö": None},
        warnings=["no film"],
    )


def test_a_saved_frame_comes_back_bit_for_bit_with_its_records(tmp_path):
    frame = make()
    frame.save(tmp_path / "a.exr")
    back = Frame.load(tmp_path / "a.exr")
    assert list(back.layers) == list(frame.layers) and next(iter(back.layers)) == "color"
    for name, pixels in frame.layers.items():
        assert back.layers[name].tobytes() == pixels.tobytes(), name
    for record in ("counters", "timings", "parameters", "provenance", "warnings"):
        assert getattr(back, record) == getattr(frame, record), record
    assert back.sha256 == frame.sha256
    assert [p.name for p in tmp_path.iterdir()] == ["a.exr"]


def test_slices_and_fortran_arrays_are_saved_right(tmp_path):
    whole = np.random.default_rng(2).random((12, 10, 6), np.float32)
    Frame(layers={"color": np.asfortranarray(whole[::2, ::-1, 1:4])}).save(tmp_path / "s.exr")
    assert np.array_equal(Frame.load(tmp_path / "s.exr").image, whole[::2, ::-1, 1:4])


def test_other_programs_find_r_g_b_at_top_level_and_layers_by_name(tmp_path):
    frame = make()
    frame.save(tmp_path / "a.exr")
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        names = set(file.channels())
        assert np.array_equal(file.channels()["G"].pixels, frame.image[:, :, 1], equal_nan=True)
        head = json.loads(file.header()["viscache.frame"])
        assert head["fields"]["parameters"] == frame.parameters
    assert {"R", "G", "B", "position.X", "depth.V", "uv.X", "odd.4"} <= names


def test_files_of_other_programs_load(tmp_path):
    plane = np.ones((4, 5), np.float16)
    channels = {c: plane * i for i, c in enumerate(["R", "G", "B", "A", "albedo.R", "albedo.G"])}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, channels).write(str(tmp_path / "o.exr"))
    frame = Frame.load(tmp_path / "o.exr")
    assert frame.image.shape == (4, 5, 3) and frame.image[0, 0].tolist() == [0, 1, 2]
    assert frame.layers["albedo"].shape == (4, 5, 2) and frame.layers["alpha"][0, 0, 0] == 3


def test_the_digest_is_over_the_float32_pixels_of_the_colour_layer_alone():
    frame = make()
    assert frame.sha256 == hashlib.sha256(frame.image.astype("<f4").tobytes()).hexdigest()
    other = Frame(layers={"color": frame.image, "depth": np.zeros((6, 9))})
    assert other.sha256 == frame.sha256
    changed = frame.image.copy()
    changed[3, 3, 0] += 1
    assert Frame(layers={"color": changed}).sha256 != frame.sha256


def test_numpy_numbers_in_the_records_become_plain_ones():
    color = np.zeros((2, 2, 3))
    frame = Frame(layers={"color": color}, counters={"rays": np.uint64(7), "l": np.arange(2)})
    assert type(frame.counters["rays"]) is int and frame.counters["l"] == [0, 1]


@pytest.mark.parametrize(
    ("layers", "says"),
    [
        ({}, 'layers must have "color"'),
        ({"color": np.zeros(3)}, "layer color must have shape"),
        ({"color": np.zeros((2, 2, 3)), "d": np.zeros((3, 2))}, "layers must all have one size"),
        ({"color": np.zeros((2, 2, 3)), "a.b": np.zeros((2, 2))}, "without a dot"),
        # OpenEXR cuts off longer names of channels: such frames could not be read back
        ({"color": np.zeros((2, 2, 3)), "x" * 241: np.zeros((2, 2))}, "at most 240 bytes"),
        ({"color": np.zeros((2, 2, 3)), "a\0": np.zeros((2, 2))}, "must be printable"),
    ],
)
def test_bad_layers_are_refused_with_a_reason(layers, says):
    with pytest.raises(ValueError, match=says):
        Frame(layers=layers)


def test_records_that_json_cannot_hold_are_refused_by_name():
    with pytest.raises(ValueError, match=r"parameters\.a must be JSON-able, got object"):
        Frame(layers={"color": np.zeros((1, 1, 3))}, parameters={"a": object()})


def test_bad_files_and_paths_are_refused_with_a_reason(tmp_path):
    ends = r"path must end in \.exr, \.png, \.jpg, \.jpeg, got"
    for name, given, error, says in (
        *((name, {}, ValueError, ends) for name in ("a.tiff", "a", "a.exr.gz")),
        ("a.exr", {"exposure": 2}, ValueError, r"exposure must be left out for \.exr, got 2"),
        *((name, {}, OSError, "cannot write") for name in ("no/a.exr", "no/a.png")),
    ):
        with pytest.raises(error, match=says):
            make().save(tmp_path / name, **given)
    assert not list(tmp_path.iterdir())
    (tmp_path / "text.exr").write_text("hello")
    make().save(tmp_path / "a.exr")
    (tmp_path / "cut.exr").write_bytes((tmp_path / "a.exr").read_bytes()[:900])
    for name, error, says in (
        ("none.exr", FileNotFoundError, "no such file"),
        ("text.exr", ValueError, "not an OpenEXR file"),
        ("cut.exr", ValueError, r"cut\.exr"),
    ):
        with pytest.raises(error, match=says):
            Frame.load(tmp_path / name)


@pytest.mark.parametrize(
    ("suffix", "magic"),
    [(".png", b"\x89PNG"), (".jpg", b"\xff\xd8\xff"), (".JPEG", b"\xff\xd8\xff")],
)
def test_a_suffix_names_the_kind_of_file(tmp_path, suffix, magic):
    from PIL import Image

    ramp = np.linspace(0, 1, 32)[None, :, None] * np.ones((20, 1, 3))
    frame = Frame(layers={"color": ramp})
    path = tmp_path / f"a{suffix}"
    for exposure in (None, 0.5):
        frame.save(path, exposure=exposure)
        assert path.read_bytes().startswith(magic)
        seen = np.asarray(Image.open(path)).astype(int)
        off = np.abs(seen - to_srgb8(frame.image, exposure).astype(int)).max()
        assert seen.shape == (20, 32, 3) and off <= (0 if suffix == ".png" else 6)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_frame_is_its_image_to_other_libraries():
    frame = make()
    shared = np.asarray(frame)
    assert shared is frame.image and np.shares_memory(np.from_dlpack(frame), frame.image)
    assert frame.__dlpack_device__() == frame.image.__dlpack_device__()
    copy = np.array(frame)
    assert not np.shares_memory(copy, frame.image)
    np.testing.assert_array_equal(copy, frame.image)
    assert np.asarray(frame, dtype=np.float64).dtype == np.float64
    with pytest.raises(ValueError, match="copy must not be False for dtype float64"):
        frame.__array__(np.float64, copy=False)
    small = Frame(layers={"color": np.ones((2, 3, 3))})
    assert np.mean(small) == 1 and (np.asarray(small) * 2).shape == (2, 3, 3)


def test_a_notebook_shows_six_numbers_and_folds_the_rest():
    frame = make()
    frame.timings |= {"cpu_s": 0.4, "visibility_s": 0.05, "visibility_cpu_s": 0.2}
    frame.counters |= {"rays": 4, "ray_reduction": 2.5, "clamped": 0, "suppressed": 0}
    shown, folded = frame._repr_html_().split("<details>")
    assert "data:image/png;base64," in shown
    assert shown.count("<tr>") == 6 and folded.count("<tr>") == 3
    assert "3 more</summary>" in folded and "clamped" in folded
    for name in ("total_s (wall)", "cpu_s (CPU)", "visibility_s (wall)", "queries", "rays<"):
        assert name in shown, name
    assert "ray_reduction" in shown and "visibility_cpu_s (CPU)" in folded
    few = Frame(layers={"color": np.zeros((2, 2, 3))}, counters={"records": 3})
    assert "<details>" not in few._repr_html_() and "records" in few._repr_html_()


def test_the_srgb_curve_has_its_published_values():
    # IEC 61966-2-1: linear 0.5 is 187.5 / 255, linear 0.0031308 is 10.31 / 255.
    assert srgb_curve(np.array([0.0, 0.0031308, 0.5, 1.0, 7.0])) == pytest.approx(
        [0.0, 0.0404499, 0.7353570, 1.0, 1.0], abs=1e-6
    )


def test_exposure_brings_the_99th_percentile_to_one_and_black_stays_black():
    ramp = np.linspace(0, 2, 101)[None, :, None] * np.ones((1, 1, 3))
    assert auto_exposure(ramp) == pytest.approx(1 / 1.98)
    assert auto_exposure(np.zeros((4, 4, 3))) == 1.0
    spot = np.zeros((40, 40, 3))
    spot[0, 0] = 4.0
    assert auto_exposure(spot) == pytest.approx(0.25)
    assert to_srgb8(np.zeros((2, 2, 3))).max() == 0


def test_nan_pixels_are_magenta_and_infinite_ones_white():
    image = np.ones((4, 4, 3))
    image[0, 0, 1], image[0, 1, :] = np.nan, np.inf
    seen = to_srgb8(image)
    assert seen[0, 0].tolist() == [255, 0, 255] and seen[0, 1].tolist() == [255, 255, 255]


def test_the_signed_difference_is_grey_where_equal_and_brighter_where_too_bright():
    b = np.ones((3, 3, 3))
    a = b.copy()
    a[0, 0], a[1, 1] = 1 + 1 / 32, 1 - 1 / 32
    seen = difference8(a, b)
    assert (seen[2, 2, 0], seen[0, 0, 0], seen[1, 1, 0]) == (128, 192, 64)
