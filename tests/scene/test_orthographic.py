"""Orthographic cameras: parallel rays in every integrator, from Python and from files."""

import json

import numpy as np
import pytest

import viscache as vc
from render.ztest import compare
from viscache import _core as core
from viscache_lab.parity.exporters.formats import gltf

SIZE = (24, 16)
#: A room without a front: a floor, a wall, a box and a lamp, seen from above and aside.
ROOM = """<scene version="3.0.0"><sensor type="orthographic"><transform name="to_world">
<scale x="2.5" y="2.5"/><lookat origin="3,4,6" target="0,0.7,0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/>
<rfilter type="box"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><scale value="2"/><rotate x="1" angle="-90"/>
</transform><bsdf type="twosided"><bsdf type="diffuse">
<rgb name="reflectance" value=".7,.6,.5"/></bsdf></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><scale value="2"/><translate z="-1.5" y="1"/>
</transform><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>
<shape type="cube"><transform name="to_world"><scale value=".4"/><rotate y="1" angle="30"/>
<translate y=".4"/></transform><bsdf type="diffuse"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value=".5"/><rotate x="1" angle="90"/>
<translate y="2.2"/></transform><emitter type="area"><rgb name="radiance" value="9,8,7"/></emitter>
</shape></scene>"""


@pytest.fixture
def room(tmp_path):
    path = tmp_path / "room.xml"
    path.write_text(ROOM)
    return path


def images(path, integrator, spp, seeds, **settings):
    scene = vc.load_scene(path, strict=True)
    frames = [vc.render(scene, integrator, spp=spp, seed=s, **settings) for s in range(seeds)]
    return np.stack([f.image for f in frames]).astype(np.float64)


@pytest.mark.slow
@pytest.mark.stat
def test_paths_from_the_light_reach_the_camera_with_their_weight(room):
    base = images(room, vc.Bdpt(max_depth=4, camera_connections="off"), 64, 8)
    scene = vc.load_scene(room)
    frames = [vc.render(scene, vc.Bdpt(max_depth=4), spp=64, seed=s) for s in range(8)]
    full = np.stack([f.image for f in frames]).astype(np.float64)
    assert compare(full, base).same
    without = np.stack([f.image - f.layers["camera"] for f in frames]).astype(np.float64)
    assert not compare(without, base).same, "light paths that end at the camera carry nothing"


def test_pixels_are_equal_squares_whatever_their_distance():
    floor = ([[-4, 0, -4], [4, 0, -4], [4, 0, 4], [-4, 0, 4]], [[0, 2, 1], [0, 3, 2]], (1, 0, 0))
    table = ([[0, 3, 0], [1, 3, 0], [1, 3, 1], [0, 3, 1]], [[0, 2, 1], [0, 3, 2]], (0, 1, 0))
    scene = vc.Scene.from_arrays([floor, table])
    plan = vc.orthographic((0, 5, 0), (0, 0, 0), up=(0, 0, -1), height=4)
    frame = vc.render(scene, vc.AmbientOcclusion(n_samples=1), camera=plan, size=(16, 8))
    albedo = frame.layers["albedo"]
    # Half a unit per pixel: x ∈ [-4, 4], z ∈ [-2, 2] downwards
    green = np.zeros((8, 16), bool)
    green[4:6, 8:10] = True
    np.testing.assert_array_equal(albedo[:, :, 1] == 1, green)
    np.testing.assert_allclose(frame.layers["depth"][green], 2, rtol=1e-5)
    pinhole = vc.look_at((0, 5, 0), (0, 0, 0), up=(0, 0, -1), fov_deg=43.6)
    other = vc.render(scene, vc.AmbientOcclusion(n_samples=1), camera=pinhole, size=(16, 8))
    assert (other.layers["albedo"][:, :, 1] == 1).sum() > 4


def test_every_integrator_and_cache_takes_the_camera():
    scene = vc.scenes.cube_on_plane()
    view = vc.orthographic((3, 4, 5), (0, 0.5, 0), height=3)
    exact = vc.render(scene, vc.Direct(), camera=view, size=SIZE, spp=4)
    for visibility in (vc.Aqvc(c_e=2, exact_groups=()), vc.ShadowMap(), vc.NeePlusPlus()):
        frame = vc.render(scene, vc.Direct(), visibility=visibility, camera=view, size=SIZE, spp=4)
        assert frame.image.mean() == pytest.approx(exact.image.mean(), rel=0.1), visibility
    for integrator in (vc.Whitted(n_vpls=16), vc.AmbientOcclusion(), vc.Bdpt(max_depth=3)):
        frame = vc.render(scene, integrator, camera=view, size=SIZE)
        assert np.isfinite(frame.image).all() and frame.image.mean() > 0
    cached = vc.render(scene, vc.Bdpt(max_depth=3), visibility=vc.Aqvc(), camera=view, size=SIZE)
    assert np.isfinite(cached.image).all()


