"""The clear sky and its sun: the formulas, Mitsuba 3's `sunsky`, and `vc.Sky`."""

import numpy as np
import pytest

import viscache as vc
from viscache import _core

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def tilted(elevation_deg, azimuth_deg=0.0):
    e, a = np.radians(elevation_deg), np.radians(azimuth_deg)
    return float(np.cos(e) * np.cos(a)), float(np.sin(e)), float(np.cos(e) * np.sin(a))


def upper_half(n):
    """Directions (n · 2n, 3) of equal solid angle above the horizon, and that angle."""
    heights, turns = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(2 * n) + 0.5) / n * np.pi)
    flat = np.sqrt(1 - heights**2)
    d = np.stack([flat * np.cos(turns), heights, flat * np.sin(turns)], -1).reshape(-1, 3)
    return d, 2 * np.pi / len(d)


#: Lumen per W/nm of RGB: the integral of CIE y in nm times 683 lm/W.
LUMEN = 106.75 * 683


@pytest.mark.parametrize("elevation", [20.0, 30.0, 50.0, 70.0])
def test_illuminance_is_that_of_a_clear_day(elevation):
    """The clear sky of the IES (1984): direct normal and diffuse horizontal, in klx."""
    sky = vc.Sky(sun_direction=tilted(elevation), turbidity=2.5, albedo=0.0)
    height = np.sin(np.radians(elevation))
    direct = float(sky.sun_irradiance @ LUMINANCE) * LUMEN / 1000
    assert direct == pytest.approx(127.5 * np.exp(-0.21 / height), rel=0.1)
    d, solid_angle = upper_half(64)
    diffuse = float((sky.radiance(d) @ LUMINANCE * d[:, 1]).sum() * solid_angle) * LUMEN / 1000
    assert diffuse == pytest.approx(0.8 + 15.5 * height**0.5, rel=0.2)


@pytest.mark.parametrize("elevation", [3.0, 45.0])
def test_the_image_holds_the_energy_of_the_sky(elevation):
    sky = vc.Sky(sun_direction=tilted(elevation, 130), turbidity=3.0, sky_scale=2.0)
    d, solid_angle = upper_half(512)
    expected = sky.radiance(d).astype(np.float64).sum(0) * solid_angle
    pixels = sky.image(512).astype(np.float64)
    edges = np.cos(np.linspace(0, np.pi, 257))
    weights = (edges[:-1] - edges[1:]) * 2 * np.pi / 512
    found = (pixels * weights[:, None, None]).sum((0, 1))
    np.testing.assert_allclose(found, expected, rtol=2e-3)
    assert np.all(pixels[128:] == 0) and np.all(pixels[:128] > 0)
    # The environment of a scene holds the same, and the sun its irradiance
    scene = vc.Scene.from_arrays([[0, 0, 0], [0, 0, 1], [1, 0, 0]], [[0, 1, 2]], env=sky)
    sun = next(light for light in scene.lights if light["kind"] == "directional")
    np.testing.assert_allclose(sun["direction"], sky.sun_direction, atol=1e-6)
    np.testing.assert_allclose(sun["irradiance"], sky.sun_irradiance, rtol=1e-6)


def test_up_turns_the_sky_with_its_sun():
    plain = vc.Sky(sun_direction=(0.6, 0.64, 0.48))
    turned = vc.Sky(sun_direction=(0.6, -0.48, 0.64), up=(0, 0, 1))
    assert turned.elevation_deg == pytest.approx(plain.elevation_deg)
    d, _ = upper_half(8)
    there = d @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # y becomes z
    np.testing.assert_allclose(turned.radiance(there), plain.radiance(d), rtol=1e-4)
    corners, one = [[-9, 0, -9], [-9, 0, 9], [9, 0, 0]], [[0, 1, 2]]
    floors = [(corners, plain), (np.array(corners) @ [[1, 0, 0], [0, 0, 1], [0, -1, 0]], turned)]
    seen = []
    for points, env in floors:
        scene = vc.Scene.from_arrays(points, one, env=env)
        view = vc.look_at(np.multiply(env.up, 3), (0.01, 0, 0), up=(1, 0, 0))
        seen.append(vc.render(scene, vc.Direct(), size=(8, 8), spp=64, camera=view).image.mean())
    assert seen[0] == pytest.approx(seen[1], rel=0.01) and seen[0] > 0.1


