# ruff: noqa: E501  (scene texts stay on their lines)
"""Spectra of scene files as linear sRGB: Mitsuba 3's numbers, and pbrt's own conventions."""

import numpy as np
import pytest

from viscache import _core as core

#: Spectra of lights, and what Mitsuba 3.9 (scalar_rgb) loads for them.
LIGHTS = [
    ("400:0, 500:8, 600:15.6, 700:18.4", (20.7108, 10.8546, 2.77115)),  # the Cornell box's lamp
    ("1", (1.20479, 0.948291, 0.908916)),
    ("400:1, 700:1", (1.19969, 0.94952, 0.903443)),
    ("650:1, 680:1", (0.102444, 0.0, 0.0)),
    ("380:1, 390:2, 400:3", (0.00211487, 0.0, 0.0127717)),
]
REFLECTANCES = [
    ("400:0.1, 500:.2, 600:.5, 700:.8", (0.629886, 0.321126, 0.126012)),
    ("300:.5, 900:.5", (0.499493, 0.499437, 0.499401)),
    ("400:.5, 700:.5", (0.497671, 0.499878, 0.497455)),
    ("650:1, 680:1", (0.0832815, 0.0, 0.0)),
    (".5", (0.5, 0.5, 0.5)),
]


def mitsuba_file(folder, body):
    path = folder / "scene.xml"
    path.write_text(f'<scene version="3.0.0">{body}</scene>')
    return path


def lamp(spectrum):
    return f'<shape type="rectangle"><emitter type="area">{spectrum}</emitter></shape>'


def paint(spectrum):
    return f'<shape type="rectangle"><bsdf type="diffuse">{spectrum}</bsdf></shape>'


def emitted(folder, spectrum):
    mesh = core.load_scene_file(str(mitsuba_file(folder, lamp(spectrum)))).meshes[0]
    return list(mesh["emission"])


def reflected(folder, spectrum):
    scene = core.load_scene_file(str(mitsuba_file(folder, paint(spectrum))))
    return list(scene.materials[0]["base_color"])


@pytest.mark.parametrize(("spectrum", "expected"), LIGHTS)
def test_the_spectrum_of_a_light_has_no_white_balance(tmp_path, spectrum, expected):
    found = emitted(tmp_path, f'<spectrum name="radiance" value="{spectrum}"/>')
    assert found == pytest.approx(expected, rel=1e-3, abs=1e-4)
    # Every light is read so, and not the surface beside it
    scene = core.load_scene_file(
        str(
            mitsuba_file(
                tmp_path,
                f"""<emitter type="point"><spectrum name="intensity" value="{spectrum}"/></emitter>
                <emitter type="constant"><spectrum name="radiance" value="{spectrum}"/></emitter>""",
            )
        )
    )
    point, sky = scene.lights
    assert point["intensity"] == pytest.approx(found) and sky["scale"] == pytest.approx(found)


@pytest.mark.parametrize(("spectrum", "expected"), REFLECTANCES)
def test_a_reflectance_is_seen_by_daylight(tmp_path, spectrum, expected):
    found = reflected(tmp_path, f'<spectrum name="reflectance" value="{spectrum}"/>')
    assert found == pytest.approx(expected, abs=1e-3)


def test_files_and_samples_of_spectra_are_read_as_lists_are(tmp_path):
    want = emitted(tmp_path, '<spectrum name="radiance" value="400:1, 500:2, 600:3"/>')
    (tmp_path / "lamp.spd").write_text("# nm value\n400 1\n500 2  # middle\n600 3\n")
    file = '<spectrum name="radiance" filename="lamp.spd"/>'
    regular = """<spectrum name="radiance" type="regular"><float name="wavelength_min" value="400"/>
        <float name="wavelength_max" value="600"/><string name="values" value="1, 2, 3"/></spectrum>"""
    irregular = """<spectrum name="radiance" type="irregular">
        <string name="wavelengths" value="400, 500, 600"/>
        <string name="values" value="1, 2, 3"/></spectrum>"""
    for text in (file, regular, irregular):
        assert emitted(tmp_path, text) == pytest.approx(want)
    assert emitted(tmp_path, '<spectrum name="radiance" type="d65"/>') == [1, 1, 1]
    two = '<spectrum name="radiance" type="uniform"><float name="value" value="2"/></spectrum>'
    assert emitted(tmp_path, two) == [2, 2, 2]
    with pytest.raises(core.SceneError, match="as many values as wavelengths"):
        emitted(tmp_path, irregular.replace("400, 500, 600", "400, 500"))


@pytest.mark.parametrize("kelvin", [2856, 5000, 9000])
def test_a_black_body_has_the_colour_of_its_law(tmp_path, kelvin):
    nm = np.arange(360, 831, 10)
    h, c, k = 6.62607015e-34, 299792458.0, 1.380649e-23
    m = nm * 1e-9
    law = 2 * h * c**2 / (m**5 * np.expm1(h * c / (m * k * kelvin))) * 1e-9
    pairs = ", ".join(f"{a}:{b!r}" for a, b in zip(nm.tolist(), law.tolist(), strict=True))
    want = emitted(tmp_path, f'<spectrum name="radiance" value="{pairs}"/>')
    text = f"""<spectrum name="radiance" type="blackbody">
        <float name="temperature" value="{kelvin}"/></spectrum>"""
    assert emitted(tmp_path, text) == pytest.approx(want, rel=2e-3)
    assert emitted(tmp_path, text) != pytest.approx(want[::-1], rel=2e-3)


def pbrt_colors(folder, head):
    """Reflectance and radiance of the same spectrum."""
    path = folder / "scene.pbrt"
    path.write_text(
        f"""{head} WorldBegin
        Material "matte" "spectrum Kd" [400 .4 700 .8]
        AreaLightSource "diffuse" "spectrum L" [400 .4 700 .8]
        Shape "disk"
        WorldEnd"""
    )
    scene = core.load_scene_file(str(path))
    mesh = scene.meshes[0]
    return list(scene.materials[mesh["material"]]["base_color"]), list(mesh["emission"])


def test_pbrt_v3_balances_neither_lights_nor_reflectances(tmp_path):
    """RGBSpectrum::FromSampled: the outermost values hold beyond their wavelengths."""
    long = "300:.4, 400:.4, 700:.8, 900:.8"
    want = emitted(tmp_path, f'<spectrum name="radiance" value="{long}"/>')
    base, light = pbrt_colors(tmp_path, "")
    assert base == pytest.approx(want, rel=1e-4) and light == pytest.approx(want, rel=1e-4)


def test_pbrt_v4_sees_reflectances_by_daylight_and_gives_lights_a_luminance_of_1(tmp_path):
    want = reflected(tmp_path, '<spectrum name="reflectance" value="400:.4, 700:.8"/>')
    glow = emitted(tmp_path, '<spectrum name="radiance" value="400:.4, 700:.8"/>')
    base, light = pbrt_colors(tmp_path, 'Film "rgb"')
    assert base == pytest.approx(want, rel=1e-5)
    assert np.dot(light, [0.2126, 0.7152, 0.0722]) == pytest.approx(1, rel=1e-5)
    assert np.divide(light, light[1]) == pytest.approx(np.divide(glow, glow[1]), rel=1e-5)