def test_the_density_of_eye_points_is_that_of_the_plane():
    """Cells hold as many eye samples as for a pinhole: C_E² each."""
    scene = vc.scenes.cube_on_plane()
    rays = []
    for view in (
        vc.orthographic((3, 4, 5), (0, 0.5, 0), height=3),
        vc.look_at((60, 75, 100), (0, 0.5, 0), fov_deg=1.23),
    ):
        cache = vc.Aqvc(c_e=4, exact_groups=())
        frame = vc.render(scene, vc.Direct(), visibility=cache, camera=view, size=SIZE, spp=4)
        rays.append(frame.counters["rays"])
    assert rays[0] == pytest.approx(rays[1], rel=0.05)


def camera_of(path, text):
    path.write_text(text)
    return core.load_scene_file(str(path), True).cameras[0]


def test_files_say_how_much_the_camera_sees(tmp_path):
    view = "LookAt 0 0 5  0 0 0  0 1 0"
    film = 'Film "image" "integer xresolution" 200 "integer yresolution" 100 WorldBegin WorldEnd'
    pbrt = tmp_path / "s.pbrt"
    one = camera_of(pbrt, f'{view} Camera "orthographic" {film}')
    assert (one["view_height"], one["horizontal"]) == (2, False)
    scaled = camera_of(pbrt, f'Scale .25 .25 1 {view} Camera "orthographic" {film}')
    assert scaled["view_height"] == pytest.approx(8)
    window = '"float screenwindow" [0 4 -1 1]'
    aside = camera_of(pbrt, f'{view} Camera "orthographic" {window} {film}')
    assert aside["view_height"] == 2
    np.testing.assert_allclose(
        np.subtract(aside["origin"], one["origin"]), 2 * np.array(one["right"]), atol=1e-6
    )
    wide = camera_of(
        pbrt,
        f'{view} Camera "perspective" "float fov" 90 "float screenwindow" [-1 1 -.5 .5] {film}',
    )
    assert wide["fov_deg"] == pytest.approx(np.degrees(2 * np.arctan(0.5)), rel=1e-5)
    with pytest.raises(core.SceneError, match="pixels that are not square"):
        camera_of(pbrt, f'{view} Camera "orthographic" "float screenwindow" [-1 1 -1 1] {film}')

    xml = camera_of(tmp_path / "s.xml", ROOM)
    assert (xml["view_height"], xml["horizontal"]) == (5, True)
    with pytest.raises(core.SceneError, match="pixels that are not square"):
        camera_of(tmp_path / "s.xml", ROOM.replace('x="2.5" y="2.5"', 'x="2.5" y="2"'))

    lens = {"xmag": 3, "ymag": 1.5, "znear": 0.1, "zfar": 9}
    change = {"camera": {"orthographic": lens}, "eye": {"translation": [1, 2, 3]}}
    text = gltf("s", json.dumps(change))["s.gltf"].decode()
    found = camera_of(tmp_path / "s.gltf", text)
    assert (found["view_height"], found["width"], found["height"]) == (3, 960, 480)
    np.testing.assert_allclose(found["origin"], [1, 2, 3])


@pytest.mark.parametrize("point", [None, 3, "abc", (1, 2), (1, "x", 2), (1, 2, True), [[1, 2, 3]]])
def test_points_of_cameras_must_be_three_numbers(point):
    with pytest.raises(ValueError, match="target must be 3 numbers"):
        vc.look_at((0, 0, 0), point)
    with pytest.raises(ValueError, match="origin must be 3 numbers"):
        vc.orthographic(point, (0, 0, 0))


@pytest.mark.parametrize("value", ["x", None, True, 1j, [45], float("nan")])
def test_angles_and_heights_of_cameras_must_be_numbers(value):
    with pytest.raises(ValueError, match="fov_deg must be in"):
        vc.look_at((0, 0, 1), (0, 0, 0), fov_deg=value)
    for height in (value, 0, -1, float("inf")):
        with pytest.raises(ValueError, match="height must be > 0 and finite"):
            vc.orthographic((0, 0, 1), (0, 0, 0), height=height)
