# ruff: noqa: E501  (scene texts stay on their lines)
"""pbrt files: a parameter that no reader takes is warned of, with its line, directive and name."""

import pytest

from viscache import _core as core

TRIANGLE = 'Shape "trianglemesh" "point3 P" [0 0 0  1 0 0  0 1 0] "integer indices" [0 1 2]'
MORE = '\n"float invented" 1\n'  # on line 5
#: (version, text of lines 3 and 4, what the warning calls the directive)
DIRECTIVES = [
    *(
        (version, f'Shape "{shape}"', f"Shape '{shape}'")
        for version in (3, 4)
        for shape in ("sphere", "disk", "cylinder", "cone", "paraboloid")
    ),
    (3, TRIANGLE, "Shape 'trianglemesh'"),
    (4, TRIANGLE, "Shape 'trianglemesh'"),
    (3, f'{TRIANGLE} "float alpha" 0 AreaLightSource "diffuse"', "AreaLightSource 'diffuse'"),
    (3, TRIANGLE.replace("trianglemesh", "loopsubdiv"), "Shape 'loopsubdiv'"),
    (4, 'Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0]', "Shape 'bilinearmesh'"),
    (4, 'AreaLightSource "diffuse" Shape "sphere"', "Shape 'sphere'"),
    *(
        (3, f'Material "{kind}"', f"Material '{kind}'")
        for kind in ("matte", "plastic", "metal", "mirror", "glass", "uber", "substrate", "disney", "translucent")
    ),
    *(
        (4, f'Material "{kind}"', f"Material '{kind}'")
        for kind in ("diffuse", "conductor", "dielectric", "thindielectric", "coateddiffuse", "coatedconductor", "diffusetransmission", "interface")
    ),
    (3, 'MakeNamedMaterial "m" "string type" "matte"', "MakeNamedMaterial"),
    (3, 'MakeNamedMaterial "m" "string type" "matte" Material "mix" "string namedmaterial1" "m"', "Material 'mix'"),
    (3, 'MakeNamedMaterial "m" "string type" "matte" NamedMaterial "m"', "NamedMaterial"),
    (3, 'Texture "t" "spectrum" "constant"', "Texture 'constant'"),
    (3, 'Texture "t" "float" "checkerboard"', "Texture 'checkerboard'"),
    (4, 'Texture "t" "spectrum" "scale"', "Texture 'scale'"),
    (4, 'Texture "t" "spectrum" "imagemap" "string filename" "no.png"', "Texture 'imagemap'"),
    *(
        (version, f'LightSource "{light}"', f"LightSource '{light}'")
        for version in (3, 4)
        for light in ("point", "spot", "distant", "infinite")
    ),
    (4, 'Camera "perspective"', "Camera 'perspective'"),
    (3, 'Camera "orthographic"', "Camera 'orthographic'"),
    (4, 'Film "gbuffer"', "Film 'gbuffer'"),
    (3, 'Film "image"', "Film 'image'"),
    (4, 'Option "string seed" "3"', "Option"),
    (4, 'Attribute "shape" "float radius" 2 Shape "disk" Attribute "shape"', "Attribute"),
]  # fmt: skip


def load(folder, version, text, strict=False):
    film, end = ("rgb", "") if version == 4 else ("image", "WorldEnd")
    (folder / "scene.pbrt").write_text(f'Film "{film}"\nWorldBegin\n\n{text}\n{end}\n')
    return core.load_scene_file(str(folder / "scene.pbrt"), strict).warnings


@pytest.mark.parametrize(("version", "text", "of"), DIRECTIVES)
def test_an_unknown_parameter_of_any_directive_is_warned_of(tmp_path, version, text, of):
    found = [(w, t) for w, t in load(tmp_path, version, text + MORE) if "invented" in t]
    assert found == [(str(tmp_path / "scene.pbrt:5"), f"the parameter 'invented' of {of} is not read")]  # fmt: skip
    # The directive alone leaves nothing
    assert not [t for _, t in load(tmp_path, version, text) if "is not read" in t]
    if not load(tmp_path, version, text):
        with pytest.raises(core.SceneError, match=r"scene.pbrt:5: the parameter 'invented'"):
            load(tmp_path, version, text + MORE, strict=True)


