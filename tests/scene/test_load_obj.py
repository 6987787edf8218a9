"""OBJ and MTL files: geometry, indices, materials, textures."""

import re

import numpy as np
import pytest
from skimage.io import imsave

from viscache import _core as core


def load(folder, text, strict=False, **files):
    for name, content in files.items():
        (folder / name.replace("_mtl", ".mtl")).write_text(content)
    path = folder / "model.obj"
    path.write_text(text)
    return core.load_scene_file(str(path), strict)


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


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


D, G, M, T = (getattr(core.MaterialKind, k) for k in ("DIFFUSE", "GLOSSY", "MIRROR", "DIELECTRIC"))
BLENDER = (
    "# Blender 3.6.2 MTL File: 'None'\nnewmtl a\nNs {}\nKa {} {} {}\nKd .8 .4 .2\nKs .5 .5 .5\n"
    "Ni {}\nd {}\nillum {}"
)
VTK = (
    "# wavefront mtl file written by the visualization toolkit\n"
    "newmtl a\nKd 1 1 1\nKs {} {} {}\nNs 30\nTr {}\nillum 3"
)
LOBE = np.sqrt(2 / 32)


@pytest.mark.parametrize(
    ("mtl", "found"),
    [  # MeshLab, and VTK: Tr is opacity
        ("Tr .25\nKd 1 1 1\nnewmtl other\nTr 1", {"opacity": 0.25}),
        ("Tr .25\nKd 1 1 1\nnewmtl other\nTr 0", {"opacity": 0.75}),
        (VTK.format(0.3, 0.3, 0.3, 0.25), {"kind": G, "opacity": 0.25, "roughness": LOBE}),
        # Maya
        ("illum 4\nKd .5 .5 .5\nTf .25 .25 .25\nNi 1.00", {"kind": D, "opacity": 0.25}),
        # Blender
        (BLENDER.format(250, 1, 1, 1, 1.45, 0.5, 9), {"kind": G, "opacity": 0.5, "metallic": 0}),
        (
            BLENDER.format(250, 1, 1, 1, 1.5, 1, 2),
            {"kind": G, "roughness": 0.25, "specular": [0.04] * 3, "base_color": [0.8, 0.4, 0.2]},
        ),
        (BLENDER.format(810, 0.7, 0.7, 0.7, 1.45, 1, 3), {"metallic": 0.7, "roughness": 0.01}),
        (BLENDER.format(250, 1, 1, 1, 1.45, 0.5, 6), {"kind": G, "metallic": 1, "opacity": 0.5}),
        (BLENDER.format(250, 1, 1, 1, 1.45, 1, 1), {"kind": D}),
        (BLENDER.format(250, 1, 1, 1, 1.45, 1, "2\nPr 0\nTf 1 1 1"), {"kind": T, "eta": 1.45}),
        # What hand-written files and the format itself mean
        ("Kd 0 0 0\nKs .9 .9 .9\nillum 5", {"kind": M, "specular": [0.9] * 3}),
        ("Kd .1 .1 .1\nKs .8 .8 .8\nNs 1024\nillum 5", {"kind": G, "roughness": 1e-3}),
        ("Kd .1 .1 .1\nKs .8 .8 .8\nNs 30\nillum 3", {"kind": G, "roughness": LOBE}),
        ("Kd .5 .5 .5\nKs .8 .8 .8\nNs 30", {"kind": G, "roughness": LOBE}),
        ("Kd .5 .5 .5\nNi 1.5\nillum 4", {"kind": T, "eta": 1.5}),
        ("Kd .5 .5 .5\nNi 1.5\nTf 0 0 0\nillum 4", {"kind": D}),
        ("illum 7", {"kind": T, "eta": 1.5}),
        ("Ni 1\nillum 6\nKd .5 .5 .5\nTf 1 1 1", {"kind": D}),
        ("Tf .9 .2 .2\nNi 1.5\nillum 7", {"kind": T, "transmission": [0.9, 0.2, 0.2]}),
        ("Kd .5 0 0\nKs 1 1 1\nTf 1 0 0\nNi 1\nillum 7", {"kind": T, "eta": 1}),
        ("Ni 1.5\nillum 9\nTf 1 1 1", {"kind": T, "eta": 1.5}),
        (
            "kd 1 .5 .25\nPr .5\nPm 1\nPs 0\nPc 0\nPcr .3\naniso 0\nanisor 0",
            {"kind": G, "metallic": 1, "roughness": 0.25, "specular": [0.04] * 3},
        ),
    ],
)
def test_materials_mean_what_their_exporter_means(tmp_path, mtl, found):
    """Found in what the programs write; the rules are in docs/howto/own-scene.md."""
    text = "mtllib m.mtl\n" + SQUARE + "usemtl a\nf 1 2 3\n"
    mtl = mtl if "newmtl a" in mtl else f"newmtl a\n{mtl}"
    made = load(tmp_path, text, strict=True, m_mtl=mtl + "\n").materials[0]
    for name, value in found.items():
        assert made[name] == pytest.approx(value, abs=2e-4), name


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("map_Kd a.png\nNi 1.5\nillum 7", r"m\.mtl:2: an image of Kd on glass is not modelled"),
        ("illum 4\nTf 1 .2 .2", r"m\.mtl:1: coloured transparency \(Tf\) is not modelled"),
        ("Tr .25", r"m\.mtl:1: 'Tr' without 'd' is read as 1 - opacity"),
        ("Kd 1 0 red", r"m\.mtl:2: 'Kd' needs finite numbers; the line is not read"),
        ("Kd spectral file.rfl", r"m\.mtl:2: 'Kd spectral' is not read"),
        ("d -halo .5", r"m\.mtl:2: a halo is not modelled"),
        ("illum 10", r"m\.mtl:1: illum must be 0 to 9"),
        ("Pc .5", r"m\.mtl:2: the coat of Pc is not modelled"),
        ("map_Bump -bm 2 a.png", r"m\.mtl:2: bump maps are not modelled"),
        ("refl -type sphere a.png", r"m\.mtl:2: images of reflections are not modelled"),
        ("map_Ks a.png", r"m\.mtl:2: an image of this kind is not modelled"),
        ("map_Kd -t .1 .1 .1 a.png", r"m\.mtl:2: turbulence"),
        ("map_Kd -mm .5 2 a.png", r"m\.mtl:2: base and gain"),
        ("map_d -imfchan r a.png", r"m\.mtl:2: -imfchan is not modelled"),
        ("map_Kd -fancy a.png", r"m\.mtl:2: '-fancy' is not read"),
        ("map_Kd", r"m\.mtl:2: a texture line without a file"),
        ("Kx 1 2 3", r"m\.mtl:2: 'Kx' is not read"),
        ("Kd -5 0 0", r"m\.mtl:2: Kd must be in \[0, 1\]; it is clamped"),
        ("Ks 0 1.5 0", r"m\.mtl:2: Ks must be in \[0, 1\]"),
        ("d 5", r"m\.mtl:2: d must be in \[0, 1\]"),
        ("Tr -1", r"m\.mtl:2: Tr must be in \[0, 1\]"),
        ("Kd", r"m\.mtl:2: Kd has no number; it counts as 0"),
        ("Ke 7 7 7", None),
        ("map_Kd -s 2 1 1 a.png\nmap_Ke a.png", r"m\.mtl:3: the images of a material share"),
        ("newmtl a\nKd 1 1 1", r"m\.mtl:2: a material of this name is already defined"),
        ("map_Ka a.png\nKa 3 3 3\nmap_aat on\nsharpness 60\nTf 0 0 0", None),
        ("map_Kd -blendu off -cc on -clamp on -texres 64 -boost 2 -mm 0 1 -t 0 0 0 a.png", None),
    ],
)
def test_lines_of_an_mtl_that_are_not_read_are_warned_of(tmp_path, line, says):
    imsave(tmp_path / "a.png", np.full((2, 2, 3), 128, np.uint8), check_contrast=False)
    text = "mtllib m.mtl\n" + SQUARE + "vt 0 0\nusemtl a\nf 1/1 2/1 3/1\n"
    mtl = f"newmtl a\n{line}\nKd 1 1 1\n"
    told = [f"{where}: {what}" for where, what in load(tmp_path, text, m_mtl=mtl).warnings]
    assert bool(told) == (says is not None), told
    assert says is None or re.search(says, told[0]), told


