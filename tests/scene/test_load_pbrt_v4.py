# ruff: noqa: E501  (scene texts stay on their lines)
"""pbrt-v4 text scenes: their words beside those of v3, and equal scenes in both."""

import numpy as np
import pytest

import viscache as vc
from viscache import _core as core

K, C = core.MaterialKind, core.CoatKind
TRIANGLE = 'Shape "trianglemesh" "point3 P" [0 0 0  1 0 0  0 1 0]\n'
VIEW = "LookAt 0 3 6  0 0.5 0  0 1 0\n"

V3 = f"""{VIEW}Camera "perspective" "float fov" [50]
Film "image" "integer xresolution" [64] "integer yresolution" [48]
WorldBegin
Texture "board" "spectrum" "checkerboard" "rgb tex1" [.8 .4 .2] "rgb tex2" [.1 .2 .3] "float uscale" [4] "float vscale" [4]
MakeNamedMaterial "floor" "string type" ["matte"] "texture Kd" ["board"]
AttributeBegin
NamedMaterial "floor"
Shape "trianglemesh" "integer indices" [0 1 3 0 3 2] "point P" [-5 0 5 5 0 5 -5 0 -5 5 0 -5] "float uv" [0 0 1 0 0 1 1 1]
AttributeEnd
AttributeBegin
Translate 0 2 0 Rotate 90 1 0 0
AreaLightSource "diffuse" "rgb L" [5 4 3]
Shape "disk" "float radius" [.6]
AttributeEnd
AttributeBegin
Translate 0 .6 0
Material "metal" "rgb eta" [1.5 1.2 1] "rgb k" [2 3 4] "float roughness" [.3] "bool remaproughness" ["false"]
Shape "sphere" "float radius" [.6]
AttributeEnd
LightSource "point" "point from" [2 3 1] "rgb I" [1 2 3] "rgb scale" [2 2 2]
LightSource "distant" "point from" [0 5 0] "point to" [1 0 0] "rgb L" [.5 .5 .5]
WorldEnd
"""
V4 = f"""Option "bool disablepixeljitter" true
ColorSpace "srgb"
{VIEW}Camera "perspective" "float fov" 50
Film "rgb" "integer xresolution" 64 "integer yresolution" 48 "string filename" "out.exr"
Sampler "zsobol" "integer pixelsamples" 16
Integrator "volpath" "integer maxdepth" 5
WorldBegin
Texture "board" "spectrum" "checkerboard" "rgb tex1" [.8 .4 .2] "rgb tex2" [.1 .2 .3] "float uscale" 4 "float vscale" 4
MakeNamedMaterial "floor" "string type" "diffuse" "texture reflectance" "board"
AttributeBegin
NamedMaterial "floor"
Shape "bilinearmesh" "point3 P" [-5 0 5 5 0 5 -5 0 -5 5 0 -5]
AttributeEnd
AttributeBegin
Translate 0 2 0 Rotate 90 1 0 0
AreaLightSource "diffuse" "rgb L" [1 .8 .6] "float scale" 5
Attribute "shape" "float radius" .6
Shape "disk"
AttributeEnd
Import "ball.pbrt"
LightSource "point" "point3 from" [2 3 1] "rgb I" [1 2 3] "float scale" 2
LightSource "distant" "point3 from" [0 5 0] "point3 to" [1 0 0] "float illuminance" .5
"""
BALL = """AttributeBegin
Translate 0 .6 0
Material "conductor" "rgb eta" [1.5 1.2 1] "rgb k" [2 3 4] "float roughness" .3 "bool remaproughness" false
Shape "sphere" "float radius" .6
AttributeEnd
"""


def load(folder, world, head="", strict=True):
    path = folder / "scene.pbrt"
    path.write_text(f'{head}\nFilm "rgb"\nWorldBegin\n{world}\n')
    return core.load_scene_file(str(path), strict)


def surface(folder, material, strict=True):
    scene = load(folder, f"Material {material}\n{TRIANGLE}", strict=strict)
    return dict(scene.materials[scene.meshes[0]["material"]])


def test_a_scene_of_both_versions_is_the_same(tmp_path):
    three, four = tmp_path / "three.pbrt", tmp_path / "four.pbrt"
    three.write_text(V3)
    four.write_text(V4)
    (tmp_path / "ball.pbrt").write_text(BALL)
    a, b = vc.load_scene(three, strict=True), vc.load_scene(four, strict=True)
    assert [m["emission"] for m in core.load_scene_file(str(four)).meshes][1] == [5, 4, 3]
    assert a.content_hash == b.content_hash
    four.write_text(V4.replace('"float scale" 5', '"float scale" 5.1'))
    assert vc.load_scene(four).content_hash != a.content_hash, "the hash sees no lamp"