def test_a_sun_below_the_horizon_gives_no_light():
    night = vc.Sky(sun_direction=(1, -0.1, 0))
    assert np.all(night.image(64) == 0) and np.all(night.sun_irradiance == 0)
    scene = vc.Scene.from_arrays([[0, 0, 0], [0, 0, 1], [1, 0, 0]], [[0, 1, 2]], env=night)
    assert scene.lights == [] and any("no light" in w for w in scene.warnings)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"turbidity": 0.5}, r"turbidity must be in \[1, 10\]"),
        ({"albedo": 1.5}, "albedo must be"),
        ({"sun_direction": (0, 0, 0)}, "sun_direction must be"),
        ({"up": (0, float("nan"), 0)}, "up must be"),
        ({"sun_scale": -1}, "sun_scale must be"),
    ],
)
def test_settings_out_of_range_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        vc.Sky(**given)


def test_the_sun_stands_where_almanacs_say():
    """Noon heights: 90° − latitude ± 23.44° at the solstices, within half a degree."""
    place = {"latitude": 51.48, "longitude": 0.0, "timezone": 0}
    for date, expected in (((2012, 6, 21), 61.96), ((2012, 12, 21), 15.08)):
        sky = vc.Sky.at(**place, date=date, hour=12.0)
        assert sky.elevation_deg == pytest.approx(expected, abs=0.2)
        assert abs(sky.sun_direction[0]) < 0.03 and sky.sun_direction[2] > 0  # south is +z
    morning = vc.Sky.at(**place, date=(2012, 6, 21), hour=6.0)
    assert morning.sun_direction[0] > 0.8  # east is +x
    with pytest.raises(ValueError, match="a date must exist, got 2012-2-30"):
        vc.Sky.at(**place, date=(2012, 2, 30), hour=6.0)


def test_sweeps_take_skies():
    scene = vc.scenes.build("slats")
    over = {"integrator.n_environment": [1, 2]}
    found = vc.sweep(scene, vc.Direct(), over=over, env=vc.Sky(), size=(8, 6))
    assert found.sizes["n_environment"] == 2


def mitsuba():
    mi = pytest.importorskip("mitsuba", reason="needs the package mitsuba")
    mi.set_variant("scalar_rgb")
    return mi


def of_mitsuba(mi, emitter, d):
    """Radiance from directions whose z points up."""
    si = mi.SurfaceInteraction3f()
    out = []
    for direction in d:
        si.wi = mi.Vector3f(*(float(-v) for v in direction))
        out.append(np.array(emitter.eval(si)))
    return np.array(out)


@pytest.mark.mitsuba
@pytest.mark.parametrize("turbidity", [1.0, 3.7, 10.0])
@pytest.mark.parametrize("elevation", [0.5, 20.0, 88.0])
def test_radiance_and_sun_are_those_of_mitsuba(turbidity, elevation):
    mi = mitsuba()
    sun = np.array(tilted(elevation, 50))
    up = sun[[2, 0, 1]].tolist()  # z up: x, y, z = our z, x, y
    albedo = {"type": "rgb", "value": [0.1, 0.4, 0.8]}
    common = {"type": "sunsky", "sun_direction": up, "turbidity": turbidity, "albedo": albedo}
    d, _ = upper_half(6)
    expected = of_mitsuba(mi, mi.load_dict(common | {"sun_scale": 0.0}), d[:, [2, 0, 1]])
    sky = vc.Sky(sun_direction=tuple(sun), turbidity=turbidity, albedo=(0.1, 0.4, 0.8))
    np.testing.assert_allclose(sky.radiance(d), np.maximum(expected, 0), rtol=2e-3, atol=1e-5)
    disk = of_mitsuba(mi, mi.load_dict(common | {"sky_scale": 0.0}), [up])[0]
    solid_angle = 2 * np.pi * (1 - np.cos(np.radians(0.5358 / 2)))
    expected = np.maximum(disk * solid_angle, 0)
    np.testing.assert_allclose(sky.sun_irradiance, expected, rtol=2e-4, atol=1e-5)


@pytest.mark.mitsuba
def test_the_time_gives_the_direction_of_mitsuba():
    mi = mitsuba()
    for given in ({}, {"hour": 9.5, "latitude": 48.2, "longitude": 16.4, "timezone": 2.0}):
        emitter = mi.load_dict({"type": "sunsky"} | given)
        x, y, z = (float(v) for v in mi.traverse(emitter)["sun_direction"])
        time = {"hour": 15.0, "latitude": 35.6894, "longitude": 139.6917, "timezone": 9.0} | given
        east, up, north = _core.sun_direction(year=2010, month=7, day=10, **time)
        np.testing.assert_allclose((-north, -east, up), (x, y, z), atol=2e-3)


