"""Images of 8 bits stay bytes in a scene, and look like the floats that they stand for."""

import pickle

import numpy as np
import pytest

import viscache as vc
from scene import picture_files as files
from viscache import _core as core

RNG = np.random.default_rng(8)
SIZE = 64

OBJ = (
    "mtllib m.mtl\nusemtl a\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
    "vt 0 0\nvt 1.7 0\nvt 1.7 1.3\nvt 0 1.3\nf 1/1 2/2 3/3 4/4\n"
)


def textured(folder, pixels):
    """A square with a texture that repeats."""
    (folder / "t.png").write_bytes(files.png(pixels))
    (folder / "m.mtl").write_text("newmtl a\nKd 1 1 1\nmap_Kd t.png\n")
    (folder / "s.obj").write_text(OBJ)
    return folder / "s.obj"


def with_floats(path):
    """The same scene whose image is given as floats."""
    description = core.load_scene_file(str(path))
    description.set_image(0, description.image_pixels(0))
    return description


def seen(scene, env=1.0):
    camera = vc.look_at((0.3, 0.2, 2.5), (0, 0, 0), fov_deg=50)
    lit = scene if env is None else scene.with_environment(env)
    return vc.render(lit, vc.Direct(), camera=camera, size=(32, 20), spp=2).image.tobytes()


@pytest.fixture
def colors():
    return RNG.integers(0, 256, (SIZE, SIZE, 3), dtype=np.uint8)


def test_images_have_the_bits_of_their_files(tmp_path, colors):
    kept = core.load_scene_file(str(textured(tmp_path, colors))).images[0]
    assert (kept["bits"], kept["width"], kept["channels"]) == (8, SIZE, 3)
    deep = core.load_scene_file(str(textured(tmp_path, colors.astype(np.uint16) * 250)))
    assert deep.images[0]["bits"] == 32


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_bytes_look_like_the_floats_that_they_stand_for(tmp_path, channels):
    pixels = RNG.integers(0, 256, (SIZE, SIZE, channels), dtype=np.uint8)
    path = textured(tmp_path, pixels)
    bytes_scene, float_scene = vc.load_scene(path), vc.Scene.from_description(with_floats(path))
    assert seen(bytes_scene) == seen(float_scene)
    assert bytes_scene.content_hash == float_scene.content_hash
    changed = pixels.copy()
    changed[3, 4, 0] ^= 1
    other = vc.load_scene(textured(tmp_path, changed))
    assert other.content_hash != bytes_scene.content_hash
    assert seen(vc.load_scene(textured(tmp_path, 255 - pixels))) != seen(bytes_scene)


@pytest.mark.parametrize("odd", [False, True])
def test_a_mask_of_bytes_has_the_geometry_of_its_floats(tmp_path, odd):
    size = 5 if odd else 6
    mask = RNG.integers(0, 256, (size, size, 1), dtype=np.uint8)
    path = textured(tmp_path, mask)
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 1 1\nmap_d t.png\n")
    scene, same = vc.load_scene(path), vc.Scene.from_description(with_floats(path))
    assert scene.geometry_hash == same.geometry_hash
    (tmp_path / "t.png").write_bytes(files.png(255 - mask))
    assert vc.load_scene(path).geometry_hash != scene.geometry_hash


def test_textures_take_a_byte_per_value(tmp_path, colors):
    path = textured(tmp_path, colors)
    kept = vc.load_scene(path).info()["memory_bytes"]
    expanded = vc.Scene.from_description(with_floats(path)).info()["memory_bytes"]
    assert expanded - kept == 3 * colors.size


def test_bytes_travel_and_can_be_replaced(tmp_path, colors):
    description = core.load_scene_file(str(textured(tmp_path, colors)))
    back = pickle.loads(pickle.dumps(description))
    assert back.images == description.images
    assert np.array_equal(back.image_pixels(0), description.image_pixels(0))
    back.set_image(0, np.full((2, 2, 1), 0.5, np.float32))
    assert back.images[0]["bits"] == 32
    assert np.array_equal(back.image_pixels(0), np.full((2, 2, 1), 0.5, np.float32))


def test_a_sky_of_bytes_is_the_sky_of_its_floats(tmp_path):
    pixels = RNG.integers(0, 256, (8, 16, 3), dtype=np.uint8)
    sky = tmp_path / "sky.png"
    sky.write_bytes(files.png(pixels))
    xml = tmp_path / "s.xml"
    xml.write_text(
        '<scene version="3.0.0"><shape type="sphere"><float name="radius" value="0.1"/></shape>'
        '<emitter type="envmap"><string name="filename" value="sky.png"/></emitter></scene>'
    )
    described = core.load_scene_file(str(xml))
    assert described.images[0]["bits"] == 8
    in_bytes = vc.Scene.from_description(described)
    described.set_image(0, described.image_pixels(0))
    assert seen(in_bytes, None) == seen(vc.Scene.from_description(described), None)


def test_skies_have_a_largest_size(tmp_path):
    width, height = 1 << 14, (1 << 13) + 1
    sky = tmp_path / "sky.png"
    sky.write_bytes(files.png(np.zeros((height, width, 1), np.uint8)))
    xml = tmp_path / "s.xml"
    xml.write_text(
        '<scene version="3.0.0"><shape type="sphere"/>'
        '<emitter type="envmap"><string name="filename" value="sky.png"/></emitter></scene>'
    )
    with pytest.raises(vc.SceneError, match=r"16384 x 8193 pixels; skies have at most 2\^27"):
        vc.load_scene(xml)


def test_bytes_of_a_description_with_too_few_values_are_refused(tmp_path, colors):
    description = core.load_scene_file(str(textured(tmp_path, colors)))
    size = SIZE.to_bytes(4, "little")
    damaged = pickle.dumps(description).replace(size + size, b"\xff\x0f\0\0" + size)
    with pytest.raises(vc.SceneError, match="must have a value per channel and pixel"):
        vc.Scene.from_description(pickle.loads(damaged))


def test_the_memory_of_a_scene_counts_its_sky(tmp_path, colors):
    path = textured(tmp_path, colors)
    bare = vc.load_scene(path).info()["memory_bytes"]
    sky = RNG.random((64, 128, 3), dtype=np.float32)
    lit = vc.load_scene(path, env=sky).info()["memory_bytes"]
    # Its pixels, and the map of 128 x 128 texels: 12 bytes each, and 12 for the tables of four
    assert lit - bare == pytest.approx(sky.nbytes + 128 * 128 * 15, rel=0.05)
