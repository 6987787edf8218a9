# ruff: noqa: E501  (scene texts stay on their lines)
"""Texture coordinates of shapes whose file gives none; images of area lights on such shapes."""

import numpy as np
import pytest
from skimage.io import imsave

import viscache as vc
from viscache import _core as core
from viscache_lab.parity.exporters.formats import ply

TEXTURED = """<bsdf type="diffuse"><texture type="checkerboard" name="reflectance"/></bsdf>"""


@pytest.fixture(autouse=True)
def files(tmp_path):
    (tmp_path / "bare.ply").write_bytes(ply("bare", "ascii; $P; $F")["bare.ply"])
    rows = np.zeros((8, 8, 3), np.uint8)
    rows[:4], rows[4:] = (255, 0, 0), (0, 0, 255)
    imsave(tmp_path / "flag.png", rows, check_contrast=False)


def mitsuba(folder, body):
    (folder / "s.xml").write_text(f'<scene version="3.0.0">{body}</scene>')
    return core.load_scene_file(str(folder / "s.xml"), True)


def pbrt(folder, world):
    path = folder / "s.pbrt"
    path.write_text(
        f'LookAt 0 0 3 0 0 0 0 1 0 Camera "perspective" "float fov" 30 Film "rgb" "integer xresolution" 16 '
        f'"integer yresolution" 16 WorldBegin\n{world}\n'
    )
    return core.load_scene_file(str(path), True)


def corner_uvs(scene, mesh=0):
    """(triangles, 3, 2)."""
    arrays = scene.mesh_arrays(mesh)
    return arrays["uvs"][arrays["triangles"]]


def test_a_mesh_of_mitsuba_has_the_coordinates_of_its_triangles(tmp_path):
    shape = '<shape type="ply"><string name="filename" value="bare.ply"/>{}</shape>'
    textured = mitsuba(tmp_path, shape.format(TEXTURED))
    # Mitsuba's v grows downwards
    assert corner_uvs(textured).tolist() == [[[0, 1], [1, 1], [0, 0]]] * 2
    # Without an image, the mesh keeps its vertices
    plain = mitsuba(tmp_path, shape.format(""))
    assert len(plain.mesh_arrays(0)["vertices"]) == 4 and len(plain.mesh_arrays(0)["uvs"]) == 0


def test_a_disk_of_mitsuba_has_polar_coordinates(tmp_path):
    scene = mitsuba(tmp_path, f'<shape type="disk">{TEXTURED}</shape>')
    arrays = scene.mesh_arrays(0)
    uvs, points = arrays["uvs"], arrays["vertices"].astype(float)
    radius = np.hypot(points[:, 0], points[:, 1])
    np.testing.assert_allclose(uvs[:, 0], np.round(radius), atol=1e-6)
    rim = radius > 0.5
    angle = np.arctan2(points[rim, 1], points[rim, 0]) / (2 * np.pi)
    turns = (1 - uvs[rim, 1] - angle + 0.5) % 1 - 0.5
    np.testing.assert_allclose(turns, 0, atol=1e-6)
    plain = mitsuba(tmp_path, '<shape type="disk"/>').mesh_arrays(0)
    area = [
        np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        for m in (arrays, plain)
        for a, b, c in [m["vertices"].astype(float)[m["triangles"]].transpose(1, 0, 2)]
    ]
    assert area[0] == pytest.approx(area[1], rel=1e-6) and len(plain["vertices"]) == 65


PICTURE = 'Texture "t" "spectrum" "imagemap" "string filename" "flag.png" Material "diffuse" "texture reflectance" "t"\n'


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        (
            '"trianglemesh" "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0] "integer indices" [0 1 2 0 2 3]',
            [[[0, 0], [1, 0], [1, 1]]] * 2,
        ),
        ('"plymesh" "string filename" "bare.ply"', [[[0, 0], [1, 0], [1, 1]]] * 2),
        (
            '"bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0 2 0 0 2 1 0] "integer indices" [0 1 2 3 1 4 3 5]',
            [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]] * 2,
        ),
    ],
    ids=["triangles", "file", "patches"],
)
def test_shapes_of_pbrt_have_its_coordinates(tmp_path, shape, expected):
    assert corner_uvs(pbrt(tmp_path, f"{PICTURE}Shape {shape}")).tolist() == expected
    # A mirror turns triangles, not their coordinates
    mirrored = pbrt(tmp_path, f"{PICTURE}Scale -1 1 1 Shape {shape}")
    assert sorted(corner_uvs(mirrored).tolist()[0]) == sorted(expected[0])
    assert len(pbrt(tmp_path, f"Shape {shape}").mesh_arrays(0)["uvs"]) == 0


def test_a_disk_of_pbrt_has_the_angle_and_the_way_inwards(tmp_path):
    disk = '"disk" "float radius" 2 "float height" 1'
    arrays = pbrt(tmp_path, f"{PICTURE}Shape {disk}").mesh_arrays(0)
    points, uvs = arrays["vertices"].astype(float), arrays["uvs"]
    radius = np.hypot(points[:, 0], points[:, 1])
    np.testing.assert_allclose(uvs[:, 1], np.where(radius > 1, 0, 1), atol=1e-6)
    rim = radius > 1
    angle = np.arctan2(points[rim, 1], points[rim, 0]) / (2 * np.pi)
    np.testing.assert_allclose((uvs[rim, 0] - angle + 0.5) % 1 - 0.5, 0, atol=1e-6)
    assert (points[:, 2] == 1).all()


def test_spheres_shine_their_image(tmp_path):
    world = 'Rotate -90 1 0 0 AreaLightSource "diffuse" "string filename" "flag.png" Shape "sphere"'
    pbrt(tmp_path, world)
    ours = vc.render(vc.load_scene(tmp_path / "s.pbrt"), vc.Direct(), size=(16, 16), spp=4).image
    np.testing.assert_allclose(ours[5, 8], (1, 0, 0), atol=0.1)
    np.testing.assert_allclose(ours[10, 8], (0, 0, 1), atol=0.1)


ROTATED = (
    '<shape type="rectangle"><transform name="to_world"><rotate {} angle="40"/></transform></shape>'
)


@pytest.mark.parametrize("axis", ['y="1.2"', 'x="1" y="1"', 'x="0.6" y="0.8"'])
def test_the_length_of_a_rotations_axis_counts_as_in_mitsuba(tmp_path, axis):
    mi = pytest.importorskip("mitsuba", reason="needs the package mitsuba")
    mi.set_variant("scalar_rgb")
    (tmp_path / "s.xml").write_text(f'<scene version="3.0.0">\n{ROTATED.format(axis)}</scene>')
    scene = core.load_scene_file(str(tmp_path / "s.xml"))
    corners = scene.mesh_arrays(0)["vertices"]
    # Its round shapes disagree with its meshes: the file is warned of, once
    places = [where for where, text in scene.warnings if "no unit vector" in text]
    assert places == ([] if "0.6" in axis else [f"{tmp_path}/s.xml:2"])
    box = mi.load_file(str(tmp_path / "s.xml")).bbox()
    np.testing.assert_allclose([corners.min(0), corners.max(0)], [box.min, box.max], atol=1e-5)
    # Files of Mitsuba 0.6 turn by the direction of the axis alone
    path = tmp_path / "s.xml"
    path.write_text(path.read_text().replace("3.0.0", "0.6.0"))
    turned = core.load_scene_file(str(path), True).mesh_arrays(0)["vertices"]
    np.testing.assert_allclose(np.linalg.norm(turned, axis=1), np.sqrt(2), rtol=1e-6)