VIEW = """<sensor type="perspective"><float name="fov" value="60"/>
<transform name="to_world"><lookat origin="0,-6,3" target="0,0,0.7" up="0,0,1"/></transform>
<film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/>
<rfilter type="box"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><scale value="5"/></transform>
<bsdf type="diffuse"/></shape>
<shape type="cube"><transform name="to_world"><scale value="0.6"/>
<translate x="-0.5" z="0.6"/></transform></shape>"""


@pytest.mark.slow
@pytest.mark.mitsuba
@pytest.mark.parametrize(
    "light",
    [
        '<vector name="sun_direction" x="0.5" y="-0.6" z="0.6"/>',
        '<vector name="sun_direction" x="-1" y="0.2" z="0.15"/><float name="turbidity" value="6"/>'
        '<float name="sky_scale" value="2"/><float name="sun_scale" value="0.3"/>',
        '<float name="hour" value="16"/><rgb name="albedo" value="0.6,0.3,0.1"/>'
        '<transform name="to_world"><rotate z="1" angle="70"/></transform>',
    ],
    ids=["high", "low", "time"],
)
def test_a_picture_under_a_sky_is_mitsubas(tmp_path, light):
    from scene.test_mitsuba_parity import agreement
    from scene.test_mitsuba_parity import of_mitsuba as pictures_of_mitsuba
    from scene.test_mitsuba_parity import of_viscache as pictures

    mitsuba()
    path = tmp_path / "sky.xml"
    emitter = f'<emitter type="sunsky">{light}</emitter>'
    path.write_text(f'<scene version="3.0.0">{VIEW}{emitter}</scene>')
    assert not vc.load_scene(path).warnings
    ours, theirs = pictures(path), pictures_of_mitsuba(path)
    assert agreement(ours, theirs) >= 0.95
    assert np.mean(ours) == pytest.approx(np.mean(theirs), rel=0.01)
    assert agreement(np.multiply(ours, 1.05), theirs) < 0.9


# Mitsuba 0.6 has no renderer here: its conventions are checked on what is loaded


def of_old_file(tmp_path, kind, body):
    path = tmp_path / "old.xml"
    rectangle = '<shape type="rectangle"/>'
    text = f'<scene version="0.6.0">{rectangle}<emitter type="{kind}">{body}</emitter></scene>'
    path.write_text(text)
    return _core.load_scene_file(str(path))


def test_skies_of_older_files_have_y_up_and_their_names(tmp_path):
    body = '<vector name="sunDirection" x="0.6" y="0.64" z="0.48"/>'
    scales = '<float name="sunScale" value="2"/><float name="skyScale" value="0.5"/>'
    scene = of_old_file(tmp_path, "sunsky", body + scales + '<float name="turbidity" value="4"/>')
    sun, sky = scene.lights
    np.testing.assert_allclose(sun["direction"], (0.6, 0.64, 0.48), atol=1e-6)
    model = vc.Sky(sun_direction=(0.6, 0.64, 0.48), turbidity=4, albedo=0.2, sun_scale=2)
    np.testing.assert_allclose(sun["irradiance"], model.sun_irradiance, rtol=1e-6)
    assert sky["scale"] == [0.5, 0.5, 0.5] and scene.images[sky["image"]]["width"] == 1024
    assert any("Mitsuba 0.6" in what for _, what in scene.warnings)
    (alone,) = of_old_file(tmp_path, "sky", body).lights
    assert alone["kind"] == "environment"
    (alone,) = of_old_file(tmp_path, "sun", body).lights
    assert alone["kind"] == "directional"


def test_errors_of_a_sky_name_the_line(tmp_path):
    with pytest.raises(vc.SceneError, match=r"old.xml:1: turbidity must be in \[1, 10\]"):
        of_old_file(tmp_path, "sky", '<float name="turbidity" value="20"/>')
    below = of_old_file(tmp_path, "sky", '<vector name="sunDirection" x="1" y="-0.5" z="0"/>')
    assert any("below the horizon" in what for _, what in below.warnings)
    assert below.lights == []
