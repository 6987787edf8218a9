"""Colours of vertices and faces in files: glTF, PLY, OBJ, Mitsuba, pbrt."""

import numpy as np
import pytest
import trimesh

import viscache as vc
from scene.test_colors import STEP
from viscache_lab.parity.exporters.formats import ply

RGB = "float r 1, float g .2, float b 0"
INDICES = "list uchar int vertex_indices"


def write(folder, colors, faces="$F"):
    """A square whose vertices have properties of colour."""
    change = f"ascii; vertex 4 float x, float y, float z{colors and ', '}{colors}; {faces}"
    (folder / "a.ply").write_bytes(ply("a", change)["a.ply"])


def test_colors_above_one_are_clamped(tmp_path):
    write(tmp_path, RGB.replace("1", "1.5"))
    assert vc.load_scene(tmp_path / "a.ply").meshes()[0]["colors"][0, 0] == 1


def test_trimesh_and_the_reader_show_the_same_scan(tmp_path):
    shape = trimesh.creation.icosphere(subdivisions=1)
    shape.visual.vertex_colors = np.random.default_rng(1).integers(0, 256, (42, 3)).astype(np.uint8)
    shape.export(tmp_path / "a.ply")
    read, given = vc.load_scene(tmp_path / "a.ply"), vc.Scene.from_trimesh(shape)
    np.testing.assert_array_equal(read.meshes()[0]["colors"], given.meshes()[0]["colors"])


ATTRIBUTE = (
    '<bsdf type="diffuse"><texture name="reflectance" type="mesh_attribute">'
    '<string name="name" value="{}"/></texture></bsdf>'
)


def mitsuba(folder, bsdf, shape=""):
    shape = shape or '<shape type="ply"><string name="filename" value="a.ply"/>{}</shape>'
    (folder / "a.xml").write_text(f'<scene version="3.0.0">{shape.format(bsdf)}</scene>')
    return vc.load_scene(folder / "a.xml", env=1.0)


MITSUBA = {
    "vertices": ("vertex_color", [1, 0.2, 0]),
    "faces": ("face_color", [0, 0.5, 1]),
    "named by none": (None, None),
    "an attribute that is not there": ("vertex_age", None),
}


@pytest.mark.parametrize("case", MITSUBA)
def test_mitsuba_shows_the_attribute_that_a_bsdf_names(tmp_path, case):
    name, expected = MITSUBA[case]
    write(tmp_path, RGB, "face 2 $I, float color_0 0, float color_1 .5, float color_2 1")
    scene = mitsuba(tmp_path, ATTRIBUTE.format(name) if name else "")
    (mesh,) = scene.meshes()
    said = [w for w in scene.warnings if "attribute" in w]
    assert bool(said) == (name == "vertex_age")
    if expected is None:
        assert len(mesh["colors"]) == 0
        return
    np.testing.assert_allclose(mesh["colors"][:, :3], np.tile(expected, (4, 1)), atol=STEP)
    assert scene.materials[mesh["material"]]["base_color"] == [1, 1, 1]
    # Normals are those of shared vertices
    np.testing.assert_allclose(mesh["normals"], np.tile([0, 0, 1], (4, 1)), atol=1e-6)


def test_mitsuba_attributes_have_a_scale_and_no_other_place(tmp_path):
    write(tmp_path, RGB)
    half = ATTRIBUTE.format("vertex_color").replace(
        "</texture>", '<float name="scale" value=".5"/></texture>'
    )
    scene = mitsuba(tmp_path, half)
    assert scene.materials[0]["base_color"] == [0.5] * 3 and len(scene.meshes()[0]["colors"]) == 4
    mask = ATTRIBUTE.format("vertex_color").replace("diffuse", "mask")
    mask = mask.replace("reflectance", "opacity").replace(
        "</bsdf>", '<bsdf type="diffuse"/></bsdf>'
    )
    assert any("a base colour alone" in w for w in mitsuba(tmp_path, mask).warnings)
    ball = '<shape type="sphere">{}</shape>'
    ball_scene = mitsuba(tmp_path, ATTRIBUTE.format("vertex_color"), ball)
    assert any("lacks the attribute" in w for w in ball_scene.warnings)


def test_pbrt_shows_no_colors_of_a_ply(tmp_path):
    write(tmp_path, RGB)
    shape = 'WorldBegin\nShape "plymesh" "string filename" "a.ply"\nWorldEnd\n'
    (tmp_path / "a.pbrt").write_text(shape)
    assert len(vc.load_scene(tmp_path / "a.pbrt", env=1.0).meshes()[0]["colors"]) == 0


def test_faces_of_an_element_without_colors_are_white(tmp_path):
    red = "uchar red 255, uchar green 0, uchar blue 0"
    corners = (f"face 1 {INDICES} {given}" for given in ("0 1 2", f"0 2 3, {red}", "0 1 3"))
    write(tmp_path, "", "; ".join(corners))
    (mesh,) = vc.load_scene(tmp_path / "a.ply", env=1.0).meshes()
    of_faces = mesh["colors"][mesh["triangles"][:, 0], :3].tolist()
    assert of_faces == [[1, 1, 1], [1, 0, 0], [1, 1, 1]]
