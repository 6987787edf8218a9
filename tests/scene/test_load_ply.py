"""PLY files, ascii and binary."""

import numpy as np
import pytest
import trimesh

from viscache import _core as core
from viscache_lab.parity.exporters.formats import ply


def write(folder, change):
    path = folder / "m.ply"
    path.write_bytes(ply("m", change)["m.ply"])
    return str(path)


def mesh_of(folder, change):
    return core.load_scene_file(write(folder, change), True).mesh_arrays(0)


def test_binary_properties_of_any_type_and_order_are_read(tmp_path):
    change = (
        "le; vertex 3 double z 3/4/5, double y 2, double x 1/2/3, float s .25, float t .5, "
        "float nx, float ny, float nz 1; edge 1 int a 7, list uchar short more 5 6; "
        "face 1 uchar flag 1, list ushort uint vertex_index 2 1 0"
    )
    mesh = core.load_scene_file(write(tmp_path, change)).mesh_arrays(0)
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


def test_strips_turn_every_other_triangle_and_end_at_minus_one(tmp_path):
    strip = "0 1 3 2 -1 1 2 3 -1 0 1 1 2 3"
    mesh = mesh_of(tmp_path, f"ascii; $P; tristrips 1 list int int vertex_indices {strip}")
    # The last strip is joined by two triangles without area
    assert mesh["triangles"].tolist() == [[0, 1, 3], [3, 1, 2], [1, 2, 3], [1, 2, 3]]


def test_faces_of_fewer_than_three_corners_are_left_out_and_counted(tmp_path):
    path = write(tmp_path, "ascii; $P; face 4 list uchar int vertex_indices 0 1/0 1 2//3")
    scene = core.load_scene_file(path, True)
    assert scene.mesh_arrays(0)["triangles"].tolist() == [[0, 1, 2]]
    [(where, text)] = scene.warnings
    assert where.endswith("m.ply:14")
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
    x, y = np.roll(corners, first, 0).T
    n = len(corners)
    words = ["/".join(map(str, c)) for c in (x, y)]
    face = f"face 1 list uchar int vertex_indices {' '.join(map(str, range(n)))}"
    mesh = mesh_of(
        tmp_path, f"ascii; vertex {n} float x {words[0]}, float y {words[1]}, float z; {face}"
    )
    p = mesh["vertices"][mesh["triangles"]]
    double = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2]
    assert (double > 0).all()
    assert double.sum() == pytest.approx(x @ np.roll(y, -1) - y @ np.roll(x, -1))


UNREAD = [
    ("$P, float foo; $F", 7, "property 'foo' of element 'vertex'"),
    ("$P, float nx; $F", 7, "property 'nx' of element 'vertex'"),
    ("$P; $F, list uchar float foo 1", 9, "property 'foo' of element 'face'"),
    ("$P; $F; foo 1 int a 7", 9, "element 'foo'"),
    ("comment TextureFile wood.png; $P; $F", 3, "the picture of a TextureFile"),
]


@pytest.mark.parametrize(("change", "line", "text"), UNREAD)
def test_what_nobody_reads_is_warned_of_with_its_line(tmp_path, change, line, text):
    path = write(tmp_path, f"ascii; {change}")
    [(where, told)] = core.load_scene_file(path).warnings
    assert where.endswith(f"m.ply:{line}") and told == f"{text} is not read"
    with pytest.raises(core.SceneError, match=f"m.ply:{line}: {text} is not read"):
        core.load_scene_file(path, True)


def test_a_renderers_scene_says_which_parts_of_its_mesh_files_count(tmp_path):
    write(tmp_path, "ascii; comment TextureFile a.png; $P, float foo; $F")
    scene = tmp_path / "s.xml"
    scene.write_text(
        '<scene><shape type="ply"><string name="filename" value="m.ply"/></shape></scene>'
    )
    pbrt = tmp_path / "s.pbrt"
    pbrt.write_text('WorldBegin\nShape "plymesh" "string filename" "m.ply"\nWorldEnd\n')
    for path in (scene, pbrt):
        [(where, text)] = core.load_scene_file(str(path), True).warnings
        assert where.endswith("m.ply:8")
        assert text == "property 'foo' of element 'vertex' is not read"
