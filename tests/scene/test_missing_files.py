"""Mesh files that are not there: an error that says what helps, or shapes are left out."""

import json
import pickle

import pytest

import viscache as vc
from viscache import cli

TRIANGLE = 'Shape "trianglemesh" "integer indices" [0 1 2] "point P" [0 0 0  1 0 0  0 1 0]'
XML = """<scene version="3.0.0"><shape type="rectangle"/>
<shape type="{kind}"><string name="filename" value="gone.{kind}"/></shape></scene>"""


def written(folder, kind):
    path = folder / ("scene.pbrt" if kind == "plymesh" else "scene.xml")
    pbrt = f'WorldBegin\nShape "plymesh" "string filename" "gone.ply"\n{TRIANGLE}\nWorldEnd\n'
    path.write_text(pbrt if kind == "plymesh" else XML.format(kind=kind))
    return path


@pytest.mark.parametrize("kind", ["obj", "ply", "serialized", "plymesh"])
def test_a_missing_mesh_is_an_error_or_left_out(tmp_path, kind):
    path = written(tmp_path, kind)
    with pytest.raises(
        vc.SceneError, match=r'scene\.\w+:2: .*gone.*does not exist; missing="skip"'
    ):
        vc.load_scene(path)
    scene = vc.load_scene(path, missing="skip")
    assert scene.triangles == (1 if kind == "plymesh" else 2)
    [warning] = [w for w in scene.warnings if "gone" in w]
    assert f"{path.name}:2" in warning and "the shape is left out" in warning
    with pytest.raises(vc.SceneError, match="the shape is left out"):
        vc.load_scene(path, missing="skip", strict=True)
    with pytest.raises(ValueError, match='missing must be "error" or "skip"'):
        vc.load_scene(path, missing="Skip")  # type: ignore[arg-type]


def test_a_broken_mesh_is_an_error_all_the_same(tmp_path):
    path = written(tmp_path, "ply")
    (tmp_path / "gone.ply").write_text("ply\nnonsense\n")
    with pytest.raises(vc.SceneError, match=r"gone\.ply"):
        vc.load_scene(path, missing="skip")


def test_a_scene_without_its_missing_parts_travels(tmp_path):
    scene = vc.load_scene(written(tmp_path, "ply"), missing="skip")
    back = pickle.loads(pickle.dumps(scene))
    assert back.content_hash == scene.content_hash


def test_the_command_line_leaves_missing_meshes_out(tmp_path, capsys):
    path = str(written(tmp_path, "obj"))
    assert cli.main(["info", path]) == cli.BAD_USAGE
    assert 'missing="skip"' in capsys.readouterr().err
    assert cli.main(["info", path, "--missing", "skip", "--json"]) == cli.OK
    info = json.loads(capsys.readouterr().out)
    assert info["triangles"] == 2 and "left out" in info["warnings"][0]


def test_a_sweep_leaves_missing_meshes_out_too(tmp_path, capsys):
    written(tmp_path, "obj")
    file = tmp_path / "sweep.toml"
    text = 'scene = "scene.xml"\nintegrator = "direct"\nsize = [8, 8]\nmetrics = ["rel_l1"]\n'
    file.write_text(text + "[over]\nc_e = [4]\n")
    command = ["sweep", str(file), "-o", str(tmp_path / "out")]
    assert cli.main(command) == cli.BAD_USAGE
    assert 'missing="skip"' in capsys.readouterr().err
    assert cli.main([*command, "--missing", "skip"]) == cli.OK
    # The key of the file does the same
    file.write_text(f'{text}missing = "skip"\n[over]\nc_e = [4, 8]\n')
    assert cli.main(command) == cli.OK
    file.write_text(f'{text}missing = "Skip"\n[over]\nc_e = [4]\n')
    assert cli.main(command) == cli.BAD_USAGE
    assert 'missing must be "error" or "skip"' in capsys.readouterr().err
    file.write_text(f"{text}allow_outside = 1\n[over]\nc_e = [4]\n")
    assert cli.main(command) == cli.BAD_USAGE
    assert "allow_outside must be true or false" in capsys.readouterr().err
