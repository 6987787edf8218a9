"""Crops, offsets of the principal point, screen windows beside the axis: parts of wider films."""

import pickle

import numpy as np
import pytest

import viscache as vc
from viscache import _core as core
from viscache.scene.cameras import camera_in_words
from viscache_lab.parity import blocks

#: A box under an even sky, and a lamp: every pixel sees something else.
ROOM = """<scene version="3.0.0"><sensor type="{kind}">{more}<transform name="to_world">{scale}
<lookat origin="1.5,2.5,4" target="0,0.4,0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="32"/>{film}
<rfilter type="box"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/>
</transform><bsdf type="diffuse"><texture type="checkerboard" name="reflectance">
<transform name="to_uv"><scale x="5" y="5"/></transform></texture></bsdf></shape>
<shape type="cube"><transform name="to_world"><scale value=".5"/><rotate y="1" angle="30"/>
<translate x=".3" y=".5"/></transform></shape>
<shape type="rectangle"><transform name="to_world"><scale value=".4"/><rotate x="1" angle="90"/>
<translate y="2.5"/></transform><emitter type="area"><rgb name="radiance" value="9,8,7"/></emitter>
</shape></scene>"""
FOV = '<float name="fov" value="50"/>'
#: x and y from, width, height.
CROP = (20, 4, 24, 16)
CROPPED = "".join(
    f'<integer name="crop_{name}" value="{value}"/>'
    for name, value in zip(("offset_x", "offset_y", "width", "height"), CROP, strict=True)
)
OFFSET = "".join(
    f'<float name="principal_point_offset_{axis}" value="{value}"/>'
    for axis, value in (("x", 0.2), ("y", -0.1))
)


def room(folder, *, more="", film="", kind="perspective", scale=""):
    path = folder / "room.xml"
    path.write_text(ROOM.format(kind=kind, more=FOV + more, film=film, scale=scale))
    return path


def pictures(path, integrator, spp=64, seeds=8):
    scene = vc.load_scene(path, strict=True)
    made = [vc.render(scene, integrator, spp=spp, seed=s).image for s in range(seeds)]
    return np.stack(made).astype(np.float64)


def in_blocks(ours, theirs):
    """Hard edges make the noise of single pixels far from normal."""
    mine, other = ([blocks.block_means(p, 4) for p in side] for side in (ours, theirs))
    return blocks.compare(mine, other)


def test_a_crop_is_that_part_of_the_picture(tmp_path):
    x, y, width, height = CROP
    for kind, scale in (("perspective", ""), ("orthographic", '<scale value="2"/>')):
        whole = pictures(room(tmp_path, kind=kind, scale=scale), vc.Direct(), 16, 6)
        part = pictures(room(tmp_path, kind=kind, scale=scale, film=CROPPED), vc.Direct(), 16, 6)
        assert part.shape[1:3] == (height, width)
        expected = whole[:, y : y + height, x : x + width]
        assert in_blocks(part, expected).agrees
        assert not in_blocks(part, np.roll(expected, 1, axis=2)).agrees


@pytest.mark.slow
@pytest.mark.stat
def test_light_paths_reach_the_right_pixel(tmp_path):
    """Connections with the camera go from points to pixels, all others from pixels to points."""
    path = room(tmp_path, more=OFFSET, film=CROPPED)
    on = pictures(path, vc.Bdpt(max_depth=3))
    off = pictures(path, vc.Bdpt(max_depth=3, camera_connections="off"))
    assert in_blocks(on, off).agrees
    assert not in_blocks(np.roll(on, 1, axis=1), off).agrees


def camera_of(path, text):
    path.write_text(text)
    return core.load_scene_file(str(path), True).cameras[0]


def test_pbrts_windows_and_crops_are_the_same_cameras(tmp_path):
    path = tmp_path / "s.pbrt"
    view = 'LookAt 1 2 3 0 0 0 0 1 0 Camera "perspective" "float fov" 90 '
    film = 'Film "image" "integer xresolution" 40 "integer yresolution" 20 '
    world = "WorldBegin WorldEnd"
    whole = camera_of(path, f"{view}{film}{world}")
    assert list(whole["shift"]) == [0, 0] and whole["fov_deg"] == pytest.approx(90)
    # The right half of the film, then its lower half
    half = camera_of(path, f'{view}{film}"float cropwindow" [.5 1 0 1] {world}')
    assert (half["width"], half["height"]) == (20, 20)
    assert half["shift"] == pytest.approx([0.5, 0]) and half["fov_deg"] == pytest.approx(90)
    lower = camera_of(path, f'{view}{film}"integer pixelbounds" [0 40 10 20] {world}')
    assert lower["shift"] == pytest.approx([0, -0.5])
    assert lower["fov_deg"] == pytest.approx(np.degrees(2 * np.arctan(0.5)))
    window = camera_of(path, f'{view}"float screenwindow" [0 4 -1 1] {film}{world}')
    assert window["shift"] == pytest.approx([0.5, 0]) and window["fov_deg"] == pytest.approx(90)
    with pytest.raises(core.SceneError, match="the crop has no pixels"):
        camera_of(path, f'{view}{film}"float cropwindow" [.5 .5 0 1] {world}')
    xml = ROOM.format(kind="perspective", more=FOV, film=CROPPED.replace("24", "40"), scale="")
    with pytest.raises(core.SceneError, match="the crop must lie on the film"):
        camera_of(tmp_path / "s.xml", xml)


def test_a_shift_changes_the_scene_and_is_said(tmp_path):
    shifted, plain = vc.load_scene(room(tmp_path, more=OFFSET)), vc.load_scene(room(tmp_path))
    assert shifted.content_hash != plain.content_hash
    camera = pickle.loads(pickle.dumps(shifted)).cameras[0]
    assert (camera.shift_x, camera.shift_y) == (pytest.approx(0.2), pytest.approx(0.1))
    assert camera_in_words(camera)["shift_x"] == pytest.approx(0.2)
    assert "shift_x" not in camera_in_words(plain.cameras[0])


NEAR, FAR = '<float name="near_clip" value="{}"/>', '<float name="far_clip" value="{}"/>'


def warned(folder, more, **rest):
    return vc.load_scene(room(folder, more=f"\n{more}", **rest)).warnings


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_planes_that_cut_the_picture_are_warned_of(tmp_path, kind):
    scale = '<scale value="2"/>' if kind == "orthographic" else ""
    for more, text in (
        (NEAR.format(4), "the near plane is not modelled; what lies before it is seen"),
        (FAR.format(4), "the far plane is not modelled; what lies behind it is seen"),
    ):
        assert not warned(tmp_path, NEAR.format(0.1) + FAR.format(100), kind=kind, scale=scale)
        (warning,) = warned(tmp_path, more, kind=kind, scale=scale)
        assert "room.xml:2" in warning and text in warning
    # Before the plane, but outside of the picture
    narrow = NEAR.format(3.5) + '<float name="fov" value="5"/>'
    if kind == "perspective":
        path = room(tmp_path, more=narrow)
        path.write_text(path.read_text().replace(FOV, "", 1))
        assert not vc.load_scene(path).warnings