def test_materials_have_their_nearest_kinds(tmp_path):
    copper = surface(
        tmp_path,
        '"conductor" "spectrum eta" "metal-Cu-eta" "spectrum k" "metal-Cu-k" "float roughness" .25',
    )
    assert copper["kind"] == K.GLOSSY and copper["roughness"] == pytest.approx(0.5)
    assert copper["metal_k"][0] > 3.9 > copper["metal_k"][2]
    glass = surface(tmp_path, '"dielectric" "spectrum eta" "glass-BK7"')
    assert glass["kind"] == K.DIELECTRIC and glass["eta"] == pytest.approx(1.5168)
    assert surface(tmp_path, '"dielectric" "float eta" 1.33')["eta"] == pytest.approx(1.33)
    coat = surface(tmp_path, '"coateddiffuse" "rgb reflectance" [.1 .2 .3] "float roughness" .04')
    assert coat["kind"] == K.GLOSSY and coat["roughness"] == pytest.approx(0.2)
    assert coat["coat"] == C.ROUGH and coat["nonlinear"] and coat["eta"] == pytest.approx(1.5)
    assert coat["base_color"] == pytest.approx([0.1, 0.2, 0.3])
    smooth = surface(tmp_path, '"coateddiffuse"')
    assert smooth["coat"] == C.SMOOTH and smooth["beckmann"] and not coat["beckmann"]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ('Material "coatedconductor" ' + TRIANGLE, "coat of 'coatedconductor'"),
        ('Material "interface" ' + TRIANGLE, "without a surface"),
        ('LightSource "infinite" "string filename" "sky.exr"', "equal-area squares"),
        ('Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 1]', "curved patches"),
        ('MakeNamedMedium "fog" "string type" "homogeneous"', "media are not modelled"),
        ('ColorSpace "rec2020"', "colour space 'rec2020'"),
        (
            'LightSource "point" "spectrum I" "illum-acesD60"',
            "spectrum 'illum-acesD60' is not known",
        ),
        ('Texture "t" "spectrum" "marble"', "texture 'marble' is not modelled"),
    ],
)
def test_what_is_not_modelled_is_warned_of_with_its_line(tmp_path, words, text):
    warnings = load(tmp_path, words, strict=False).warnings
    assert any(where.endswith("scene.pbrt:4") and text in what for where, what in warnings), (
        warnings
    )


def test_the_power_of_lights_is_spread_over_their_area(tmp_path):
    def emission(shape, light=""):
        lamp = f'AreaLightSource "diffuse" "float power" 10 {light}'
        scene = load(tmp_path, f"{lamp} Shape {shape}")
        return float(
            (scene.meshes[0]["emission"] if scene.meshes else scene.lights[0]["radiance"])[1]
        )

    assert emission('"disk" "float radius" 2') == pytest.approx(10 / (np.pi * 4 * np.pi), rel=1e-5)
    both = emission('"disk" "float radius" 2', '"bool twosided" true')
    assert both == pytest.approx(5 / (np.pi * 4 * np.pi), rel=1e-5)
    assert emission('"sphere" "float radius" 2') == pytest.approx(10 / (16 * np.pi * np.pi))
    # Every triangle of a mesh is a light of its own
    assert emission(TRIANGLE[6:]) == pytest.approx(10 / (0.5 * np.pi))


def test_triangles_of_one_power_each_are_warned_of_if_they_differ(tmp_path):
    lamp = 'AreaLightSource "diffuse" "float power" 10 Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]'
    assert not load(tmp_path, f'{lamp} "point3 P" [0 0 0 1 0 0 1 1 0 0 1 0]').warnings
    with pytest.raises(core.SceneError, match=r"scene.pbrt:4: a light of one power per triangle"):
        load(tmp_path, f'{lamp} "point3 P" [0 0 0 1 0 0 1 1 0 0 3 0]')


def test_the_world_ends_with_its_file(tmp_path):
    assert load(tmp_path, TRIANGLE).triangle_count == 1
    with pytest.raises(
        core.SceneError, match=r"scene.pbrt:4: this block does not end before the file"
    ):
        load(tmp_path, f"AttributeBegin {TRIANGLE}")
    (tmp_path / "three.pbrt").write_text(f'Film "image"\nWorldBegin\n{TRIANGLE}')
    with pytest.raises(core.SceneError, match="the file ends before WorldEnd"):
        core.load_scene_file(str(tmp_path / "three.pbrt"))


def test_attributes_hold_in_their_block_and_yield_to_parameters(tmp_path):
    scene = load(
        tmp_path,
        """AttributeBegin Attribute "shape" "float radius" 2 "float height" 1
        Shape "disk" Shape "disk" "float radius" 3 AttributeEnd Shape "disk" """,
    )
    widths = [np.ptp(scene.mesh_arrays(i)["vertices"][:, 0]) for i in range(3)]
    assert widths == pytest.approx([4, 6, 2], rel=1e-2)
    assert [scene.mesh_arrays(i)["vertices"][0, 2] for i in range(3)] == [1, 1, 0]


def test_textures_of_version_4_are_read(tmp_path):
    from PIL import Image

    Image.fromarray(np.full((1, 1, 3), 128, np.uint8)).save(tmp_path / "map.png")
    scene = load(
        tmp_path,
        f"""Texture "m" "spectrum" "imagemap" "string filename" "map.png" "string encoding" "linear" "string filter" "point"
        Texture "s" "spectrum" "scale" "texture tex" "m" "float scale" .5
        Material "diffuse" "texture reflectance" "s" {TRIANGLE}""",
    )
    [image] = scene.images
    assert image["nearest"] and not image["srgb"]
    material = scene.materials[scene.meshes[0]["material"]]
    assert material["base_color"] == pytest.approx([0.5] * 3) and material["base_texture"] == 0
