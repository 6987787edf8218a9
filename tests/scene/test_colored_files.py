"""Colours of vertices and faces in files: glTF, PLY, OBJ, Mitsuba, pbrt."""

import base64
import json
import struct

import numpy as np
import pytest
import trimesh

import viscache as vc
from scene.test_colors import STEP, linear

POINTS = [(-1, 0, 0), (1, 0, 0), (1, 2, 0), (-1, 2, 0)]


def gltf(path, colors, **material):
    kinds = {"f": 5126, "B": 5121, "H": 5123}
    parts = [np.array(POINTS, "<f4"), np.array([0, 1, 2, 0, 2, 3], "<u2"), colors]
    data = b"".join(p.tobytes() + b"\0" * (-p.nbytes % 4) for p in parts)
    sizes = [p.nbytes + -p.nbytes % 4 for p in parts]
    views = [
        {"buffer": 0, "byteOffset": sum(sizes[:i]), "byteLength": parts[i].nbytes} for i in range(3)
    ]
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        {
            "bufferView": 2,
            "componentType": kinds[colors.dtype.char],
            "count": len(colors),
            "type": f"VEC{colors.shape[1]}",
            "normalized": colors.dtype.char != "f",
        },
    ]
    primitive = {"attributes": {"POSITION": 0, "COLOR_0": 2}, "indices": 1, "material": 0}
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(data), "uri": uri}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [primitive]}],
        "materials": [material],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    path.write_text(json.dumps(document))


def ply(path, vertex, rows, face="", faces=("", "")):
    def properties(listed):
        return "".join(f"property {p}\n" for p in listed.split(", ") if p)

    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        f"property float z\n{properties(vertex)}element face 2\n"
        f"property list uchar int vertex_indices\n{properties(face)}end_header\n"
        + "".join("{} {} {} {}\n".format(*p, row) for p, row in zip(POINTS, rows, strict=True))
        + f"3 0 1 2 {faces[0]}\n3 0 2 3 {faces[1]}\n"
    )


BYTES = "uchar red, uchar green, uchar blue"
#: Writes a file; the linear colour of its first triangle.
FILES = {
    "gltf, bytes": (
        "a.gltf",
        lambda p: gltf(p, np.uint8([[255, 51, 0, 255]] * 4)),
        [1, 0.2, 0, 1],
    ),
    "gltf, 16 bits": (
        "a.gltf",
        lambda p: gltf(p, np.uint16([[65535, 13107, 0]] * 4)),
        [1, 0.2, 0, 1],
    ),
    "gltf, floats": ("a.gltf", lambda p: gltf(p, np.float32([[1, 0.2, 0]] * 4)), [1, 0.2, 0, 1]),
    "gltf, opaque": (
        "a.gltf",
        lambda p: gltf(p, np.float32([[1, 0.2, 0, 0.5]] * 4)),
        [1, 0.2, 0, 1],
    ),
    "gltf, blended": (
        "a.gltf",
        lambda p: gltf(p, np.float32([[1, 0.2, 0, 0.4]] * 4), alphaMode="BLEND"),
        [1, 0.2, 0, 0.4],
    ),
    "ply, bytes": (
        "a.ply",
        lambda p: ply(p, BYTES + ", uchar alpha", ["255 51 0 102"] * 4),
        [1, float(linear(0.2)), 0, 0.4],
    ),
    "ply, 16 bits": (
        "a.ply",
        lambda p: ply(p, BYTES.replace("uchar", "ushort"), ["65535 13107 0"] * 4),
        [1, float(linear(0.2)), 0, 1],
    ),
    "ply, floats": (
        "a.ply",
        lambda p: ply(p, "float r, float g, float b, float a", ["1 .2 0 .4"] * 4),
        [1, 0.2, 0, 0.4],
    ),
    "ply, diffuse_red": (
        "a.ply",
        lambda p: ply(
            p, "uchar diffuse_red, uchar diffuse_green, uchar diffuse_blue", ["255 51 0"] * 4
        ),
        [1, float(linear(0.2)), 0, 1],
    ),
    "ply, faces": (
        "a.ply",
        lambda p: ply(p, "", [""] * 4, BYTES, ("255 51 0", "0 0 255")),
        [1, float(linear(0.2)), 0, 1],
    ),
    "obj": (
        "a.obj",
        lambda p: p.write_text(
            "".join("v {} {} {} 1 0.2 0\n".format(*q) for q in POINTS) + "f 1 2 3 4\n"
        ),
        [1, float(linear(0.2)), 0, 1],
    ),
    "obj, bytes": (
        "a.obj",
        lambda p: p.write_text(
            "".join("v {} {} {} 255 51 0\n".format(*q) for q in POINTS) + "f 1 2 3 4\n"
        ),
        [1, float(linear(0.2)), 0, 1],
    ),
}