@pytest.mark.parametrize(
    ("version", "text", "name"),
    [
        # Known by name, but not as what it is given
        (3, 'Texture "t" "float" "constant" Material "glass" "texture index" "t"', "index"),
        (3, 'Material "matte" "float sigma" 20', "sigma"),
        (3, 'Material "glass" "rgb Kt" [1 .5 1]', "Kt"),
        (3, f'{TRIANGLE} "float shadowalpha" 0', "shadowalpha"),
        (3, 'Shape "sphere" "float alpha" 0', "alpha"),
        (3, 'Film "image" "float scale" 2', "scale"),
        (4, 'Film "rgb" "float iso" 200', "iso"),
        (4, 'Option "bool forcediffuse" true', "forcediffuse"),
        # A second value of a name counts for nothing
        (4, 'Shape "disk" "float radius" 1 "float radius" 2', "radius"),
        # Of a default that no shape takes
        (4, 'Attribute "shape" "float radius" 2 Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0]', "radius"),
    ],
)  # fmt: skip
def test_what_is_known_but_left_out_is_warned_of(tmp_path, version, text, name):
    [(where, what)] = load(tmp_path, version, text)
    assert where.endswith("scene.pbrt:4") and f"the parameter '{name}' of " in what
    with pytest.raises(core.SceneError, match=f"scene.pbrt:4: the parameter '{name}' of "):
        load(tmp_path, version, text, strict=True)


@pytest.mark.parametrize(
    ("version", "text"),
    [
        (3, 'Film "image" "string filename" "a.exr" "float diagonal" 35 "float scale" 1'),
        (4, 'Film "rgb" "bool savefp16" true "float iso" 100 "float maxcomponentvalue" 10'),
        (3, 'Camera "perspective" "float shutterclose" .5 "float focaldistance" 3'),
        (3, 'Material "glass" "rgb Kr" [1 1 1] "rgb Kt" [1 1 1] "bool remaproughness" "false"'),
        (3, 'Material "matte" "float sigma" 0'),
        (3, 'LightSource "infinite" "integer nsamples" 16'),
        (3, 'Integrator "volpath" "float lightsampler" 1 PixelFilter "gaussian" "float xwidth" 9'),
        (3, 'Sampler "halton" "integer pixelsamples" 9 Accelerator "bvh" "integer maxnodeprims" 4'),
        (3, f'{TRIANGLE} "vector S" [1 0 0 1 0 0 1 0 0]'),
        (4, 'Material "coateddiffuse" "float thickness" .1 "integer maxdepth" 9 "rgb albedo" [0 0 0]'),
        (3, 'MediumInterface "" "" MediumInterface ""'),
        # One of the shapes takes the default, or has a value of its own
        (4, f'Attribute "shape" "float radius" 2 {TRIANGLE} Shape "disk"'),
        (4, 'Attribute "shape" "float radius" 2 Shape "disk" "float radius" 3'),
    ],
)  # fmt: skip
def test_what_leaves_the_picture_alone_is_not_spoken_of(tmp_path, version, text):
    assert not load(tmp_path, version, text, strict=True)


def test_media_make_the_picture_wrong_where_something_stands_in_them(tmp_path):
    medium = 'MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [1 1 1]'
    [(where, text)] = load(tmp_path, 4, medium, strict=True)
    assert where.endswith("scene.pbrt:4") and "media are not modelled" in text
    texts = [t for _, t in load(tmp_path, 4, f'{medium} MediumInterface "fog" ""')]
    assert texts[1:] == ["media are not modelled; the space is empty"]
    with pytest.raises(core.SceneError, match="the space is empty"):
        load(tmp_path, 4, f'{medium} MediumInterface "" "fog"', strict=True)
    # A surface that bounds media alone is rightly left out; in pbrt-v3 it may shine
    assert not load(tmp_path, 3, 'AreaLightSource "diffuse"', strict=True)
    bounds = f'Material "" {TRIANGLE}'
    assert "without a surface" in load(tmp_path, 3, bounds, strict=True)[0][1]
    with pytest.raises(core.SceneError, match="light without a surface"):
        load(tmp_path, 3, f'AreaLightSource "diffuse" {bounds}', strict=True)


@pytest.mark.parametrize(
    ("version", "text", "why"),
    [
        (3, 'LightSource "point" "point from" [0 0 0 1 1 1]', "'from' must be three numbers"),
        (4, " ".join(f'Attribute "shape" "float a{i}" 1' for i in range(1001)), "more than 1,000"),
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path, version, text, why):
    with pytest.raises(core.SceneError, match=f"scene.pbrt:4: {why}"):
        load(tmp_path, version, text)


def test_the_exposure_of_version_4_is_warned_of(tmp_path):
    shutter = 'Camera "perspective" "float shutteropen" 0 "float shutterclose"'
    assert not load(tmp_path, 4, f"{shutter} 1", strict=True)
    assert "exposure" in load(tmp_path, 4, f"{shutter} .5")[0][1]
