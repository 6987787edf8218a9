"""OBJ and MTL files: geometry, indices, materials, textures."""

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from skimage.io import imsave

from viscache import _core as core


def load(folder: Path, text: str, strict: bool = False, **files: str) -> core.SceneDescription:
    for name, content in files.items():
        (folder / name.replace("_mtl", ".mtl")).write_text(content)
    path = folder / "model.obj"
    path.write_text(text)
    return core.load_scene_file(str(path), strict)


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def test_a_quad_becomes_two_triangles_in_the_order_of_the_file(tmp_path):
    mesh = load(tmp_path, SQUARE + "f 1 2 3 4\n").mesh_arrays(0)
    assert mesh["triangles"].tolist() == [[0, 1, 2], [0, 2, 3]]
    np.testing.assert_array_equal(mesh["vertices"], [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def test_negative_indices_count_from_the_last_vertex_read(tmp_path):
    mesh = load(tmp_path, SQUARE + "f -4 -3 -2\nv 9 9 9\nf -2 -3 -4\n").mesh_arrays(0)
    p = mesh["vertices"][mesh["triangles"]]
    np.testing.assert_array_equal(p[0], [[0, 0, 0], [1, 0, 0], [1, 1, 0]])
    np.testing.assert_array_equal(p[1], [[0, 1, 0], [1, 1, 0], [1, 0, 0]])


def test_a_concave_polygon_is_covered_exactly_once(tmp_path):
    # An L of area 3.
    text = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 3 4 5 6 1 2\n"
    mesh = load(tmp_path, text).mesh_arrays(0)
    p = mesh["vertices"][mesh["triangles"]]
    areas = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2] / 2
    assert len(areas) == 4 and (areas > 0).all() and areas.sum() == pytest.approx(3)


def test_normals_and_uvs_follow_their_own_indices(tmp_path):
    text = (
        SQUARE + "vt 0 0\nvt 1 0.25\nvn 0 0 1\nvn 0 1 0\nf 1/2/1 2/1/2 3/1/1\nf 1/1/1 3/1/1 4/1/1\n"
    )
    scene = load(tmp_path, text)
    mesh = scene.mesh_arrays(0)
    first = mesh["triangles"][0]
    np.testing.assert_array_equal(mesh["uvs"][first], [[1, 0.25], [0, 0], [0, 0]])
    np.testing.assert_array_equal(mesh["normals"][first], [[0, 0, 1], [0, 1, 0], [0, 0, 1]])
    assert len(mesh["vertices"]) == 5  # vertex 1 with two texture coordinates is two


def test_trimesh_reads_the_same_triangles(tmp_path):
    sphere = trimesh.creation.icosphere(2)
    sphere.export(tmp_path / "model.obj")
    mesh = core.load_scene_file(str(tmp_path / "model.obj")).mesh_arrays(0)
    oracle = trimesh.load(tmp_path / "model.obj", process=False)
    np.testing.assert_allclose(
        mesh["vertices"][mesh["triangles"]], oracle.triangles, rtol=0, atol=1e-6
    )


MTL = """newmtl red
Kd 0.8 0.1 0.05
newmtl lamp
Kd 0 0 0
Ke 5 4 3
newmtl mirror
Ks 0.9 0.8 0.7
illum 3
newmtl glass
Ni 1.33
illum 7
newmtl shiny
Kd 0.2 0.2 0.2
Ks 0.1 0.1 0.1
Ns 98
illum 2
"""


def test_materials_of_an_mtl_become_the_nearest_kinds(tmp_path):
    names = ["red", "lamp", "mirror", "glass", "shiny"]
    text = "mtllib m.mtl\n" + SQUARE + "".join(f"usemtl {n}\nf 1 2 3\n" for n in names)
    scene = load(tmp_path, text, strict=True, m_mtl=MTL)
    by_name = {m["name"]: (m, scene.materials[m["material"]]) for m in scene.meshes}
    assert set(by_name) == set(names)
    kinds = {n: by_name[n][1]["kind"] for n in names}
    K = core.MaterialKind
    assert kinds == {
        "red": K.DIFFUSE,
        "lamp": K.DIFFUSE,
        "mirror": K.MIRROR,
        "glass": K.DIELECTRIC,
        "shiny": K.GLOSSY,
    }
    assert by_name["red"][1]["base_color"] == pytest.approx([0.8, 0.1, 0.05])
    assert by_name["lamp"][0]["emission"] == pytest.approx([5, 4, 3])
    assert by_name["mirror"][1]["specular"] == pytest.approx([0.9, 0.8, 0.7])
    assert by_name["glass"][1]["eta"] == pytest.approx(1.33)
    assert by_name["shiny"][1]["roughness"] == pytest.approx(np.sqrt(2 / 100))


@pytest.mark.parametrize("line", ["d 0.25", "Tr 0.75"])
def test_constant_transparency_is_the_opacity(tmp_path, line):
    text = "mtllib m.mtl\n" + SQUARE + "usemtl veil\nf 1 2 3\n"
    scene = load(tmp_path, text, strict=True, m_mtl=f"newmtl veil\nKd 1 1 1\n{line}\n")
    assert scene.materials[scene.meshes[0]["material"]]["opacity"] == 0.25


def test_textures_are_decoded_to_linear_with_alpha_as_it_is(tmp_path):
    pixels = np.zeros((2, 2, 4), np.uint8)
    pixels[0, 0] = [128, 0, 255, 128]
    imsave(tmp_path / "my leaf.png", pixels, check_contrast=False)
    mtl = "newmtl leaf\nKd 1 1 1\nmap_Kd my leaf.png\nmap_d my leaf.png\n"
    scene = load(tmp_path, "mtllib m.mtl\n" + SQUARE + "usemtl leaf\nf 1 2 3\n", m_mtl=mtl)
    material = scene.materials[0]
    image = scene.image_pixels(material["base_texture"])
    linear = ((128 / 255 + 0.055) / 1.055) ** 2.4
    np.testing.assert_allclose(image[0, 0], [linear, 0, 1, 128 / 255], atol=1e-6)
    assert material["alpha_texture"] >= 0 and material["alpha_cutoff"] == 0.5


def test_a_missing_texture_is_named_and_dropped_or_refused_when_strict(tmp_path):
    mtl = "newmtl a\nKd 1 1 1\nmap_Kd gone.png\n"
    text = "mtllib m.mtl\n" + SQUARE + "usemtl a\nf 1 2 3\n"
    scene = load(tmp_path, text, m_mtl=mtl)
    assert scene.materials[0]["base_texture"] == -1 and scene.images == []
    assert any("gone.png" in what and "does not exist" in what for _, what in scene.warnings)
    with pytest.raises(core.SceneError, match=r"gone\.png"):
        load(tmp_path, text, strict=True)


def test_a_missing_mtl_and_an_unknown_material_are_named_with_their_line(tmp_path):
    scene = load(tmp_path, SQUARE + "mtllib gone.mtl\nusemtl x\nf 1 2 3\n")
    assert [w.rsplit(":", 1)[1] for w, _ in scene.warnings] == ["5", "6"]


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("Kd -5 0 0", r"m\.mtl:2: Kd must be in \[0, 1\], got '-5 0 0'; it is clamped"),
        ("Kd 7", r"m\.mtl:2: Kd must be in \[0, 1\], got '7'; it is clamped"),
        ("Ks 0 1.5 0", r"m\.mtl:2: Ks must be in \[0, 1\]"),
        ("d 5", r"m\.mtl:2: d must be in \[0, 1\], got '5'"),
        ("Tr -1", r"m\.mtl:2: Tr must be in \[0, 1\]"),
        ("Kd", r"m\.mtl:2: Kd has no number; it counts as 0"),
        ("Kd 1 0 0.5", None),
        ("Ke 7 7 7", None),
    ],
)
def test_values_of_an_mtl_that_are_out_of_range_are_warned_of(tmp_path, line, says):
    text = "mtllib m.mtl\n" + SQUARE + "usemtl a\nf 1 2 3\n"
    scene = load(tmp_path, text, m_mtl=f"newmtl a\n{line}\n")
    told = [f"{where}: {what}" for where, what in scene.warnings if "m.mtl" in where]
    assert bool(told) == (says is not None), scene.warnings
    assert says is None or re.search(says, told[0])