def test_a_line_before_the_first_material_is_warned_of(tmp_path):
    text = "mtllib m.mtl\n" + SQUARE + "usemtl a\nf 1 2 3\n"
    ((_, told),) = load(tmp_path, text, m_mtl="Kd 1 0 0\nnewmtl a\nKd 1 1 1\n").warnings
    assert "before the first 'newmtl'" in told


FLAT = SQUARE + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3 4/4\n"


def test_an_image_of_roughness_is_read(tmp_path):
    imsave(tmp_path / "r.png", np.full((2, 2), 128, np.uint8), check_contrast=False)
    mtl = "newmtl a\nKd .5 .5 .5\nmap_Pr r.png\n"
    scene = load(tmp_path, "mtllib m.mtl\n" + FLAT, strict=True, m_mtl=mtl)
    made = scene.materials[0]
    assert made["metallic_roughness_texture"] == 0 and made["roughness"] == 1
    np.testing.assert_allclose(scene.image_pixels(0), 128 / 255, atol=1e-6)


@pytest.mark.parametrize(
    "extra",
    ["f 5//1 6//1 7//1\n", "f 5 6 7\n", "f 5/0/0 6/0/0 7/0/0\n", "f 5/1 6/2 7//1\n"],
)
def test_a_face_without_slots_leaves_the_others_theirs(tmp_path, extra):
    """The tilted normals of the square stay, although another face lacks them."""
    faces = FLAT.replace("f 1/1 2/2 3/3 4/4\n", "vn 0 .6 .8\nf 1/1/1 2/2/1 3/3/1 4/4/1\n")
    imsave(tmp_path / "a.png", np.full((2, 2), 255, np.uint8), check_contrast=False)
    text = "mtllib m.mtl\n" + faces + "v 0 0 -1\nv 1 0 -1\nv 1 1 -1\n" + extra
    scene = load(tmp_path, text, m_mtl="newmtl a\nmap_Kd a.png\n")
    assert any("without texture coordinates" in what for _, what in scene.warnings)
    mesh = scene.mesh_arrays(0)
    normals = mesh["normals"][mesh["triangles"]]
    np.testing.assert_allclose(normals[:2], np.broadcast_to([0, 0.6, 0.8], (2, 3, 3)))
    given = np.array(["//1" in word for word in extra.split()[1:]])
    np.testing.assert_allclose(normals[2][~given], np.broadcast_to([0, 0, 1], (3, 3))[~given])


