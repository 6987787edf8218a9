"""Values of a file that only the whole scene can refuse are refused with the file's name."""

import pytest

import viscache as vc

TRIANGLE = (
    'Shape "trianglemesh" "integer indices" [0 1 2] "point P" [0 0 0 1 0 0 0 1 0]\nWorldEnd\n'
)
GLTF = (
    '{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"camera": 0,'
    ' "translation": [0, 0, 1e18]}], "cameras": [{"type": "perspective", "perspective":'
    ' {"yfov": 1, "znear": 1}}]}'
)
OBJ = "mtllib wide.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"
XML = (
    '<scene version="3.0.0"><sensor type="perspective"><transform name="to_world">'
    '<translate x="1e18"/></transform></sensor></scene>'
)
BAD = [
    ("wide.pbrt", f'WorldBegin\nMaterial "glass" "float eta" [1e9]\n{TRIANGLE}', "eta must be in"),
    ("wide.pbrt", f'Translate 0 0 9e18\nCamera "perspective"\nWorldBegin\n{TRIANGLE}', "camera"),
    (
        "wide.pbrt",
        'WorldBegin\nTranslate 1e15 0 0\nAttributeBegin\nAreaLightSource "diffuse"\n'
        'Shape "sphere"\nAttributeEnd\nWorldEnd\n',
        "1e12",
    ),
    ("wide.obj", OBJ, "emission must be finite and >= 0"),
    ("wide.gltf", GLTF, "camera"),
    ("wide.xml", XML, "camera"),
]


@pytest.mark.parametrize(("name", "content", "says"), BAD)
def test_values_out_of_range_are_refused_with_the_files_name(tmp_path, name, content, says):
    (tmp_path / name).write_text(content)
    (tmp_path / "wide.mtl").write_text("newmtl a\nKe 1 -2 1\n")
    with pytest.raises(vc.SceneError, match=says) as caught:
        vc.load_scene(tmp_path / name, threads=1)
    text = str(caught.value)
    assert text.startswith(f"{tmp_path / name}: ") and text.count(name) == 1
