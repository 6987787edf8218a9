"""A scene reads files of its own folder, and others only when that is allowed."""

import pickle

import numpy as np
import pytest

import viscache as vc
from scene import picture_files as files
from viscache import _core as core
from viscache.cli import main
from viscache_lab.parity.exporters.formats import ply

TRIANGLE = "ascii; $P; face 1 list uchar int vertex_indices 0 1 2"
MESH = '<shape type="ply"><string name="filename" value="{}"/></shape>'
TEXTURED = (
    '<shape type="rectangle"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">'
    '<string name="filename" value="{}"/></texture></bsdf></shape>'
)


@pytest.fixture
def folder(tmp_path):
    """`top/place/scene`, where scenes lie; `top` and `place` hold files, too."""
    made = tmp_path / "top" / "place" / "scene"
    made.mkdir(parents=True)
    return made


def put(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".ply":
        path.write_bytes(ply("m", TRIANGLE)["m.ply"])
    else:
        path.write_bytes(files.png(np.full((2, 2, 3), 128, np.uint8)))
    return path


def xml(folder, body):
    path = folder / "s.xml"
    path.write_text(f'<scene version="3.0.0">{body}</scene>')
    return path


INSIDE = ["m.ply", "deep/er/m.ply", "../scene/m.ply", "../meshes/m.ply", "../Textures/a/m.ply"]
OUTSIDE = [
    "../m.ply",
    "../other/m.ply",
    "../../m.ply",
    "../other/meshes/m.ply",
    "../../../meshes/m.ply",
]


@pytest.mark.parametrize("name", [*INSIDE, "../hdr/m.ply", "../../common/meshes/m.ply"])
def test_files_of_the_folder_and_of_assets_beside_it_are_read(folder, name):
    put(folder / name)
    assert core.load_scene_file(str(xml(folder, MESH.format(name)))).triangle_count == 1


@pytest.mark.parametrize("name", OUTSIDE)
def test_other_files_are_refused_unless_allowed(folder, name):
    put(folder / name)
    scene = xml(folder, MESH.format(name))
    with pytest.raises(vc.SceneError, match=r"m\.ply: the file lies outside .* allow_outside=True"):
        vc.load_scene(scene)
    assert vc.load_scene(scene, allow_outside=True).triangles == 1


def test_absolute_names_follow_the_same_rule(folder):
    for path, inside in ((folder / "m.ply", True), (folder.parent / "m.ply", False)):
        scene = xml(folder, MESH.format(put(path)))
        if inside:
            assert vc.load_scene(scene).triangles == 1
        else:
            with pytest.raises(vc.SceneError, match="allow_outside=True"):
                vc.load_scene(scene)


def test_links_are_followed(folder):
    put(folder.parent / "m.ply")
    (folder / "link.ply").symlink_to(folder.parent / "m.ply")
    (folder / "place").symlink_to(folder.parent)
    for name in ("link.ply", "place/m.ply"):
        with pytest.raises(vc.SceneError, match="lies outside"):
            vc.load_scene(xml(folder, MESH.format(name)))
    put(folder / "inside.ply")
    (folder / "good.ply").symlink_to("inside.ply")
    assert vc.load_scene(xml(folder, MESH.format("good.ply"))).triangles == 1


def test_the_scene_itself_may_be_a_link(folder, tmp_path):
    put(tmp_path / "here" / "m.ply")
    (tmp_path / "here" / "link.xml").symlink_to(xml(folder, MESH.format("m.ply")))
    assert vc.load_scene(tmp_path / "here" / "link.xml").triangles == 1


@pytest.mark.parametrize("suffix", ["png", "exr"])
def test_a_texture_outside_is_left_out_with_a_warning_or_refused_when_strict(folder, suffix):
    put(folder.parent / f"t.{suffix}")
    scene = xml(folder, TEXTURED.format(f"../t.{suffix}"))
    ((where, warning),) = core.load_scene_file(str(scene)).warnings
    assert where == f"{scene}:1" and "allow_outside=True" in warning
    assert f"t.{suffix}: the file lies outside" in warning and "it is left out" in warning
    with pytest.raises(vc.SceneError, match="lies outside"):
        vc.load_scene(scene, strict=True)


def test_a_texture_outside_is_read_when_allowed(folder):
    put(folder.parent / "t.png")
    scene = str(xml(folder, TEXTURED.format("../t.png")))
    description = core.load_scene_file(scene, allow_outside=True)
    assert description.warnings == [] and description.images[0]["width"] == 2


def test_a_missing_file_outside_tells_nothing(folder):
    with pytest.raises(vc.SceneError, match="lies outside"):
        vc.load_scene(xml(folder, MESH.format("../nothing.ply")))


def test_includes_count_too(folder):
    (folder.parent / "part.xml").write_text(
        f'<scene version="3.0.0">{MESH.format("m.ply")}</scene>'
    )
    with pytest.raises(vc.SceneError, match=r"part\.xml: the file lies outside"):
        vc.load_scene(xml(folder, '<include filename="../part.xml"/>'))
    # What an included file names is held against the folder of the main file.
    (folder / "sub").mkdir()
    body = MESH.format("../../m.ply")
    (folder / "sub" / "part.xml").write_text(f'<scene version="3.0.0">{body}</scene>')
    put(folder.parent / "m.ply")
    with pytest.raises(vc.SceneError, match="lies outside"):
        vc.load_scene(xml(folder, '<include filename="sub/part.xml"/>'))


def test_other_formats_follow_the_rule(folder):
    put(folder.parent / "m.ply")
    (folder / "s.pbrt").write_text(
        'WorldBegin\nShape "plymesh" "string filename" "../m.ply"\nWorldEnd\n'
    )
    (folder.parent / "b.bin").write_bytes(bytes(36))
    (folder / "s.gltf").write_text(
        '{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 36, "uri": "../b.bin"}]}'
    )
    (folder.parent / "m.mtl").write_text("newmtl a\n")
    (folder / "s.obj").write_text("mtllib ../m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for name in ("s.pbrt", "s.gltf"):
        with pytest.raises(vc.SceneError, match="lies outside"):
            vc.load_scene(folder / name)
    assert any("lies outside" in w for w in vc.load_scene(folder / "s.obj").warnings)


def test_a_scene_with_files_from_outside_travels(folder):
    put(folder.parent / "m.ply")
    scene = vc.load_scene(xml(folder, MESH.format("../m.ply")), allow_outside=True)
    back = pickle.loads(pickle.dumps(scene))
    assert back.content_hash == scene.content_hash and back.triangles == 1


def test_the_command_line_allows_it(folder, capsys):
    put(folder.parent / "m.ply")
    scene = str(xml(folder, MESH.format("../m.ply")))
    assert main(["info", scene]) != 0
    assert "allow_outside=True" in capsys.readouterr().err
    assert main(["info", scene, "--allow-outside"]) == 0
    assert "triangles" in capsys.readouterr().out


@pytest.mark.parametrize(
    "workers",
    [[], pytest.param(["--workers", "2"], marks=pytest.mark.slow)],
    ids=["here", "workers"],
)
def test_sweeps_allow_it_too(folder, capsys, workers):
    put(folder.parent / "m.ply")
    scene = xml(folder, MESH.format("../m.ply"))
    file = folder / "sweep.toml"
    file.write_text(
        f'scene = "{scene.name}"\nintegrator = "direct"\nsize = [8, 8]\nmetrics = ["rel_l1"]\n'
        "[over]\nc_e = [4]\n"
    )
    command = ["sweep", str(file), "-o", str(folder / "out"), *workers]
    assert main(command) != 0
    assert "allow_outside=True" in capsys.readouterr().err
    assert main([*command, "--allow-outside"]) == 0
