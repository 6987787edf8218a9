"""Where Mitsuba 3 has a rule of its own: it is followed, or what differs is named with its line."""

import pickle

import numpy as np
import pytest
from skimage.io import imsave

import viscache as vc
from scene import picture_files
from scene import test_mitsuba_parity as parity

BOX = """<shape type="cube"><transform name="to_world"><scale value="0.5"/>
<translate x="0.3" y="0.5"/></transform></shape>"""
SUN = """
<emitter type="directional"><transform name="to_world">{}<rotate x="1" angle="120"/></transform>
<rgb name="irradiance" value="3,2,1"/></emitter>"""


def sunny(folder, steps):
    return parity.write(folder, BOX + SUN.format(steps))


@pytest.mark.mitsuba
def test_a_transform_that_scales_makes_a_sun_brighter_as_in_mitsuba(tmp_path):
    path = sunny(tmp_path, '<scale value="4"/>')
    ours, theirs = parity.of_viscache(path), parity.of_mitsuba(path)
    assert parity.agreement(ours, theirs) >= 0.95
    (warning,) = vc.load_scene(path).warnings
    line = path.read_text().partition("<emitter")[0].count("\n") + 1
    assert f"scene.xml:{line}: a transform that scales" in warning
    # Power: the light without the scale would be noticed, and needs no warning
    plain = sunny(tmp_path, "")
    assert not vc.load_scene(plain).warnings
    assert parity.agreement(parity.of_viscache(plain), theirs) < 0.7
    # Mitsuba 0.6 takes the direction alone
    old = sunny(tmp_path, '<scale value="4"/>')
    old.write_text(old.read_text().replace("3.0.0", "0.6.0"))
    assert not vc.load_scene(old).warnings


def sky_scene(folder, rows):
    pixels = np.full((rows, 2 * rows, 3), 90, np.uint8)
    imsave(folder / "sky.png", pixels, check_contrast=False)
    body = '\n<emitter type="envmap"><string name="filename" value="sky.png"/></emitter>'
    return vc.load_scene(parity.write(folder, body))


def sunny_sky(folder, row, column):
    """A dim sky whose light comes from one pixel; and its pixels."""
    rgbe = np.full((128, 256, 4), (164, 164, 164, 136 - 13), np.uint8)
    rgbe[row, column] = 187, 187, 187, 136 + 4
    (folder / "sky.hdr").write_bytes(picture_files.hdr("-Y 128 +X 256", rgbe.tobytes()))
    body = '\n<emitter type="envmap"><string name="filename" value="sky.hdr"/></emitter>'
    pixels = rgbe[..., 0] * 2.0 ** (rgbe[..., 3].astype(float) - 136)
    return vc.load_scene(parity.write(folder, body)), pixels


def bright_row(folder, row):
    return sunny_sky(folder, row, 90)[0]


def test_a_sun_in_the_second_row_of_a_sky_lights_the_floor_by_its_solid_angle(tmp_path):
    scene, pixels = sunny_sky(tmp_path, 1, 90)
    rows = np.cos(np.arange(129) / 128 * np.pi)
    # The integral of the cosine over the pixels of a row above the floor
    up = np.maximum(rows, 0) ** 2
    irradiance = (pixels.mean(1) * (up[:-1] - up[1:])).sum() * np.pi
    image = vc.render(scene, vc.Direct(), spp=32).image
    # A floor of the reflectance 1/2
    assert image[-16:].mean() == pytest.approx(0.5 / np.pi * irradiance, rel=0.01)


def test_skies_of_few_rows_are_warned_of_in_mitsuba_files(tmp_path):
    scene = sky_scene(tmp_path, 16)
    (warning,) = scene.warnings
    assert "scene.xml:" in warning and "a sky of 16 rows, which Mitsuba places" in warning
    assert pickle.loads(pickle.dumps(scene)).warnings == scene.warnings
    assert not sky_scene(tmp_path, 128).warnings
    assert not bright_row(tmp_path, 64).warnings
    for row in (0, 3, 127):
        (warning,) = bright_row(tmp_path, row).warnings
        assert "scene.xml:" in warning and "a sky bright at a pole, which Mitsuba" in warning
    # A sky from Python has no Mitsuba beside it
    array = np.ones((16, 32, 3), np.float32)
    plain = parity.write(tmp_path, "")
    assert not vc.load_scene(plain, env=array).warnings


def test_vertex_normals_behind_their_faces_are_warned_of(tmp_path):
    (tmp_path / "tent.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\n"
        + "".join(f"property float {n}\n" for n in ("x", "y", "z", "nx", "ny", "nz"))
        + "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 1 0 -0.2\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"
    )
    tent = '\n<shape type="ply"><string name="filename" value="tent.ply"/>{}</shape>'
    lamp = '<emitter type="constant"/>'
    path = parity.write(tmp_path, lamp + tent.format(""))
    (warning,) = vc.load_scene(path).warnings
    line = path.read_text().partition('<shape type="ply"')[0].count("\n") + 1
    assert f"scene.xml:{line}: vertex normals point behind their faces" in warning
    flat = '<boolean name="face_normals" value="true"/>'
    assert not vc.load_scene(parity.write(tmp_path, lamp + tent.format(flat))).warnings
    # Power: normals that lean by less need no warning
    upright = (tmp_path / "tent.ply").read_text().replace("1 0 -0.2", "1 0 0.2")
    (tmp_path / "tent.ply").write_text(upright)
    assert not vc.load_scene(parity.write(tmp_path, lamp + tent.format(""))).warnings
