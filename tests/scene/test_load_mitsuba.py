# ruff: noqa: E501  (scene texts stay on their lines)
"""Mitsuba XML scenes: both dialects, values, materials, shapes, lights, cameras."""

import struct
import zlib

import numpy as np
import pytest

from viscache import _core as core

K = core.MaterialKind


def load(folder, body, strict=True, version="3.0.0"):
    path = folder / "scene.xml"
    path.write_text(f'<scene version="{version}">\n{body}\n</scene>')
    return core.load_scene_file(str(path), strict)


def material(folder, bsdf, strict=True, version="3.0.0"):
    scene = load(folder, f'<shape type="rectangle">{bsdf}</shape>', strict, version)
    return scene.materials[scene.meshes[0]["material"]]


def test_a_rectangle_and_a_cube_have_the_sizes_and_sides_of_mitsuba(tmp_path):
    scene = load(tmp_path, '<shape type="rectangle"/><shape type="cube"/>')
    assert [m["n_triangles"] for m in scene.meshes] == [2, 12]
    rectangle, cube = scene.mesh_arrays(0), scene.mesh_arrays(1)
    p = rectangle["vertices"][rectangle["triangles"]]
    np.testing.assert_array_equal(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), [[0, 0, 4]] * 2)
    p = cube["vertices"][cube["triangles"]].astype(float)
    n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    assert (np.einsum("ij,ij->i", n, p.mean(1)) > 0).all()  # outwards
    assert np.einsum("ij,ij->i", p[:, 0], n).sum() / 6 == pytest.approx(8)  # the volume


def test_transforms_apply_in_the_order_of_the_file(tmp_path):
    scene = load(
        tmp_path,
        """<shape type="rectangle"><transform name="to_world">
        <scale value="2"/><rotate y="1" angle="90"/><translate x="1" y="2" z="3"/>
        </transform></shape>""",
    )
    np.testing.assert_allclose(scene.bounds(), [(1, 0, 1), (1, 4, 5)], atol=1e-6)
    p = scene.mesh_arrays(0)
    a, b, c = p["vertices"][p["triangles"][0]]
    assert np.cross(b - a, c - a)[0] > 0  # +z turned to +x


def test_parameters_have_defaults_and_an_unknown_one_is_refused(tmp_path):
    body = '<default name="r" value="0.25"/><shape type="sphere"><float name="radius" value="{}"/></shape>'
    scene = load(tmp_path, body.format("$r"))
    np.testing.assert_allclose(scene.bounds(), [[-0.25] * 3, [0.25] * 3], rtol=2e-3)
    with pytest.raises(core.SceneError, match=r"scene.xml:2: the parameter '\$q' has no default"):
        load(tmp_path, body.format("$q"))


def test_the_camera_of_both_dialects_looks_along_z_with_x_to_the_left(tmp_path):
    old = load(
        tmp_path,
        """<sensor type="perspective"><float name="fov" value="40"/>
        <string name="fovAxis" value="smaller"/><transform name="toWorld">
        <lookAt origin="1,2,3" target="1,2,-7" up="0,1,0"/></transform>
        <film type="hdrfilm"><integer name="width" value="200"/><integer name="height" value="100"/>
        </film></sensor>""",
        version="0.6.0",
    ).cameras[0]
    new = load(
        tmp_path,
        """<sensor type="perspective"><float name="fov" value="40"/>
        <transform name="to_world"><matrix value="-1 0 0 1  0 1 0 2  0 0 -1 3  0 0 0 1"/></transform>
        </sensor>""",
    ).cameras[0]
    for camera in (old, new):
        np.testing.assert_allclose(camera["origin"], [1, 2, 3])
        np.testing.assert_allclose(camera["right"], [1, 0, 0], atol=1e-6)
        np.testing.assert_allclose(camera["up"], [0, 1, 0], atol=1e-6)
        np.testing.assert_allclose(camera["forward"], [0, 0, -1], atol=1e-6)
    assert (
        not old["horizontal"] and new["horizontal"] and (old["width"], old["height"]) == (200, 100)
    )
    assert (new["width"], new["height"]) == (768, 576)


