"""Checkerboards, nearest look-ups and transforms of texture coordinates."""

import numpy as np

import viscache as vc
from scene import test_mitsuba_parity as parity
from viscache import _core as core

SKY = '<emitter type="constant"><rgb name="radiance" value="1"/></emitter>'
#: A wall that fills the picture of 64 x 48 pixels, one unit of texture coordinates wide.
VIEW = """<sensor type="orthographic"><transform name="to_world"><scale x="1" y="1"/>
<lookat origin="0,0,3" target="0,0,0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/>
<rfilter type="box"/></film></sensor>"""
BOARD = """<texture name="reflectance" type="checkerboard"><rgb name="color0" value=".8,.4,.2"/>
<rgb name="color1" value=".1,.2,.3"/>{to_uv}</texture>"""


def wall(folder, texture):
    path = folder / "wall.xml"
    shape = f'<shape type="rectangle"><bsdf type="diffuse">{texture}</bsdf></shape>'
    path.write_text(f'<scene version="3.0.0">{VIEW}{SKY}{shape}</scene>')
    return path


def albedo(path):
    scene = vc.load_scene(path, strict=True)
    frame = vc.render(scene, vc.AmbientOcclusion(n_samples=1), spp=1, size=(64, 48))
    return frame.layers["albedo"]


def test_the_squares_of_a_checkerboard_have_hard_edges(tmp_path):
    scale = '<transform name="to_uv"><scale x="2" y="2"/></transform>'
    picture = albedo(wall(tmp_path, BOARD.format(to_uv=scale)))
    first = np.isclose(picture, np.float32([0.8, 0.4, 0.2])).all(-1)
    second = np.isclose(picture, np.float32([0.1, 0.2, 0.3])).all(-1)
    assert (first ^ second).all(), "a pixel shows a mixture"
    # Four squares across, each 16 pixels wide; the row in the middle begins with the first colour
    changes = np.flatnonzero(np.diff(first[30].astype(int)))
    np.testing.assert_array_equal(changes, [15, 31, 47])


def test_old_files_scale_and_move_their_textures(tmp_path):
    new = '<transform name="to_uv"><scale x="2" y="3"/><translate x=".25" y=".5"/></transform>'
    old = """<float name="uscale" value="2"/><float name="vscale" value="3"/>
        <float name="uoffset" value=".25"/><float name="voffset" value=".5"/>"""
    a, b = (albedo(wall(tmp_path, BOARD.format(to_uv=t))) for t in (new, old))
    np.testing.assert_array_equal(a, b)
    assert (a != albedo(wall(tmp_path, BOARD.format(to_uv="")))).any()


def test_images_of_one_material_share_their_transform(tmp_path):
    from PIL import Image

    Image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "map.png")
    bitmap = (
        """<texture name="{}" type="bitmap"><string name="filename" value="map.png"/>{}</texture>"""
    )
    move = '<transform name="to_uv"><scale x="2" y="2"/></transform>'

    def load(opacity):
        body = f"""<shape type="rectangle"><bsdf type="mask">{bitmap.format("opacity", opacity)}
            <bsdf type="diffuse">{bitmap.format("reflectance", move)}</bsdf></bsdf></shape>"""
        path = parity.write(tmp_path, body)
        return core.load_scene_file(str(path))

    assert not load(move).warnings
    [(where, text)] = load("").warnings
    assert "share one transform" in text and "scene.xml:" in where
