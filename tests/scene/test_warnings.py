"""What loaders say: one line for each kind of thing, with how often and where."""

import pytest

import viscache as vc

SHAPE = '<shape type="rectangle"><bsdf type="hair"/></shape>\n'


@pytest.mark.parametrize(
    ("shapes", "times"), [(1, ""), (2, " (2 times, also at "), (9, " (9 times, ")]
)
def test_one_line_for_each_kind(tmp_path, shapes, times):
    path = tmp_path / "scene.xml"
    path.write_text('<scene version="3.0.0">\n' + SHAPE * shapes + "</scene>")
    (warning,) = [text for text in vc.load_scene(path).warnings if "hair" in text]
    assert warning.startswith(f"{path}:2: ") and times in warning
    also = [f"{path}:{line}" for line in range(3, min(shapes, 3) + 2)]
    assert warning.endswith(f"also at {' and '.join(also)})" if also else "is used")
    with pytest.raises(vc.SceneError, match="hair"):
        vc.load_scene(path, strict=True)