@pytest.mark.parametrize(
    ("axis", "horizontal", "degrees"),
    [
        ("x", True, 50),
        ("y", False, 50),
        ("smaller", False, 50),
        ("larger", True, 50),
        ("diagonal", True, 2 * np.degrees(np.arctan(np.tan(np.radians(25)) * 0.8))),
    ],
)
def test_the_field_of_view_belongs_to_the_named_axis(tmp_path, axis, horizontal, degrees):
    camera = load(
        tmp_path,
        f"""<sensor type="perspective"><float name="fov" value="50"/>
        <string name="fov_axis" value="{axis}"/><film type="hdrfilm">
        <integer name="width" value="400"/><integer name="height" value="300"/></film></sensor>""",
    )
    assert camera.cameras[0]["horizontal"] == horizontal
    assert camera.cameras[0]["fov_deg"] == pytest.approx(degrees, abs=1e-4)


def test_diffuse_is_one_sided_unless_inside_twosided(tmp_path):
    one = material(
        tmp_path, '<bsdf type="diffuse"><rgb name="reflectance" value="0.1 0.2 0.3"/></bsdf>'
    )
    two = material(tmp_path, '<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>')
    assert one["kind"] == K.DIFFUSE and not one["two_sided"] and two["two_sided"]
    assert one["base_color"] == pytest.approx([0.1, 0.2, 0.3])
    assert two["base_color"] == pytest.approx([0.5] * 3)


def test_a_conductor_has_its_index_relative_to_the_outside(tmp_path):
    m = material(
        tmp_path,
        """<bsdf type="conductor"><rgb name="eta" value="1.5 0.2 0"/>
        <rgb name="k" value="2 3 0"/><rgb name="specularReflectance" value="1 0.5 1"/>
        <float name="extEta" value="1.25"/></bsdf>""",
    )
    assert m["kind"] == K.MIRROR and m["specular"] == [1, 0.5, 1]
    assert m["metal_eta"] == pytest.approx([1.2, 0.16, 0])
    # Without an index, blue is that of a perfect mirror
    assert m["metal_k"] == pytest.approx([1.6, 2.4, 1])
    none = material(
        tmp_path, '<bsdf type="conductor"><string name="material" value="none"/></bsdf>'
    )
    assert none["specular"] == [1, 1, 1] and none["metal_eta"] == none["metal_k"] == [0, 0, 0]
    gold = material(
        tmp_path,
        '<bsdf type="roughconductor"><string name="material" value="Au"/>'
        '<string name="distribution" value="ggx"/><float name="alpha" value="0.3"/></bsdf>',
    )
    assert gold["kind"] == K.GLOSSY and gold["roughness"] == pytest.approx(0.3)
    assert gold["base_color"] == [0, 0, 0] and gold["metal_k"][0] == pytest.approx(3.983)
    assert not gold["beckmann"]
    plain = material(tmp_path, '<bsdf type="roughconductor"/>')
    assert plain["beckmann"] and plain["metal_k"] == [0, 0, 0]


