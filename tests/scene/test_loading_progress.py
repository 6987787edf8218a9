"""Loading tells of its steps: the file, EXR images one by one, and the structure."""

import numpy as np
import OpenEXR
import pytest

import viscache as vc

XML = """<scene version="3.0.0">
<shape type="rectangle"><bsdf type="diffuse">
<texture name="reflectance" type="bitmap"><string name="filename" value="a.exr"/></texture>
</bsdf></shape></scene>"""


@pytest.fixture
def scene_file(tmp_path):
    pixels = np.full((4, 4, 3), 0.5, np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": pixels}).write(str(tmp_path / "a.exr"))
    path = tmp_path / "scene.xml"
    path.write_text(XML)
    return path


def test_a_callable_gets_every_step(scene_file):
    told = []
    vc.load_scene(scene_file, progress=lambda done, total: told.append((done, total)))
    assert told == [(0, 2), (1, 3), (2, 3), (3, 3)]


def test_an_error_of_an_image_ends_the_steps(scene_file):
    (scene_file.parent / "a.exr").write_bytes(b"no picture")
    told = []
    with pytest.raises(vc.SceneError, match="not an OpenEXR file"):
        vc.load_scene(scene_file, progress=lambda done, total: told.append((done, total)))
    assert told == [(0, 2), (1, 3)]


def test_true_shows_a_bar(scene_file, capsys):
    vc.load_scene(scene_file, progress=True)
    assert "step" in capsys.readouterr().err