@pytest.mark.parametrize("case", FILES)
def test_files_keep_their_colors(tmp_path, case):
    name, write, expected = FILES[case]
    write(tmp_path / name)
    scene = vc.load_scene(tmp_path / name, env=1.0, strict=True)
    (mesh,) = scene.meshes()
    colors = mesh["colors"][mesh["triangles"][0]]
    np.testing.assert_allclose(colors, np.tile(expected, (3, 1)), atol=STEP)
    if case == "ply, faces":
        np.testing.assert_array_equal(mesh["colors"][mesh["triangles"][1]], [[0, 0, 1, 1]] * 3)
    assert scene.materials[mesh["material"]]["base_color"] == [1, 1, 1] or "gltf" in case
    camera = vc.orthographic((0, 1, 4), (0, 1, 0), height=1)
    layers = vc.render(scene, "direct", camera=camera, size=(8, 8)).layers
    there = layers["coverage"][..., 0] > 0.99
    if expected[3] == 1:
        assert there.all()
    if not name.endswith("gltf"):
        # The first face is below the diagonal
        albedo = layers["albedo"][6:, 4:] if expected[3] == 1 else layers["albedo"][there]
        albedo = albedo.reshape(-1, 3).max(0)
        np.testing.assert_allclose(albedo, expected[:3], atol=STEP)


