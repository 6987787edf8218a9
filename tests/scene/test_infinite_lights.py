"""pbrt: infinite lights add up, constant or of images with any rotation and size."""

import numpy as np
import OpenEXR
import pytest

import viscache as vc
from viscache import _core as core

FLOOR = 'Shape "trianglemesh" "point P" [-9 0 9 9 0 9 0 0 -9] "integer indices" [0 1 2]'
CONSTANT = 'LightSource "infinite" "rgb L" [.3 .1 .2]'
#: Rotations of the sky against the floor, so that light of all directions is asked for.
TURNS = ("", "Rotate 90 1 0 0", "Rotate 180 1 0 0", "Rotate 90 0 0 1", "Rotate 200 1 2 3")


def described(folder, lights, strict=True):
    path = folder / "scene.pbrt"
    path.write_text(
        'LookAt 0 1 0  0 0 0  0 0 1\nCamera "perspective" "float fov" 20\nFilm "image"\n'
        f'WorldBegin\n{lights}\nMaterial "matte" "rgb Kd" [.6 .6 .6]\n{FLOOR}\nWorldEnd\n'
    )
    return core.load_scene_file(str(path), strict)


def floor(folder, lights):
    """Mean colour of a floor under the sky, for each of the turns."""
    found = []
    for turn in TURNS:
        described(folder, f"AttributeBegin {turn} {lights} AttributeEnd")
        scene = vc.load_scene(folder / "scene.pbrt", strict=True)
        frame = vc.render(scene, vc.Direct(n_environment=64), size=(8, 8), spp=64)
        found.append(frame.image.mean((0, 1)))
    return np.array(found, np.float64)


@pytest.fixture(scope="module")
def skies(tmp_path_factory):
    """Two images of skies, each with a bright patch of its own."""
    folder = tmp_path_factory.mktemp("skies")
    rng = np.random.default_rng(1)
    for name, height in (("large", 96), ("small", 40)):
        pixels = rng.random((height, 2 * height, 3)).astype(np.float32) * np.float32(
            [0.4, 0.3, 0.2]
        )
        pixels[height // 4 : height // 3, height // 2 : height] += np.float32([3, 2, 1])
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, {"RGB": pixels}).write(str(folder / f"{name}.exr"))
    return folder


def image(name, turn=""):
    return (
        f'AttributeBegin {turn} LightSource "infinite" "string mapname" "{name}.exr" AttributeEnd'
    )


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (CONSTANT, image("large")),
        (image("small"), CONSTANT),
        (image("large"), image("large")),
        (image("large"), image("small")),
        (image("small", "Rotate 70 1 1 0"), image("large", "Rotate 40 0 1 1")),
    ],
    ids=["constant first", "constant last", "same", "sizes", "rotations"],
)
def test_the_light_of_two_is_the_sum_of_their_light(skies, one, other):
    both, alone = floor(skies, f"{one} {other}"), floor(skies, one) + floor(skies, other)
    np.testing.assert_allclose(both, alone, rtol=0.02)
    np.testing.assert_allclose(both.mean(0), alone.mean(0), rtol=0.006)
    # Power: each of them matters
    assert np.all(floor(skies, one) < 0.9 * both)


def test_a_note_says_that_images_are_resampled(skies):
    lights = f"{CONSTANT} {CONSTANT}\n{image('small')}"
    [(where, text)] = described(skies, lights).warnings
    assert where.endswith("scene.pbrt:6") and "resampled into one map" in text


def test_a_missing_image_leaves_the_others(skies):
    missing = 'LightSource "infinite" "string mapname" "none.hdr"'
    for lights in (f"{missing} {CONSTANT}", f"{CONSTANT} {missing}"):
        scene = described(skies, lights, strict=False)
        assert any("does not exist" in text for _, text in scene.warnings)
        scene = vc.load_scene(skies / "scene.pbrt")
        frame = vc.render(scene, vc.Direct(n_environment=64), size=(4, 4), spp=16)
        np.testing.assert_allclose(frame.image.mean((0, 1)), [0.18, 0.06, 0.12], rtol=1e-3)


def test_an_environment_of_the_caller_replaces_all(skies):
    described(skies, f"{image('small')} {image('large')}")
    scene = vc.load_scene(skies / "scene.pbrt", env=0.5)
    frame = vc.render(scene, vc.Direct(n_environment=64), size=(4, 4), spp=16)
    np.testing.assert_allclose(frame.image.mean((0, 1)), [0.3] * 3, rtol=1e-3)


def test_the_illuminance_of_an_image_is_warned_of(skies):
    light = 'LightSource "infinite" "string mapname" "small.exr" "float illuminance" 3'
    scene = described(skies, light, strict=False)
    assert "'illuminance'" in scene.warnings[0][1] and scene.lights[0]["scale"] == [1, 1, 1]


def test_their_number_is_bounded(skies):
    with pytest.raises(core.SceneError, match="at most 16 infinite lights"):
        described(skies, " ".join([image("small")] * 17))