def test_plastic_phong_and_glass_have_their_nearest_materials(tmp_path):
    m = material(
        tmp_path,
        """<bsdf type="roughplastic"><float name="alpha" value="0.2"/>
        <float name="intIOR" value="1.5"/><float name="extIOR" value="1"/>
        <string name="distribution" value="ggx"/><boolean name="nonlinear" value="true"/>
        <rgb name="diffuseReflectance" value="0.4 0.4 0.4"/></bsdf>""",
        version="0.6.0",
    )
    assert m["kind"] == K.GLOSSY and m["coat"] == core.CoatKind.ROUGH and m["nonlinear"]
    assert m["specular"] == [1, 1, 1] and m["eta"] == 1.5
    assert m["base_color"] == pytest.approx([0.4] * 3) and m["roughness"] == pytest.approx(0.2)
    m = material(tmp_path, '<bsdf type="plastic"/>')
    assert m["coat"] == core.CoatKind.SMOOTH and not m["nonlinear"]
    assert m["beckmann"] and m["roughness"] == pytest.approx(0.004)
    assert m["eta"] == pytest.approx(1.49 / 1.000277)
    m = material(tmp_path, '<bsdf type="roughplastic"/>', strict=False)
    assert m["coat"] == core.CoatKind.BECKMANN
    m = material(tmp_path, '<bsdf type="thindielectric"/>')
    assert m["kind"] == K.DIELECTRIC and m["thin"] and m["eta"] == pytest.approx(1.5046 / 1.000277)
    m = material(
        tmp_path, '<bsdf type="phong"><float name="exponent" value="48"/></bsdf>', version="0.6.0"
    )
    assert m["roughness"] == pytest.approx(0.2)
    m = material(tmp_path, '<bsdf type="dielectric"><string name="int_ior" value="water"/></bsdf>')
    assert m["kind"] == K.DIELECTRIC and m["eta"] == pytest.approx(1.333 / 1.000277)


def test_colours_come_as_hex_srgb(tmp_path):
    orange = '<bsdf type="diffuse"><rgb name="reflectance" value="#ff8000"/></bsdf>'
    linear = ((0x80 / 255 + 0.055) / 1.055) ** 2.4
    assert material(tmp_path, orange)["base_color"] == pytest.approx([1, linear, 0])


def test_a_lamp_without_a_bsdf_is_black_and_another_shape_grey(tmp_path):
    lamp = '<shape type="rectangle"><emitter type="area"/></shape>'
    scene = load(tmp_path, lamp + '<shape type="cube"/>' + lamp)
    colors = [scene.materials[m["material"]]["base_color"] for m in scene.meshes]
    assert colors == [[0, 0, 0], [0.5] * 3, [0, 0, 0]] and len(scene.materials) == 2


def test_references_to_bsdfs_and_textures_are_followed_also_nested(tmp_path):
    scene = load(
        tmp_path,
        """<bsdf type="diffuse" id="inner"><rgb name="reflectance" value="0.2"/></bsdf>
        <bsdf type="twosided" id="outer"><ref id="inner"/></bsdf>
        <shape type="rectangle"><ref name="bsdf" id="outer"/></shape>
        <shape type="cube"><ref id="outer"/></shape>""",
    )
    first, second = (m["material"] for m in scene.meshes)
    assert first == second and scene.materials[first]["two_sided"]
    assert scene.materials[first]["base_color"] == pytest.approx([0.2] * 3)
    with pytest.raises(core.SceneError, match="refer to themselves"):
        load(
            tmp_path,
            '<bsdf type="twosided" id="a"><ref id="a"/></bsdf><shape type="cube"><ref id="a"/></shape>',
        )
    with pytest.raises(core.SceneError, match="nothing has the id 'b'"):
        load(tmp_path, '<shape type="cube"><ref id="b"/></shape>')


def test_an_emitting_sphere_is_a_light_and_another_one_a_mesh(tmp_path):
    glow = '<emitter type="area"><rgb name="radiance" value="1 2 3"/></emitter>'
    scene = load(
        tmp_path,
        f"""<shape type="sphere"><point name="center" x="1" y="0" z="0"/>
        <float name="radius" value="0.5"/><transform name="to_world"><scale value="2"/></transform>{glow}
        </shape><shape type="sphere"/>""",
    )
    light = scene.lights[0]
    assert light["kind"] == "sphere" and light["radius"] == 1 and light["center"] == [2, 0, 0]
    assert light["radiance"] == [1, 2, 3]
    assert len(scene.meshes) == 1 and scene.triangle_count == scene.meshes[0]["n_triangles"] > 500
    mesh = scene.mesh_arrays(0)
    np.testing.assert_allclose(np.linalg.norm(mesh["vertices"], axis=1), 1.0010, atol=1e-5)
    p = mesh["vertices"][mesh["triangles"]]
    n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    assert (np.einsum("ij,ij->i", n, p.mean(1)) > 0).all()