def test_gltf_colors_multiply_base_color_and_tint_metals(tmp_path):
    colors = np.float32([[1, 0.5, 0.25]] * 4)
    for metallic in (0.0, 1.0):
        factors = {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": metallic}
        gltf(tmp_path / "a.gltf", colors, pbrMetallicRoughness=factors)
        colored = vc.load_scene(tmp_path / "a.gltf", env=1.0)
        gltf(
            tmp_path / "b.gltf",
            np.ones((4, 3), np.float32),
            pbrMetallicRoughness=factors | {"baseColorFactor": [0.5, 0.25, 0.125, 1]},
        )
        plain = vc.load_scene(tmp_path / "b.gltf", env=1.0)
        camera = vc.orthographic((0, 1, 4), (0, 1, 0), height=1)
        a, b = (
            vc.render(s, "direct", camera=camera, size=(8, 8), seed=1).image.mean((0, 1))
            for s in (colored, plain)
        )
        np.testing.assert_allclose(a, b, rtol=0.02)


@pytest.mark.parametrize(("cutoff", "factor", "solid"), [(0.5, 1, 0.5), (0.3, 0.5, 0.6)])
def test_a_gltf_mask_cuts_where_base_alpha_times_vertex_alpha_is_below(
    tmp_path, cutoff, factor, solid
):
    colors = np.float32([[1, 1, 1, (p[0] + 1) / 2] for p in POINTS])
    pbr = {"baseColorFactor": [1, 1, 1, factor]}
    look = {"alphaMode": "MASK", "alphaCutoff": cutoff, "doubleSided": True}
    gltf(tmp_path / "a.gltf", colors, pbrMetallicRoughness=pbr, **look)
    scene = vc.load_scene(tmp_path / "a.gltf", env=1.0)
    x = np.linspace(-0.95, 0.95, 39)
    at = np.column_stack([x, np.full(39, 0.7), np.ones(39)])
    seen = scene.visible(at, at * [1, 1, -1])
    clear = np.abs((x + 1) / 2 - solid) > 0.01
    np.testing.assert_array_equal(seen[clear], ((x + 1) / 2 < solid)[clear])
    gltf(tmp_path / "b.gltf", colors * np.float32([1, 1, 1, 0]), alphaMode="MASK")
    assert vc.load_scene(tmp_path / "b.gltf", env=1.0).visible(at, at * [1, 1, -1]).all()


BRIGHT = {
    "a.gltf": lambda p: gltf(p, np.float32([[1.5, 0.2, 0]] * 4)),
    "a.ply": lambda p: ply(p, "float r, float g, float b", ["1.5 .2 0"] * 4),
    "a.obj": lambda p: p.write_text("v 0 0 0 1.5 0.2 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"),
}


@pytest.mark.parametrize("name", BRIGHT)
def test_colors_above_one_are_clamped_with_a_warning(tmp_path, name):
    BRIGHT[name](tmp_path / name)
    with pytest.raises(vc.SceneError, match="colours must be in"):
        vc.load_scene(tmp_path / name, strict=True)
    scene = vc.load_scene(tmp_path / name)
    assert scene.meshes()[0]["colors"][0, 0] == 1


def test_an_alpha_of_zero_everywhere_in_a_ply_means_nothing(tmp_path):
    ply(tmp_path / "a.ply", BYTES + ", uchar alpha", ["255 51 0 0"] * 4)
    scene = vc.load_scene(tmp_path / "a.ply", env=1.0, strict=True)
    assert any("alpha of all colours is 0" in w for w in scene.warnings)
    assert (scene.meshes()[0]["colors"][:, 3] == 1).all()


def test_trimesh_and_the_reader_show_the_same_scan(tmp_path):
    shape = trimesh.creation.icosphere(subdivisions=1)
    shape.visual.vertex_colors = np.random.default_rng(1).integers(0, 256, (42, 3)).astype(np.uint8)
    shape.export(tmp_path / "a.ply")
    read, given = vc.load_scene(tmp_path / "a.ply"), vc.Scene.from_trimesh(shape)
    np.testing.assert_array_equal(read.meshes()[0]["colors"], given.meshes()[0]["colors"])


def test_vertices_of_an_obj_without_colors_are_white_and_materials_multiply(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl half\nKd .5 .5 .5\n")
    lines = ["mtllib a.mtl", "v 0 0 0", "v 1 0 0 1 0 0", "v 1 1 0 1", "v 0 1 0"]
    lines += ["usemtl half", "f 1 2 3 4", ""]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    scene = vc.load_scene(tmp_path / "a.obj", env=1.0)
    assert scene.materials[0]["base_color"] == [0.5] * 3
    expected = [[1, 1, 1, 1], [1, 0, 0, 1], [1, 1, 1, 1], [1, 1, 1, 1]]
    assert scene.meshes()[0]["colors"].tolist() == expected
    # In bytes, too
    lines[2] = "v 1 0 0 255 0 0"
    (tmp_path / "a.obj").write_text("\n".join(lines))
    assert vc.load_scene(tmp_path / "a.obj").meshes()[0]["colors"].tolist() == expected


# Mitsuba and pbrt

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
    ply(
        tmp_path / "a.ply",
        "float r, float g, float b",
        ["1 .2 0"] * 4,
        "float color_0, float color_1, float color_2",
        ["0 .5 1"] * 2,
    )
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
    ply(tmp_path / "a.ply", "float r, float g, float b", ["1 .2 0"] * 4)
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
    ply(tmp_path / "a.ply", BYTES, ["255 51 0"] * 4)
    shape = 'WorldBegin\nShape "plymesh" "string filename" "a.ply"\nWorldEnd\n'
    (tmp_path / "a.pbrt").write_text(shape)
    assert len(vc.load_scene(tmp_path / "a.pbrt", env=1.0).meshes()[0]["colors"]) == 0


def test_faces_of_an_element_without_colors_are_white(tmp_path):
    plain = "element face 1\nproperty list uchar int vertex_index\n"
    colored = plain + "".join(f"property uchar {c}\n" for c in ("red", "green", "blue"))
    head = "ply\nformat ascii 1.0\nelement vertex 4\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    points = "".join("{} {} {}\n".format(*p) for p in POINTS)
    body = points + "3 0 1 2\n3 0 2 3 255 0 0\n3 0 1 3\n"
    (tmp_path / "a.ply").write_text(head + plain + colored + plain + "end_header\n" + body)
    (mesh,) = vc.load_scene(tmp_path / "a.ply", env=1.0).meshes()
    of_faces = mesh["colors"][mesh["triangles"][:, 0], :3].tolist()
    assert of_faces == [[1, 1, 1], [1, 0, 0], [1, 1, 1]]


def test_binary_files_have_colors_of_faces_with_many_corners(tmp_path):
    header = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1\nproperty uchar red\n"
        "property uchar green\nproperty list uchar int vertex_index\nproperty uchar blue\n"
        "end_header\n"
    )
    data = np.array(POINTS, "<f4").tobytes() + struct.pack("<3B4iB", 255, 51, 4, 0, 1, 2, 3, 255)
    (tmp_path / "a.ply").write_bytes(header.encode() + data)
    (mesh,) = vc.load_scene(tmp_path / "a.ply", env=1.0).meshes()
    assert len(mesh["triangles"]) == 2 and len(mesh["vertices"]) == 4
    np.testing.assert_allclose(mesh["colors"], [[1, linear(0.2), 1, 1]] * 4, rtol=1e-5)