#: Two faces that meet at a right angle in the edge from vertex 2 to 3.
FOLD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 -1\nv 1 1 -1\n"


@pytest.mark.parametrize(
    ("lines", "edge"),
    [
        ("s 1\nf 1 2 3 4\nf 2 5 6 3\n", "smooth"),
        ("s on\nf 1 2 3 4\nf 2 5 6 3\n", "smooth"),
        ("s 1\nf 1 2 3 4\ns 2\nf 2 5 6 3\n", "sharp"),
        ("s 1\nf 1 2 3 4\ns off\nf 2 5 6 3\n", "sharp"),
        ("s off\nf 1 2 3 4\nf 2 5 6 3\n", "none"),
        ("f 1 2 3 4\nf 2 5 6 3\n", "none"),
    ],
)
def test_smoothing_groups_are_smooth_where_a_file_has_no_normals(tmp_path, lines, edge):
    scene = load(tmp_path, FOLD + lines, strict=True)
    mesh = scene.mesh_arrays(0)
    if edge == "none":
        assert len(mesh["normals"]) == 0
        return
    on_edge = np.isin(mesh["vertices"][:, 0], 1) & (mesh["vertices"][:, 2] == 0)
    assert on_edge.sum() == (2 if edge == "smooth" else 4)
    want = [[0.5**0.5, 0, 0.5**0.5]] if edge == "smooth" else [[0, 0, 1], [1, 0, 0]]
    found = np.unique(mesh["normals"][on_edge].round(6), axis=0)
    np.testing.assert_allclose(found, np.unique(want, axis=0), atol=1e-6)


WHOLE = SQUARE + "vt 0 0\nvn 0 0 1\n"


