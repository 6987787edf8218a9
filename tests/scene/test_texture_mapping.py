# ruff: noqa: E501  (scene texts stay on their lines)
"""Checkerboards, nearest look-ups and transforms of texture coordinates."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

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
TURNED = """<transform name="to_uv"><rotate z="1" angle="20"/><scale x="3" y="1.5"/>
<translate x=".3" y=".1"/></transform>"""


def wall(folder: Path, texture: str, shape: str = "rectangle", size: float = 1) -> Path:
    path = folder / "wall.xml"
    path.write_text(
        f"""<scene version="3.0.0">{VIEW}{SKY}<shape type="{shape}"><transform name="to_world">
        <scale value="{size}"/></transform><bsdf type="diffuse">{texture}</bsdf></shape></scene>"""
    )
    return path


def albedo(path: Path, size: tuple[int, int] = (64, 48), spp: int = 16) -> Any:
    scene = vc.load_scene(path, strict=True)
    frame = vc.render(scene, vc.AmbientOcclusion(n_samples=1), spp=spp, size=size)
    return frame.layers["albedo"]


def of_mitsuba(path: Path, spp: int = 256) -> Any:
    """The albedo in Mitsuba: what a wall shows under a white sky."""
    mi: Any = pytest.importorskip("mitsuba", reason="needs the package mitsuba")
    mi.set_variant("scalar_rgb")
    by = mi.load_dict({"type": "path", "max_depth": 2, "hide_emitters": True})
    return np.array(mi.render(mi.load_file(str(path)), integrator=by, spp=spp))[:, :, :3]


def blocks(image: Any, edge: int = 8) -> Any:
    height, width, _ = image.shape
    return image.reshape(height // edge, edge, width // edge, edge, 3).mean((1, 3))


def test_the_squares_of_a_checkerboard_have_hard_edges(tmp_path: Path) -> None:
    scale = '<transform name="to_uv"><scale x="2" y="2"/></transform>'
    picture = albedo(wall(tmp_path, BOARD.format(to_uv=scale)), spp=1)
    first = np.isclose(picture, np.float32([0.8, 0.4, 0.2])).all(-1)
    second = np.isclose(picture, np.float32([0.1, 0.2, 0.3])).all(-1)
    assert (first ^ second).all(), "a pixel shows a mixture"
    # Four squares across, each 16 pixels wide; the row in the middle begins with the first colour
    changes = np.flatnonzero(np.diff(first[30].astype(int)))
    np.testing.assert_array_equal(changes, [15, 31, 47])


@pytest.mark.slow
@pytest.mark.parametrize("to_uv", ["", TURNED], ids=["plain", "turned"])
@pytest.mark.parametrize("shape", ["rectangle", "sphere"])
def test_a_checkerboard_is_mitsubas(tmp_path: Path, shape: str, to_uv: str) -> None:
    path = wall(tmp_path, BOARD.format(to_uv=to_uv), shape, 0.7 if shape == "sphere" else 1)
    ours, theirs = blocks(albedo(path, spp=64)), blocks(of_mitsuba(path))
    # A sphere is a mesh here, and its horizon a polygon
    inner = theirs.min(-1) > 0.05 if shape == "rectangle" else np.zeros(theirs.shape[:2], bool)
    if shape == "sphere":
        inner[2:4, 3:5] = True
    assert inner.sum() >= 4
    np.testing.assert_allclose(ours[inner], theirs[inner], rtol=0.04, atol=0.01)
    wrong = blocks(albedo(path, spp=64)[::-1])
    assert np.abs(wrong[inner] - theirs[inner]).max() > 0.1, "a mirrored board would pass"


@pytest.mark.slow
@pytest.mark.parametrize("filter_type", ["nearest", "bilinear"])
def test_a_transformed_image_is_mitsubas(tmp_path: Path, filter_type: str) -> None:
    from PIL import Image

    pixels = np.random.default_rng(1).integers(30, 255, (5, 7, 3)).astype(np.uint8)
    Image.fromarray(pixels).save(tmp_path / "map.png")
    texture = f"""<texture name="reflectance" type="bitmap"><string name="filename" value="map.png"/>
        <string name="filter_type" value="{filter_type}"/>{TURNED}</texture>"""
    path = wall(tmp_path, texture)
    ours, theirs = blocks(albedo(path, spp=64)), blocks(of_mitsuba(path))
    np.testing.assert_allclose(ours, theirs, rtol=0.04, atol=0.01)
    plain = wall(tmp_path, texture.replace(TURNED, ""))
    assert np.abs(blocks(albedo(plain)) - theirs).max() > 0.1


def test_old_files_scale_and_move_their_textures(tmp_path: Path) -> None:
    new = '<transform name="to_uv"><scale x="2" y="3"/><translate x=".25" y=".5"/></transform>'
    old = """<float name="uscale" value="2"/><float name="vscale" value="3"/>
        <float name="uoffset" value=".25"/><float name="voffset" value=".5"/>"""
    a, b = (albedo(wall(tmp_path, BOARD.format(to_uv=t)), spp=1) for t in (new, old))
    np.testing.assert_array_equal(a, b)
    assert (a != albedo(wall(tmp_path, BOARD.format(to_uv="")), spp=1)).any()


def pbrt_wall(folder: Path, texture: str) -> Path:
    path = folder / "wall.pbrt"
    path.write_text(
        f"""LookAt 0 0 3  0 0 0  0 1 0
        Camera "orthographic" Film "image" "integer xresolution" 64 "integer yresolution" 64
        WorldBegin
        Texture "t" "spectrum" {texture}
        Material "matte" "texture Kd" "t"
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]
            "float uv" [0 0 1 0 1 1 0 1]
        WorldEnd"""
    )
    return path


def test_pbrt_counts_whole_squares(tmp_path: Path) -> None:
    text = """"checkerboard" "rgb tex1" [.8 .4 .2] "rgb tex2" [.1 .2 .3]
        "float uscale" 4 "float vscale" 2 "float udelta" .5 """
    picture = albedo(pbrt_wall(tmp_path, text), (64, 64), spp=1)
    place = (np.arange(64) + 0.5) / 64
    u, v = 4 * place[::-1] + 0.5, 2 * place[::-1]  # pbrt's x runs to the left in this view
    even = (np.floor(u)[None] + np.floor(v)[:, None]) % 2 == 0
    want = np.where(even[..., None], [0.8, 0.4, 0.2], [0.1, 0.2, 0.3])
    np.testing.assert_allclose(picture, want, rtol=1e-5)


def test_images_of_one_material_share_their_transform(tmp_path: Path) -> None:
    from PIL import Image

    Image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "map.png")
    bitmap = (
        """<texture name="{}" type="bitmap"><string name="filename" value="map.png"/>{}</texture>"""
    )
    move = '<transform name="to_uv"><scale x="2" y="2"/></transform>'

    def load(opacity: str) -> core.SceneDescription:
        body = f"""<shape type="rectangle"><bsdf type="mask">{bitmap.format("opacity", opacity)}
            <bsdf type="diffuse">{bitmap.format("reflectance", move)}</bsdf></bsdf></shape>"""
        path = parity.write(tmp_path, body)
        return core.load_scene_file(str(path))

    assert not load(move).warnings
    [(where, text)] = load("").warnings
    assert "share one transform" in text and "scene.xml:" in where


def test_nearest_images_travel_and_count(tmp_path: Path) -> None:
    import pickle

    def scene(nearest: bool) -> vc.Scene:
        d = core.SceneDescription()
        image = d.add_image(np.float32([[[1], [0]], [[0], [1]]]), nearest=nearest)
        paint = d.add_material(base_color=(1, 1, 1), base_texture=image)
        corners = np.float32([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        uvs = np.float32([[0, 0], [1, 0], [1, 1], [0, 1]])
        d.add_mesh(corners, np.uint32([[0, 1, 2], [0, 2, 3]]), material=paint, uvs=uvs)
        return vc.Scene.from_description(d)

    hard, soft = scene(True), scene(False)
    assert hard.content_hash != soft.content_hash
    back = pickle.loads(pickle.dumps(hard))
    assert core.description_of(back._core).images[0]["nearest"]
    view = vc.orthographic((0, 0, 3), (0, 0, 0))
    for s, mixed in ((hard, False), (back, False), (soft, True)):
        shown = vc.render(s, vc.AmbientOcclusion(n_samples=1), camera=view, size=(16, 16))
        assert (np.isin(shown.layers["albedo"], (0, 1)).all()) != mixed
