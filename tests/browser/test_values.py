"""What the report's script unpacks and computes is what NumPy does, on coloured pictures."""

import numpy as np
import pytest

from reference import report_pictures as packed
from viscache import report
from viscache.base import tonemap

pytestmark = pytest.mark.browser


@pytest.fixture
def pair(tab, tmp_path):
    """Codes of two coloured pictures on an open page, some below 0."""
    rng = np.random.default_rng(0)
    reference = rng.uniform(0, 2, (9, 14, 3)) ** 3
    image = reference * rng.uniform(0.5, 1.5, (9, 14, 3)) - 0.01
    page = report.write_difference(image, reference, tmp_path / "p.html", flip_map=False)
    data = packed.model(page.read_text("utf-8"))
    tab.open(page)
    tab.wait_for("document.documentElement.dataset.shown === 's0 signed'")
    return {
        "a": packed.picture(data, data["settings"][0]),
        "b": packed.reference(data, "reference"),
    }


def test_pictures_are_unpacked_bit_for_bit(tab, pair):
    for name, codes in (("picture", pair["a"]), ("reference", pair["b"])):
        np.testing.assert_array_equal(tab.eval(f"[...shown.{name}]"), codes.ravel())
    values = tab.eval("[...shown.picture].map(valueOf)")
    np.testing.assert_array_equal(values, packed.values(pair["a"]).ravel())
    assert min(values) < 0 < max(values)


def test_maps_are_computed_from_radiance(tab, pair):
    a, b = (packed.values(pair[k]) for k in "ab")
    error = np.abs(a - b).mean(2)
    expected = {
        "signed": tonemap.luminance(a) - tonemap.luminance(b),
        "absolute": error,
        "relative": error / (np.abs(b).mean(2) + 0.01 * np.abs(b).mean()),
    }
    for kind, values in expected.items():
        found = tab.eval(f"[...MAPS.{kind}.values(shown.picture, shown.reference)]")
        np.testing.assert_allclose(found, values.ravel(), rtol=1e-5, atol=1e-7)


def test_each_channel_has_its_difference_around_grey(tab, pair):
    found = np.reshape(
        tab.eval(
            "(o => { paintChannels(o, shown.picture, shown.reference, 4); return [...o] })"
            "(new Uint8ClampedArray(9 * 14 * 4))"
        ),
        (9, 14, 4),
    )
    delta = packed.values(pair["a"]) - packed.values(pair["b"])
    expected = 127.5 + 127.5 * np.clip(4 * delta, -1, 1)
    assert np.abs(found[:, :, :3] - expected).max() <= 0.51 and (found[:, :, 3] == 255).all()
    assert np.abs(np.diff(found[:, :, :3], axis=2)).max() > 50


def test_coarse_pictures_are_unpacked_by_their_step(tab, pair):
    from viscache.report import pictures

    text = pictures.pack_difference(pair["a"].astype(np.int32), pair["b"].astype(np.int32), 16)
    found = tab.eval(f"unpackDifference('{text}', shown.reference, 16).then(c => [...c])")
    steps = packed.unpack(text, 14).astype(int)
    np.testing.assert_array_equal(found, (pair["b"] + 16 * steps).ravel())