@pytest.mark.parametrize(
    ("text", "note"),
    [
        (SQUARE + "f 1 2 3 4\n", None),
        (WHOLE + "f 1//0 2/0/0 3/0 4\n", "an index of 0 counts as none"),
        (SQUARE + "f 1 2 3 4\nf 1 2\nf 3\nf\n", "a face of fewer than three corners is skipped"),
        (SQUARE + "f 1 2 3 4\np 1 2\nl 1 2 3\n", "points and lines have no surface"),
    ],
)
def test_sound_lines_are_read(tmp_path, text, note):
    scene = load(tmp_path, text, strict=True)
    mesh = scene.mesh_arrays(0)
    assert mesh["triangles"].tolist() == [[0, 1, 2], [0, 2, 3]]
    np.testing.assert_array_equal(mesh["vertices"], [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    assert [note in what for _, what in scene.warnings] == ([True] if note else [])


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("curv 0 1 1 2 3", "curves and free surfaces are not modelled"),
        ("vp .5 .5", "curves and free surfaces are not modelled"),
        ("call other.obj", "'call' is not read"),
        ("V 0 0 0", "'V' is not read"),
        ("s many", "a smoothing group must be a number or off"),
    ],
)
def test_lines_of_an_obj_that_are_not_read_are_warned_of(tmp_path, line, says):
    # Lines are counted as the file has them, also after one that goes on
    text = "v 0 0 \\\n0\nv 1 0 0\nv 0 1 0\n" + line + "\nf 1 2 3\n"
    (told,) = load(tmp_path, text).warnings
    assert told[0].endswith("model.obj:5") and told[1].startswith(says), told
    with pytest.raises(core.SceneError, match=re.escape(says)):
        load(tmp_path, text, strict=True)


@pytest.mark.parametrize(
    "library",
    ["mtllib m.mtl n.mtl", "mtllib m.mtl\nmtllib n.mtl", "mtllib n.mtl\nmtllib m.mtl n.mtl"],
)
def test_materials_come_from_several_files_with_spaces_in_names(tmp_path, library):
    # The library may follow its use. Files that were joined name it again.
    text = SQUARE + "usemtl my red\nf 1 2 3\nusemtl green  \nf 1 3 4\n" + library + "\n"
    red, green = "newmtl my red\nKd 1 0 0\n", "newmtl green\r\nKd 0 1 0\r\n"
    for names in (("m.mtl", "n.mtl"), ("my m.mtl", "the n.MTL")):
        for name, content in zip(names, (red, green), strict=True):
            (tmp_path / name).write_text(content)
        asked = text.replace("m.mtl", names[0]).replace(" n.mtl", " " + names[1])
        scene = load(tmp_path, asked, strict=True)
        colors = {m["name"]: scene.materials[m["material"]]["base_color"] for m in scene.meshes}
        assert colors == {"my red": [1, 0, 0], "green": [0, 1, 0]}, scene.warnings


@pytest.mark.parametrize("gone", ["map_Kd", "map_Ke"])
def test_a_lamp_keeps_its_own_image_when_another_is_missing(tmp_path, gone):
    imsave(tmp_path / "a.png", np.full((2, 2), 255, np.uint8), check_contrast=False)
    here = {"map_Kd": "map_Ke", "map_Ke": "map_Kd"}[gone]
    mtl = f"newmtl a\n{gone} gone.png\n{here} a.png\n"
    scene = load(tmp_path, "mtllib m.mtl\n" + FLAT, m_mtl=mtl)
    lamp, material = scene.meshes[0], scene.materials[0]
    is_lamp = here == "map_Ke"
    assert (lamp["emission_texture"], material["base_texture"]) == ((0, -1) if is_lamp else (-1, 0))
    assert lamp["emission"] == pytest.approx([float(is_lamp)] * 3)


def test_objects_of_mitsuba_files_have_its_materials_and_notes_of_their_own(tmp_path):
    (tmp_path / "model.obj").write_text(
        "mtllib gone.mtl\nusemtl a\ns 1\n" + FOLD + "f 1 2 3 4\ns 2\nf 2 5 6 3\nf 1 2\n"
    )
    shape = '<shape type="obj"><string name="filename" value="model.obj"/></shape>'
    (tmp_path / "s.xml").write_text(f'<scene version="3.0.0">{shape}</scene>')
    scene = core.load_scene_file(str(tmp_path / "s.xml"), True)
    ((where, told),) = scene.warnings
    assert where.endswith("model.obj:13") and "fewer than three corners" in told
    # It smooths over all edges, whatever the groups are
    assert len(scene.mesh_arrays(0)["vertices"]) == 6