def test_lights_have_our_units_and_directions(tmp_path):
    scene = load(
        tmp_path,
        """
        <emitter type="point"><point name="position" x="1" y="2" z="3"/><rgb name="intensity" value="4 5 6"/></emitter>
        <emitter type="directional"><vector name="direction" x="0" y="-2" z="0"/><rgb name="irradiance" value="3"/></emitter>
        <emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>""",
    )
    point, directional, constant = scene.lights
    assert point["position"] == [1, 2, 3] and point["intensity"] == [4, 5, 6]
    assert directional["direction"] == [0, 1, 0]  # towards the light
    assert constant["kind"] == "constant" and constant["scale"] == [0.5] * 3


def test_spot_lights_have_the_angles_of_mitsuba(tmp_path):
    place = '<transform name="to_world"><scale value="3"/><rotate y="1" angle="90"/><translate x="1" y="2" z="3"/></transform>'
    angles = '<float name="cutoffAngle" value="40"/><float name="beamWidth" value="10"/>'
    body = '<emitter type="spot">{}<rgb name="intensity" value="4 5 6"/></emitter>'
    scene = load(tmp_path, body.format(place + angles) + body.format(""))
    spot, default = scene.lights
    assert spot["kind"] == "spot" and spot["falloff"] == "angle"
    assert spot["intensity"] == [4, 5, 6]
    np.testing.assert_allclose(spot["position"], (1, 2, 3), atol=1e-6)
    np.testing.assert_allclose(spot["axis"], (1, 0, 0), atol=1e-6)
    np.testing.assert_allclose(spot["cone_deg"], (10, 40), rtol=1e-4)
    np.testing.assert_allclose(default["cone_deg"], (15, 20), rtol=1e-4)
    with pytest.raises(
        core.SceneError, match=r"scene.xml:2: the cutoff angle must be in \(0, 180\]"
    ):
        load(tmp_path, '<emitter type="spot"><float name="cutoff_angle" value="0"/></emitter>')
    with pytest.raises(core.SceneError, match="the beam width must be in"):
        load(tmp_path, '<emitter type="spot"><float name="beam_width" value="30"/></emitter>')


def test_flipped_normals_turn_the_side_of_a_light(tmp_path):
    scene = load(
        tmp_path,
        '<shape type="rectangle"><boolean name="flipNormals" value="true"/></shape>',
        version="0.6.0",
    )
    mesh = scene.mesh_arrays(0)
    a, b, c = mesh["vertices"][mesh["triangles"][0]]
    assert np.cross(b - a, c - a)[2] < 0


def test_instances_of_a_shapegroup_count_once_for_each_placement(tmp_path):
    scene = load(
        tmp_path,
        """<shape type="shapegroup" id="g"><shape type="cube"/><shape type="rectangle"/></shape>
        <shape type="instance"><ref id="g"/></shape>
        <shape type="instance"><ref id="g"/><transform name="to_world"><translate x="10"/></transform></shape>""",
    )
    assert scene.triangle_count == 28 and len(scene.meshes) == 2 and len(scene.instances) == 2
    np.testing.assert_allclose(scene.bounds(), [(-1, -1, -1), (11, 1, 1)])


def test_files_are_sought_in_paths_then_beside_the_main_file_then_beside_the_included_one(tmp_path):
    triangle = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nf 1 2 3\n"
    places = {"meshes": 4, "more": 3, "": 2, "sub": 1}
    for folder, size in places.items():
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / "a.obj").write_text(triangle.format(size))
    shape = '<shape type="obj"><string name="filename" value="a.obj"/></shape>'
    (tmp_path / "sub" / "part.xml").write_text(f"<scene>{shape}</scene>")
    body = '<path value="more"/><path value="meshes"/><include filename="sub/part.xml"/>'
    for folder, size in places.items():
        assert load(tmp_path, body).bounds()[1][0] == size
        (tmp_path / folder / "a.obj").unlink()
    with pytest.raises(core.SceneError, match=r"a.obj: the file does not exist"):
        load(tmp_path, body)
    with pytest.raises(core.SceneError, match=r"scene.xml:2: the folder '.*nowhere' is not there"):
        load(tmp_path, '<path value="nowhere"/>')


