# ruff: noqa: E501  (scene texts stay on their lines)
"""PLY files, ascii and little-endian binary."""

import struct

import numpy as np
import pytest
import trimesh

from viscache import _core as core

HEADER = "ply\nformat {} 1.0\ncomment a\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
FACES = "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.5)]


def test_an_ascii_file_with_a_quad_and_a_triangle_gives_three_triangles(tmp_path):
    text = HEADER.format("ascii") + FACES.format(2)
    text += "".join("{} {} {}\n".format(*p) for p in POINTS) + "4 0 1 2 3\n3 0 2 3\n"
    (tmp_path / "m.ply").write_text(text)
    mesh = core.load_scene_file(str(tmp_path / "m.ply")).mesh_arrays(0)
    assert mesh["triangles"].tolist() == [[0, 1, 2], [0, 2, 3], [0, 2, 3]]
    np.testing.assert_array_equal(mesh["vertices"], np.array(POINTS, np.float32))


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
