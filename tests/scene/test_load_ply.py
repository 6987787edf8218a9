# ruff: noqa: E501  (scene texts stay on their lines)
"""PLY files, ascii and binary."""

import struct

import numpy as np
import pytest
import trimesh

from viscache import _core as core

HEADER = "ply\nformat {} 1.0\ncomment a\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
FACES = "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.5)]


def test_binary_properties_of_any_type_and_order_are_read(tmp_path):
    header = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar red\n"
        "property double z\nproperty double y\nproperty double x\nproperty float s\n"
        "property float t\nproperty float nx\nproperty float ny\nproperty float nz\n"
        "element edge 1\nproperty int a\nproperty list uchar short more\n"
        "element face 1\nproperty uchar flag\nproperty list ushort uint vertex_index\nend_header\n"
    )
    data = b""
    for i in range(3):
        data += struct.pack("<B3d5f", 9, 3 + i, 2, 1 + i, 0.25, 0.5, 0, 0, 1)
    data += struct.pack("<iB2h", 7, 2, 5, 6) + struct.pack("<BH3I", 1, 3, 2, 1, 0)
    (tmp_path / "m.ply").write_bytes(header.encode() + data)
    mesh = core.load_scene_file(str(tmp_path / "m.ply")).mesh_arrays(0)
    assert mesh["triangles"].tolist() == [[2, 1, 0]]
    np.testing.assert_array_equal(mesh["vertices"][1], [2, 2, 4])
    np.testing.assert_array_equal(mesh["uvs"][0], [0.25, 0.5])
    np.testing.assert_array_equal(mesh["normals"][0], [0, 0, 1])


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_trimesh_writes_what_is_read(tmp_path, encoding):
    shape = trimesh.creation.torus(1, 0.3)
    shape.export(tmp_path / "m.ply", encoding=encoding, vertex_normal=False)
    scene = core.load_scene_file(str(tmp_path / "m.ply"))
    mesh = scene.mesh_arrays(0)
    np.testing.assert_allclose(mesh["vertices"], shape.vertices, atol=1e-6)
    assert np.array_equal(mesh["triangles"], shape.faces)


def write(path, head, data):
    """A file of four points; `head` declares what follows them."""
    path.write_text(HEADER.format("ascii") + head + "end_header\n" + data)
    return str(path)


FACE = "element face 1\nproperty list uchar int vertex_indices\n"
STRIP = "element tristrips 1\nproperty list int int vertex_indices\n"


def triangles(path):
    return core.load_scene_file(path, True).mesh_arrays(0)["triangles"].tolist()


def test_strips_turn_every_other_triangle_and_end_at_minus_one(tmp_path):
    strip = [0, 1, 3, 2, -1, 1, 2, 3, -1, 0, 1, 1, 2, 3]
    data = " ".join(str(c) for c in (*np.ravel(POINTS), len(strip), *strip))
    # The last strip is joined by two triangles without area
    want = [[0, 1, 3], [3, 1, 2], [1, 2, 3], [1, 2, 3]]
    assert triangles(write(tmp_path / "m.ply", STRIP, data)) == want


def test_faces_of_fewer_than_three_corners_are_left_out_and_counted(tmp_path):
    data = "0 0 0 1 0 0 1 1 0 0 1 0.5\n2 0 1\n3 0 1 2\n0\n1 3\n"
    path = write(tmp_path / "m.ply", FACE.replace("1", "4"), data)
    assert triangles(path) == [[0, 1, 2]]
    [(where, text)] = core.load_scene_file(path).warnings
    assert where.endswith("m.ply:12")
    assert text.startswith("a face of fewer than three corners is left out (3 times, also at ")


# An arrow head, and an L
CONCAVE = [
    [(0, 0), (2, 1), (0, 2), (1, 1)],
    [(1, 1), (0, 0), (2, 1), (0, 2)],
    [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)],
]


@pytest.mark.parametrize("corners", CONCAVE)
@pytest.mark.parametrize("first", [0, 1, 2, 3])
def test_concave_faces_keep_their_area(tmp_path, corners, first):
    corners = np.roll(corners, first, 0)
    n = len(corners)
    text = (HEADER.format("ascii") + FACE + "end_header\n").replace("vertex 4", f"vertex {n}")
    text += "".join(f"{x} {y} 0\n" for x, y in corners) + f"{n} " + " ".join(map(str, range(n)))
    (tmp_path / "m.ply").write_text(text)
    mesh = core.load_scene_file(str(tmp_path / "m.ply")).mesh_arrays(0)
    p = mesh["vertices"][mesh["triangles"]]
    double = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2]
    x, y = corners.T
    assert (double > 0).all()
    assert double.sum() == pytest.approx(x @ np.roll(y, -1) - y @ np.roll(x, -1))


UNREAD = [
    ("vertex", "property float foo\n", "property 'foo' of element 'vertex'"),
    ("vertex", "property float nx\n", "property 'nx' of element 'vertex'"),
    ("face", "property list uchar float foo\n", "property 'foo' of element 'face'"),
    ("foo", "element foo 1\nproperty int a\n", "element 'foo'"),
    ("vertex", "comment TextureFile wood.png\n", "the picture of a TextureFile"),
]


@pytest.mark.parametrize(("place", "line", "text"), UNREAD)
def test_what_nobody_reads_is_warned_of_with_its_line(tmp_path, place, line, text):
    head = HEADER.format("ascii") + (line if place == "vertex" else "") + FACE
    head += line if place != "vertex" else ""
    extra = " 0" if place == "vertex" and "property" in line else ""
    points = "".join("{} {} {}".format(*p) + extra + "\n" for p in POINTS)
    (tmp_path / "m.ply").write_text(head + "end_header\n" + points + "3 0 1 2 1 7\n")
    path = str(tmp_path / "m.ply")
    number = head.splitlines().index(line.splitlines()[0]) + 1
    [(where, told)] = core.load_scene_file(path).warnings
    assert where.endswith(f"m.ply:{number}") and told == f"{text} is not read"
    with pytest.raises(core.SceneError, match=f"m.ply:{number}: {text} is not read"):
        core.load_scene_file(path, True)


def test_a_renderers_scene_says_which_parts_of_its_mesh_files_count(tmp_path):
    write(tmp_path / "m.ply", "comment TextureFile a.png\nproperty float foo\n" + FACE,
          "0 0 0 1 1 0 0 1 1 1 0 1 0 1 0.5 1 3 0 1 2")  # fmt: skip
    scene = tmp_path / "s.xml"
    scene.write_text(
        '<scene><shape type="ply"><string name="filename" value="m.ply"/></shape></scene>'
    )
    pbrt = tmp_path / "s.pbrt"
    pbrt.write_text('WorldBegin\nShape "plymesh" "string filename" "m.ply"\nWorldEnd\n')
    for path in (scene, pbrt):
        [(where, text)] = core.load_scene_file(str(path), True).warnings
        assert (
            where.endswith("m.ply:9") and text == "property 'foo' of element 'vertex' is not read"
        )