def test_includes_that_multiply_are_refused(tmp_path):
    for level in range(12):
        includes = f'<include filename="{level + 1}.xml"/>' * 10
        (tmp_path / f"{level}.xml").write_text(f"<scene>{includes}</scene>")
    (tmp_path / "12.xml").write_text("<scene/>")
    with pytest.raises(core.SceneError, match=r"the scene includes more than 10,000 files"):
        load(tmp_path, '<include filename="0.xml"/>')


def test_includes_are_merged_and_a_cycle_is_refused(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "part.xml").write_text(
        '<scene version="3.0.0"><shape type="cube"/></scene>'
    )
    assert load(tmp_path, '<include filename="sub/part.xml"/>').triangle_count == 12
    with pytest.raises(core.SceneError, match=r"scene.xml:2: the include of .* is cyclic"):
        load(tmp_path, '<include filename="scene.xml"/>')


def serialized(vertices, triangles, flags=0x1000, dtype="<f4", version=4):
    body = struct.pack("<I", flags) + (b"name\0" if version == 4 else b"")
    body += struct.pack("<QQ", len(vertices), len(triangles))
    body += np.asarray(vertices, dtype).tobytes() + np.asarray(triangles, "<u4").tobytes()
    return struct.pack("<HH", 0x041C, version) + zlib.compress(body)


@pytest.mark.parametrize(("version", "offset"), [(3, "<I"), (4, "<Q")])
@pytest.mark.parametrize("double", [False, True])
def test_serialized_shapes_are_found_by_their_index(tmp_path, version, offset, double):
    dtype, flags = ("<f8", 0x2000) if double else ("<f4", 0x1000)
    a = serialized([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], flags, dtype, version)
    b = serialized(
        [(0, 0, 5), (1, 0, 5), (0, 1, 5), (1, 1, 5)], [(0, 1, 2), (2, 1, 3)], flags, dtype, version
    )
    data = a + b + struct.pack(offset, 0) + struct.pack(offset, len(a)) + struct.pack("<I", 2)
    (tmp_path / "m.serialized").write_bytes(data)
    body = '<shape type="serialized"><string name="filename" value="m.serialized"/><integer name="shapeIndex" value="{}"/></shape>'
    scene = load(tmp_path, body.format(1), version="0.6.0")
    assert scene.triangle_count == 2
    np.testing.assert_array_equal(scene.bounds(), [(0, 0, 5), (1, 1, 5)])
    with pytest.raises(core.SceneError, match="shape index 2, the file has 2"):
        load(tmp_path, body.format(2), version="0.6.0")


def test_colours_of_a_serialized_file_are_named(tmp_path):
    body = struct.pack("<I5sQQ", 0x1008, b"name", 3, 1)
    body += np.eye(3, dtype="<f4").tobytes() * 2 + np.arange(3, dtype="<u4").tobytes()
    data = struct.pack("<HH", 0x041C, 4) + zlib.compress(body) + struct.pack("<QI", 0, 1)
    (tmp_path / "m.serialized").write_bytes(data)
    ((_, text),) = core.load_scene_file(str(tmp_path / "m.serialized")).warnings
    assert text == "colours of vertices are not read from this format"


