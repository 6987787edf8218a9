# ruff: noqa: E501  (scene texts stay on their lines)
"""pbrt-v3 text scenes: directives, materials, shapes, lights, cameras."""

import numpy as np
import pytest

import viscache as vc
from viscache import _core as core

K = core.MaterialKind
TRIANGLE = 'Shape "trianglemesh" "integer indices" [0 1 2] "point P" [0 0 0  1 0 0  0 1 0]\n'


def load(folder, world, head="", strict=True):
    path = folder / "scene.pbrt"
    path.write_text(f"{head}\nWorldBegin\n{world}\nWorldEnd\n")
    return core.load_scene_file(str(path), strict)


def test_camera_space_is_a_named_coordinate_system(tmp_path):
    scene = load(
        tmp_path, f'CoordSysTransform "camera" {TRIANGLE}', 'Translate 0 0 -7\nCamera "perspective"'
    )
    np.testing.assert_allclose(scene.bounds()[0], [0, 0, 7], atol=1e-6)


def test_materials_have_their_nearest_kinds(tmp_path):
    world = "".join(
        f"Material {m} {TRIANGLE}"
        for m in (
            '"plastic" "rgb Ks" [1 1 1] "float roughness" [.2] "bool remaproughness" "false"',
            '"metal" "float uroughness" .1 "float vroughness" .4 "bool remaproughness" "false"',
            '"glass" "float index" [1.7]',
        )
    )
    scene = load(tmp_path, world, strict=False)
    m = [scene.materials[mesh["material"]] for mesh in scene.meshes]
    assert [x["kind"] for x in m] == [K.GLOSSY, K.GLOSSY, K.DIELECTRIC]
    assert m[0]["specular"] == pytest.approx([0.04] * 3) and m[0]["roughness"] == pytest.approx(0.2)
    assert m[1]["roughness"] == pytest.approx(0.2) and m[2]["eta"] == pytest.approx(1.7)


def test_what_is_not_defined_is_warned_of_as_pbrt_does(tmp_path):
    scene = load(
        tmp_path,
        f"""Material "matte" "rgb Kd" [.1 .2 .3] NamedMaterial "x" {TRIANGLE}
        Material "matte" "texture Kd" "x" {TRIANGLE}""",
        strict=False,
    )
    colors = [scene.materials[m["material"]]["base_color"] for m in scene.meshes]
    assert colors == [pytest.approx([0.1, 0.2, 0.3]), pytest.approx([0.5] * 3)]
    texts = [": ".join(w) for w in scene.warnings]
    assert "scene.pbrt:3: the material 'x' is not defined; the one before is kept" in texts[0]
    assert "scene.pbrt:5: the texture 'x' is not defined; the default is used" in texts[1]


def test_blocks_of_attributes_and_objects_end_each_other_and_alpha_0_is_invisible(tmp_path):
    scene = load(
        tmp_path,
        f"""AttributeBegin ObjectBegin "a" AttributeBegin {TRIANGLE} AttributeEnd AttributeEnd ObjectEnd
        ObjectInstance "a" Translate 1 0 0 ObjectInstance "a"
        {TRIANGLE.strip()} "float alpha" 0""",
    )
    assert len(scene.instances) == 2 and len(scene.meshes) == 1
    with pytest.raises(core.SceneError, match=r"scene.pbrt:3: TransformEnd has no matching begin"):
        load(tmp_path, "AttributeBegin TransformEnd")


def test_an_image_of_alpha_cuts_holes_where_it_is_0(tmp_path):
    (tmp_path / "a.tga").write_bytes(bytes([0, 0, 3, *[0] * 9, 2, 0, 1, 0, 8, 0, 0, 1]))
    square = '"point P" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] "integer indices" [0 1 2 0 2 3]'
    load(
        tmp_path,
        f"""Texture "a" "float" "imagemap" "string filename" "a.tga" "bool gamma" "false"
        Shape "trianglemesh" {square} "float uv" [.25 0 .75 0 .75 1 .25 1] "texture alpha" "a"
        LightSource "point" """,
    )
    scene = vc.load_scene(tmp_path / "scene.pbrt")
    x = np.linspace(-0.99, 0.99, 100)
    a = np.stack([x, 0 * x, 0 * x + 1], 1)
    # Between the two pixels every value but the first is above 0
    assert scene.visible(a, a * [1, 1, -1]).sum() <= 2


def test_an_infinite_light_keeps_z_up_and_its_columns(tmp_path):
    """Ours: d at u = atan2(d.x, -d.z)/2pi, v = acos(d.y)/pi; pbrt's: u = atan2(y, x)/2pi, v = acos(z)/pi."""
    scene = load(tmp_path, 'Rotate 30 0 1 0 LightSource "infinite" "rgb L" [1 1 1]')
    to_world = np.array(scene.lights[0]["to_world"])[:, :3]
    angle = np.radians(30)
    pbrt = np.array(
        [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    )
    rng = np.random.default_rng(1)
    for world in rng.normal(size=(50, 3)):
        world /= np.linalg.norm(world)
        d, local = np.linalg.inv(to_world) @ world, pbrt.T @ world
        u = np.arctan2(d[0], -d[2]) / (2 * np.pi) % 1
        assert u == pytest.approx(np.arctan2(local[1], local[0]) / (2 * np.pi) % 1, abs=1e-6)
        assert np.arccos(d[1]) == pytest.approx(np.arccos(local[2]), abs=1e-6)


def test_an_emitting_sphere_is_a_light(tmp_path):
    scene = load(
        tmp_path,
        """AttributeBegin AreaLightSource "area" "rgb L" [1 2 3] Translate 1 2 3 Scale 2 2 2
        Shape "sphere" "float radius" 0.5 AttributeEnd Shape "sphere" """,
    )
    light = scene.lights[0]
    assert light["kind"] == "sphere" and light["center"] == [1, 2, 3] and light["radius"] == 1
    assert len(scene.meshes) == 1 and len(scene.lights) == 1


def test_included_files_name_theirs_from_the_folder_of_the_main_file(tmp_path):
    (tmp_path / "geometry").mkdir()
    (tmp_path / "geometry" / "a.pbrt").write_text('Include "geometry/b.pbrt"\nInclude "c.pbrt"\n')
    (tmp_path / "geometry" / "b.pbrt").write_text("Translate 0 0 1 # comment [\n" + TRIANGLE)
    (tmp_path / "geometry" / "c.pbrt").write_text(TRIANGLE)  # only beside the file that asks
    scene = load(tmp_path, f'Include "geometry/a.pbrt" {TRIANGLE}')
    assert scene.triangle_count == 3
    np.testing.assert_allclose(scene.bounds(), [(0, 0, 1), (1, 1, 1)])


@pytest.mark.parametrize(
    ("world", "name"),
    [
        ('LightSource "projection" "string mapname" "a.png"', "projection"),
        ('LightSource "goniometric"', "goniometric"),
        (f'Material "fourier" {TRIANGLE}', "fourier"),
        ('Shape "hyperboloid"', "hyperboloid"),
        ('MediumInterface "m" ""', "media"),
        (f'Material "uber" {TRIANGLE}', "uber"),
    ],
)
def test_what_is_not_modelled_is_named_and_an_error_when_strict(tmp_path, world, name):
    scene = load(tmp_path, world, strict=False)
    assert scene.warnings[0][0].endswith("scene.pbrt:3") and name in scene.warnings[0][1]
    with pytest.raises(core.SceneError, match=f"scene.pbrt:3: .*{name}"):
        load(tmp_path, world)
