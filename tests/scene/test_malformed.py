# ruff: noqa: E501  (scene texts stay on their lines)
"""Malformed scene files: SceneError with file and place, never a crash, a hang or a silent guess."""

import struct
import zlib

import pytest

from viscache import _core as core

pytestmark = pytest.mark.fuzz

PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
)
PLY_BINARY = PLY.replace("ascii", "binary_little_endian").encode()
POINTS = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
PBRT = 'WorldBegin\nShape "trianglemesh" "integer indices" [0 1 2] "point P" [0 0 0 1 0 0 0 1 0]\nWorldEnd\n'
NAN = struct.pack("<f", float("nan"))


def xml(body):
    return f'<scene version="3.0.0">\n{body}\n</scene>'


def cube(to_world):
    return f'<shape type="cube"><transform name="to_world">{to_world}</transform></shape>'


def ball(radius):
    return f'<shape type="sphere"><float name="radius" value="{radius}"/></shape>'


def world(words):
    return f"WorldBegin\n{words}\nWorldEnd"


ROWS = "0 0 0 1 0 0 0 1 0\n"
XYZ = "property float x\nproperty float y\nproperty float z\n"
WHITE = (
    '<shape type="cube"><bsdf type="diffuse"><rgb name="reflectance" value="1 2"/></bsdf></shape>'
)
#: By name: content, and what the error must say.
BAD = {
    "m.obj": [
        ("", "empty"),
        ("# nothing\n", "no faces"),
        (TRIANGLE + "f 1 2 4\n", r"m.obj:4: .*vertex index 4, the file has 3"),
        (TRIANGLE + "f 1 2 0\n", r"m.obj:4: .*start at 1, got 0"),
        (TRIANGLE + "f 1 2 -4\n", r"m.obj:4: .*relative index -4"),
        (TRIANGLE + "f 1/1 2/1 3/1\n", r"m.obj:4: .*texture coordinate index 1, the file has 0"),
        (TRIANGLE + "f 1//2 2//2 3//2\n", r"m.obj:4: .*normal index 2"),
        (TRIANGLE + "f 1 2\n", "no faces"),
        (TRIANGLE + "f 1/2/3/4 2 3\n", r"m.obj:4: .*got '1/2/3/4'"),
        (TRIANGLE + "f a b c\n", r"m.obj:4: .*got 'a'"),
        (TRIANGLE + "f 1 2 99999999999\n", r"m.obj:4"),
        ("v 0 0 nan\n" + TRIANGLE + "f 1 2 3\n", r"m.obj:1: .*got 'nan'"),
        ("v 0 0 1e999\n" + TRIANGLE + "f 1 2 3\n", r"m.obj:1"),
        ("v 0 0\n" + TRIANGLE + "f 1 2 3\n", r"m.obj:1: 3 numbers are needed, got 2"),
        ("v 1e20 0 0\n" + TRIANGLE + "f 1 2 3\n", "at most 1e12"),
        (TRIANGLE + "f 1 2 3\n\0", "zero byte"),
    ],
    "m.ply": [
        ("", "empty"),
        ("plx\n", r"m.ply:1: not a PLY"),
        ("ply\nformat ascii 1.0\n", "end_header"),
        (PLY.replace("ascii", "binary") + "0", r"m.ply:2: format 'binary'"),
        (PLY.replace("float x", "half x"), r"m.ply:4: unknown property type 'half'"),
        (PLY.replace("vertex 3", "vertex 3000000000000"), "3000000000000 rows"),
        (PLY.replace("vertex 3", "vertex -3"), r"m.ply:3"),
        (PLY.replace(XYZ, ""), "cannot hold"),
        (PLY + ROWS + "3 0 1 3\n", r"m.ply:11: .*vertex index 3, the file has 3"),
        (PLY + ROWS + "3 0 1 -1\n", "vertex index -1"),
        (PLY + ROWS + "2 0 1\n", "no faces"),
        (PLY + ROWS + "3 0 1\n", "ends inside"),
        (PLY + "0 0 0 1 x 0 0 1 0\n3 0 1 2\n", r"m.ply:10: .*got 'x'"),
        (PLY + "0 0 0 1 nan 0 0 1 0\n3 0 1 2\n", "vertex 1 is"),
        (PLY.replace("face 1", "face 0") + ROWS, "no faces"),
        (PLY_BINARY + POINTS + struct.pack("<B3i", 3, 0, 1, 7), r"byte \d+: .*vertex index 7"),
        (PLY_BINARY + POINTS[:-4] + NAN + struct.pack("<B3i", 3, 0, 1, 2), "vertex 2 is"),
        (PLY_BINARY + POINTS + struct.pack("<B2i", 3, 0, 1), "ends inside"),
        (PLY_BINARY + POINTS[:20], r"rows|ends inside"),
        (PLY_BINARY.replace(b"uchar", b"uint") + POINTS + b"\xff" * 4, "cannot hold"),
    ],
    "s.xml": [
        ("<scene", r"s.xml:1: not well-formed"),
        ("<a/>", "must be <scene>"),
        (xml('<shape type="obj"/>'), r"s.xml:2: .*needs a filename"),
        (
            xml('<shape type="obj"><string name="filename" value="no.obj"/></shape>'),
            r"s.xml:2: .*no.obj: the file does not exist",
        ),
        (xml(ball("-1")), r"s.xml:2: .*radius"),
        (xml(ball("abc")), r"s.xml:2: .*'abc'"),
        (xml(cube('<matrix value="1 2 3"/>')), "16 or 9"),
        (xml(cube('<scale value="1e30"/>')), "at most 1e12"),
        (xml(cube('<scale value="nan"/>')), "finite number"),
        (
            xml('<sensor type="perspective"><float name="fov" value="180"/></sensor>'),
            "field of view",
        ),
        (xml(WHITE), "one or three numbers"),
        (xml('<shape type="cube"><bsdf type="twosided"/></shape>'), "needs a bsdf inside"),
        (xml("<a>" * 5000 + "</a>" * 5000), "nested more than 64"),
        (xml('<shape type="instance"><ref id="x"/></shape>'), "nothing has the id"),
    ],
    "s.pbrt": [
        ("WorldBegin\n", "ends before WorldEnd"),
        ("WorldBegin\nBogus\n", r"s.pbrt:2: a directive must stand here, got 'Bogus'"),
        ("Translate 1 2\nWorldBegin\n", r"s.pbrt:2: a finite number must stand here"),
        (PBRT.replace("0 1 2]", "0 1 3]"), r"s.pbrt:2: 'indices' holds 3.*, the mesh has 3"),
        (PBRT.replace("0 1 2]", "0 1]"), r"s.pbrt:2: 'indices' must be triples"),
        (PBRT.replace("[0 0 0", "[nan 0 0"), r"s.pbrt:2: vertex 0 is"),
        (PBRT.replace("WorldEnd", "AttributeEnd"), r"s.pbrt:3: AttributeEnd has no matching"),
        (PBRT.replace("WorldEnd", "AttributeBegin WorldEnd"), r"s.pbrt:3: this block does not end"),
        (PBRT.replace("]\n", "\n"), "must stand here"),
        (world('Include "s.pbrt"'), r"s.pbrt:2: the include of .*s.pbrt' is cyclic"),
        (world('Include "gone.pbrt"'), r"s.pbrt:2: .*gone.pbrt: the file does not exist"),
        (world('Shape "plymesh" "string filename" "gone.ply"'), r"s.pbrt:2: .*gone.ply"),
        (world('ObjectInstance "o"'), r"s.pbrt:2: the object 'o' is not defined"),
        (world('ObjectBegin "o" ObjectBegin "p"'), r"s.pbrt:2: ObjectBegin must not"),
        ('WorldBegin "unclosed\n', r"s.pbrt:1: a string does not end"),
        ('Scale 0 0 0\nCamera "perspective"\n' + PBRT, r"s.pbrt:2: .*no inverse"),
    ],
    "s.gltf": [("", "empty"), ("[1, 2]", "s.gltf: "), ("{", "s.gltf: ")],
    "s.glb": [(b"glTF\2\0\0\0", "s.glb: ")],
    "s.serialized": [
        (b"\x1c\x04\x04\x00", "s.serialized: "),
        (b"\x1c\x04\x09\x00" + bytes(20), "version 9"),
        (b"\x1c\x04\x04\x00" + bytes(20) + b"\xff\xff\xff\xff", "4294967295 shapes"),
    ],
    "s.stl": [("solid", r"unknown scene format '.stl'")],
}


@pytest.mark.parametrize(
    ("name", "content", "message"), [(name, *row) for name, rows in BAD.items() for row in rows]
)
def test_a_malformed_file_is_refused_with_file_and_place(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(core.SceneError, match=message) as caught:
        core.load_scene_file(str(path))
    assert name in str(caught.value)


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    with pytest.raises(core.SceneError, match=r"gone.obj: the file does not exist"):
        core.load_scene_file(str(tmp_path / "gone.obj"))
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(core.SceneError, match="not a regular file"):
        core.load_scene_file(str(tmp_path / "folder.obj"))


def test_serialized_counts_beyond_the_packed_bytes_are_refused_before_allocation(tmp_path):
    body = struct.pack("<I", 0x1000) + b"\0" + struct.pack("<QQ", 2**40, 2**40)
    data = b"\x1c\x04\x04\x00" + zlib.compress(body) + struct.pack("<QI", 0, 1)
    (tmp_path / "s.serialized").write_bytes(data)
    with pytest.raises(core.SceneError, match="1099511627776 vertices cannot come from"):
        core.load_scene_file(str(tmp_path / "s.serialized"))