@pytest.mark.parametrize(
    ("body", "name"),
    [
        ('<emitter type="timed_sunsky"/>', "timed_sunsky"),
        ('<emitter type="projector"/>', "projector"),
        (
            '<emitter type="spot"><texture type="bitmap" name="texture"/></emitter>',
            "texture of a spot light",
        ),
        ('<shape type="heightfield"/>', "heightfield"),
        ('<shape type="cube"><bsdf type="hair"/></shape>', "hair"),
        (
            '<shape type="cube"><ref name="interior" id="m"/></shape><medium id="m" type="homogeneous"/>',
            "media",
        ),
        ('<emitter type="sunsky"><float name="sun_aperture" value="9"/></emitter>', "no disk"),
        ('<shape type="cube"><bsdf type="roughdielectric"/></shape>', "roughdielectric"),
        (
            '<shape type="cube"><bsdf type="roughplastic"><string name="distribution" '
            'value="phong"/></bsdf></shape>',
            "distribution of microfacets 'phong'",
        ),
    ],
)
def test_what_is_not_modelled_is_named_and_an_error_when_strict(tmp_path, body, name):
    scene = load(tmp_path, "\n\n" + body, strict=False)
    assert len(scene.warnings) == 1
    assert scene.warnings[0][0].endswith("scene.xml:4") and name in scene.warnings[0][1]
    with pytest.raises(core.SceneError, match=f"scene.xml:4: .*{name}"):
        load(tmp_path, "\n\n" + body, strict=True)


UNREAD = [
    ("shape 'cube'", '<shape type="cube">{}</shape>'),
    ("shape 'sphere'", '<shape type="sphere">{}</shape>'),
    ("shape 'cylinder'", '<shape type="cylinder">{}</shape>'),
    ("shape 'instance'", '<shape type="shapegroup" id="g"><shape type="cube"/></shape><shape type="instance"><ref id="g"/>{}</shape>'),
    ("shape 'shapegroup'", '<shape type="shapegroup" id="g"><shape type="cube"/>{}</shape><shape type="instance"><ref id="g"/></shape>'),
    ("emitter 'area'", '<shape type="cube"><emitter type="area">{}</emitter></shape>'),
    ("emitter 'area'", '<emitter type="area" id="l">{}</emitter><shape type="cube"><ref id="l"/></shape>'),
    *((f"emitter '{kind}'", f'<emitter type="{kind}">{{}}</emitter>') for kind in ("point", "spot", "directional", "constant", "sunsky")),
    *((f"bsdf '{kind}'", f'<shape type="cube"><bsdf type="{kind}">{{}}</bsdf></shape>')
      for kind in ("diffuse", "plastic", "roughplastic", "conductor", "roughconductor", "dielectric", "thindielectric", "phong")),
    ("bsdf 'twosided'", '<shape type="cube"><bsdf type="twosided"><bsdf type="diffuse"/>{}</bsdf></shape>'),
    ("bsdf 'mask'", '<shape type="cube"><bsdf type="mask"><bsdf type="diffuse"/>{}</bsdf></shape>'),
    ("bsdf 'diffuse'", '<shape type="cube"><bsdf type="mask"><bsdf type="diffuse">{}</bsdf></bsdf></shape>'),
    ("bsdf 'diffuse'", '<bsdf type="diffuse" id="b">{}</bsdf><shape type="cube"><ref id="b"/></shape><shape type="cube"><ref id="b"/></shape>'),
    ("texture 'checkerboard'", '<shape type="cube"><bsdf type="diffuse"><texture name="reflectance" type="checkerboard">{}</texture></bsdf></shape>'),
    ("spectrum 'd65'", '<emitter type="point"><spectrum name="intensity" type="d65">{}</spectrum></emitter>'),
    ("sensor 'perspective'", '<sensor type="perspective">{}</sensor>'),
    ("sensor 'orthographic'", '<sensor type="orthographic">{}</sensor>'),
    ("film 'hdrfilm'", '<sensor type="perspective"><film type="hdrfilm">{}</film></sensor>'),
    ("scene", "{}"),
]  # fmt: skip


@pytest.mark.parametrize(("owner", "body"), UNREAD)
def test_a_property_that_nobody_reads_is_warned_of_with_its_line(tmp_path, owner, body):
    invented = body.format('\n<float name="inventedThing" value="1"/>\n')
    assert not load(tmp_path, body.format("")).warnings
    [(where, text)] = load(tmp_path, invented, strict=False).warnings
    assert where.endswith("scene.xml:3")
    assert text == f"property 'inventedThing' of {owner} is not read"
    with pytest.raises(core.SceneError, match=r"scene.xml:3: property 'inventedThing' of"):
        load(tmp_path, invented)


@pytest.mark.parametrize(
    ("body", "text"),
    [
        ('<shape type="cube"><bsdf type="diffuse"/>\n<bsdf type="plastic"/></shape>', "<bsdf> of shape 'cube' is not read"),
        ('<shape type="cube"><emitter type="area">\n<texture name="radiances" type="bitmap"/></emitter></shape>', "property 'radiances' of emitter 'area' is not read"),
        ('<sensor type="perspective">\n<ref name="medium" id="m"/></sensor><medium id="m" type="homogeneous"/>', "property 'medium' of sensor 'perspective' is not read"),
        ('<emitter type="directional"><vector name="direction" y="-1"/>\n<transform name="to_world"/></emitter>', "property 'to_world' of emitter 'directional' is not read"),
        ('<shape type="cube">\n<ref id="s"/></shape><shape type="cube" id="s"/>', "<ref> of shape 'cube' is not read"),
        ('\n<subsurface type="dipole"/>', "<subsurface> of scene is not read"),
    ],
)  # fmt: skip
def test_an_element_that_nobody_reads_is_warned_of_with_its_line(tmp_path, body, text):
    [(where, told)] = load(tmp_path, body, strict=False).warnings
    assert where.endswith("scene.xml:3") and told == text


def test_unread_elements_of_included_files_are_told_with_their_file(tmp_path):
    (tmp_path / "part.xml").write_text(
        '<scene>\n<shape type="cube"><float name="x" value="1"/></shape></scene>'
    )
    [(where, _)] = load(tmp_path, '<include filename="part.xml"/>', strict=False).warnings
    assert where.endswith("part.xml:2")


def test_what_leaves_the_picture_right_and_what_nobody_refers_to_is_not_told(tmp_path):
    scene = load(
        tmp_path,
        """<default name="spp" value="16"/>
        <integrator type="path"><integer name="max_depth" value="2"/></integrator>
        <bsdf type="hair" id="unused"><float name="x" value="1"/></bsdf>
        <emitter type="area" id="dark"><float name="x" value="1"/></emitter>
        <medium type="homogeneous" id="fog"/><texture type="bitmap" id="picture"/>
        <sensor type="perspective"><float name="shutterOpen" value="0"/><float name="focus_distance" value="3"/>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm"><rfilter type="gaussian"/><string name="pixel_format" value="rgb"/>
        <boolean name="banner" value="false"/></film></sensor>
        <shape type="cube" id="name"><float name="silhouette_sampling_weight" value="1"/>
        <bsdf type="roughconductor"><boolean name="sample_visible" value="true"/></bsdf></shape>
        <emitter type="sunsky"><vector name="sun_direction" x="0" y="0" z="1"/><integer name="hour" value="9"/>
        <float name="sun_aperture" value="0.5"/></emitter>
        <emitter type="point"><float name="samplingWeight" value="2"/></emitter>""",
    )
    assert not scene.warnings


def test_an_area_light_shines_on_the_shapes_that_refer_to_it(tmp_path):
    scene = load(
        tmp_path,
        """<shape type="rectangle"><ref id="lamp"/></shape><shape type="cube"/>
        <emitter type="area" id="lamp"><rgb name="radiance" value="6"/></emitter>""",
    )
    assert not scene.warnings
    assert [m["emission"] for m in scene.meshes] == [[6, 6, 6], [0, 0, 0]]


def test_diffuse_has_the_name_of_its_colour_in_0x(tmp_path):
    m = material(
        tmp_path,
        '<bsdf type="diffuse"><rgb name="diffuseReflectance" value="0.1"/></bsdf>',
        version="0.6.0",
    )
    assert m["base_color"] == pytest.approx([0.1] * 3)
