"""Freezing a description: what is refused, what the scene tells, what its hash covers."""

import numpy as np
import pytest

import viscache as vc
from viscache import _core
from viscache._core import MaterialKind

CARD = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])


def described():
    """One of everything."""
    d = vc.SceneDescription()
    d.name = "everything"
    image = d.add_image(np.full((2, 3, 3), 0.5, np.float32))
    d.add_material(base_color=(0.1, 0.2, 0.3), base_texture=image)
    d.add_material(MaterialKind.GLOSSY, specular=(0.5, 0.5, 0.5), roughness=0.2)
    d.add_mesh(*CARD, uvs=np.zeros((4, 2)), normals=np.tile([0, 0, 1], (4, 1)), name="card")
    d.add_mesh(*CARD, material=1, emission=(1, 2, 3), in_world=False)
    d.add_instance([1], np.eye(4))
    d.add_point_light((1, 2, 3), (4, 5, 6))
    d.add_directional_light((0, 3, 0), (1, 1, 1))
    d.add_sphere_light((9, 9, 9), 0.5, (1, 0, 0))
    d.set_environment((0.1, 0.2, 0.3))
    d.add_camera((0, 0, 5), (0, 0, 0))
    return d


def test_a_frozen_scene_tells_what_it_holds():
    scene = vc.Scene.from_description(described())
    assert scene.name == "everything" and "everything" in repr(scene)
    assert scene.triangles == 4, (
        "two placed cards; the emitting sphere's own triangles do not count"
    )
    # The cards, and the emitting sphere whole
    np.testing.assert_array_equal(scene.bounds, [[0, 0, 0], [9.5, 9.5, 9.5]])
    assert [light["kind"] for light in scene.lights] == [
        "point",
        "directional",
        "area",
        "sphere",
        "constant",
    ]
    np.testing.assert_allclose(scene.lights[1]["direction"], [0, 1, 0])
    info = scene.info()
    assert info["instances"] == 1 and info["unique_triangles"] == 4 and info["memory_bytes"] > 0
    assert [c["name"] for c in info["cameras"]] == ["camera"]
    meshes = scene.meshes()
    assert [m["name"] for m in meshes] == ["card", ""] and not meshes[1]["in_world"]
    np.testing.assert_array_equal(meshes[0]["vertices"], np.float32(CARD[0]))


def test_changing_the_description_afterwards_changes_no_scene():
    d = described()
    scene = vc.Scene.from_description(d)
    before = scene.content_hash
    d.add_point_light((0, 0, 0), (1, 1, 1))
    assert scene.content_hash == before and len(scene.lights) == 5


def test_the_hash_is_that_of_equal_content():
    a, b = (vc.Scene.from_description(described()) for _ in range(2))
    assert a.content_hash == b.content_hash and len(a.content_hash) == 32
    renamed = described()
    renamed.name = "other"
    assert vc.Scene.from_description(renamed).content_hash == a.content_hash, (
        "names do not change looks"
    )


@pytest.mark.parametrize(
    ("method", "given"),
    [
        ("add_point_light", [(1, 2, 3), (0, 0, 1)]),
        ("add_directional_light", [(0, 1, 0), (1, 1, 1)]),
        ("add_sphere_light", [(9, 9, 9), 0.25, (1, 0, 0)]),
        ("set_environment", [(0.1, 0.2, 0.4)]),
        ("clear_environment", []),
        ("add_mesh", CARD),
        ("add_instance", [[1], 2 * np.eye(4)]),
        ("add_camera", [(0, 0, 6), (0, 0, 0)]),
        ("add_material", []),
        ("add_image", [np.zeros((1, 1, 3))]),
        ("set_image", [0, np.full((3, 2, 3), 0.5)]),
        ("set_image", [0, np.full((2, 3, 3), 0.25)]),
    ],
)
def test_the_hash_changes_with_the_content(method, given):
    made = described()
    getattr(made, method)(*given)
    a, b = (vc.Scene.from_description(d).content_hash for d in (made, described()))
    assert a != b


ONE, UP = (1, 1, 1), [[0, 0, 1]]
BAD_MESHES = [
    ({"vertices": [[0, 0, np.nan]] * 4}, "vertex 0 must be finite"),
    ({"vertices": [[0, 0, 0]] * 3 + [[0, np.inf, 0]]}, "vertex 3 must be finite"),
    ({"vertices": [[0, 0, 0]] * 3 + [[2e16, 0, 0]]}, "vertex 3 must be finite and at most 1e12"),
    ({"triangles": [[0, 1, 4]]}, "triangle 0 names vertex 4, but there are 4"),
    ({"material": 2}, r"material must be in \[0, 2\), got 2"),
    ({"material": -1}, "material must be in"),
    ({"emission": (-1, 0, 0)}, "emission must be finite and >= 0"),
    ({"emission": (np.nan, 0, 0)}, "emission must be finite and >= 0"),
    ({"uvs": [[0, 0]]}, "uvs must be one per vertex"),
    ({"normals": UP}, "normals must be one per vertex"),
]
IN_0_1 = r"base_color and specular must be in \[0, 1\]"
BAD_MATERIALS = [
    ({"base_color": (1.5, 0, 0)}, IN_0_1),
    ({"specular": (0, -0.1, 0)}, IN_0_1),
    ({"roughness": 0}, "roughness must be in"),
    ({"roughness": np.nan}, "roughness must be in"),
    ({"eta": 0}, "eta must be in"),
    ({"base_texture": 7}, "texture must be -1 or in"),
]
BAD_CALLS = [
    *(("add_mesh", [], {"vertices": CARD[0], "triangles": CARD[1]} | m, s) for m, s in BAD_MESHES),
    *(("add_material", [], material, says) for material, says in BAD_MATERIALS),
    ("add_point_light", [(np.nan, 0, 0), ONE], {}, "point light 1: position must be finite"),
    ("add_point_light", [(0, 0, 0), (1, -1, 1)], {}, "point light 1: intensity must be"),
    ("add_directional_light", [(0, 0, 0), ONE], {}, "light 1: direction must not be zero"),
    ("add_directional_light", [(0, 1, 0), (np.inf, 1, 1)], {}, "directional light 1: irradiance"),
    ("add_sphere_light", [(0, 0, 0), 0, ONE], {}, "sphere light 1: radius must be > 0"),
    ("add_sphere_light", [(0, 0, 0), -1, ONE], {}, "sphere light 1: radius must be > 0"),
    ("add_sphere_light", [(0, 0, 0), 1, (np.nan, 1, 1)], {}, "sphere light 1: radiance"),
    ("set_environment", [(-1, 0, 0)], {}, "environment: scale must be"),
    ("set_environment", [ONE], {"image": 5}, "environment: image must be"),
    ("add_instance", [[5], np.eye(4)], {}, r"instance 1: mesh must be in \[0, 2\), got 5"),
    ("add_instance", [[0], np.zeros((3, 4))], {}, "instance 1: to_world must be invertible"),
    ("add_instance", [[0], 1e-25 * np.eye(4)[:3]], {}, "to_world must stretch by 1e-24 or more"),
    ("add_instance", [[0], np.diag([1e6, 1.0, 1e-6, 1.0])], {}, "stretch no direction more than"),
    ("add_instance", [[0], np.full((3, 4), np.nan)], {}, "instance 1: to_world must be finite"),
    ("add_image", [np.full((1, 1, 3), np.nan)], {}, "must hold finite pixels"),
    ("add_camera", [(0, 0, 0), (0, 0, 0)], {}, "camera 'camera': origin and target"),
    ("add_camera", [(0, 0, 1), (0, 0, 0)], {"fov_deg": 180}, "field of view must be in"),
]


@pytest.mark.parametrize(("method", "given", "more", "says"), BAD_CALLS)
def test_what_cannot_be_used_is_refused_with_its_place(method, given, more, says):
    d = described()
    getattr(d, method)(*given, **more)
    with pytest.raises(vc.SceneError, match=says):
        vc.Scene.from_description(d)


@pytest.mark.parametrize(
    ("method", "given", "says"),
    [
        ("add_mesh", ([[0, 0]], [[0, 0, 0]]), r"vertices must have shape \(N, 3\), got \(1, 2\)"),
        ("add_mesh", ([0, 0, 0], [[0, 0, 0]]), r"vertices must have shape \(N, 3\), got \(3,\)"),
        ("add_mesh", (CARD[0], [0, 1, 2]), r"triangles must have shape \(N, 3\)"),
        ("add_instance", ([0], np.eye(3)), r"to_world must have shape \(3, 4\) or \(4, 4\)"),
        ("add_image", (np.zeros((2, 2)),), r"pixels must have shape \(H, W, 1..4\)"),
        ("add_image", (np.zeros((2, 2, 5)),), r"pixels must have shape \(H, W, 1..4\)"),
    ],
)
def test_wrong_shapes_are_refused_at_once(method, given, says):
    with pytest.raises(ValueError, match=says):
        getattr(vc.SceneDescription(), method)(*given)


def test_coordinates_of_a_wrong_shape_are_refused_at_once():
    with pytest.raises(ValueError, match=r"uvs must have shape \(N, 2\)"):
        vc.SceneDescription().add_mesh(*CARD, uvs=np.zeros((4, 3)))


def test_arrays_of_many_kinds_make_a_scene():
    for vertices, triangles in (
        CARD,
        (np.array(CARD[0], np.float16), np.array(CARD[1], np.int8)),
        (np.asfortranarray(CARD[0]), np.array(CARD[1], np.uint64)[:, ::-1]),
    ):
        scene = vc.Scene.from_arrays(vertices, triangles, base_color=(0.1, 0.2, 0.3), env=(1, 2, 3))
        assert scene.triangles == 2
        assert not scene.visible([[0.5, 0.5, 1]], [[0.5, 0.5, -1]])[0]


@pytest.mark.parametrize(
    ("kwargs", "says"),
    [
        ({"triangles": [[0, 1, -1]]}, "triangles must index vertices, got values from -1 to 1"),
        ({"triangles": [[0, 1, 1 << 33]]}, "triangles must index vertices"),
        ({"triangles": [[0.0, 1.0, 2.5]]}, "triangles must be integers, got dtype float64"),
        ({"triangles": [[0, 1]]}, r"triangles must have shape \(N, 3\)"),
        ({"base_color": (1, 1)}, "base_color must have 3 values, got 2"),
        ({"base_color": 3}, "base_color must be 3 numbers, got 3"),
        ({"base_color": "red"}, "base_color must be 3 numbers, got 'red'"),
        ({"vertices": np.array(CARD[0]) * 1j}, "vertices must be real numbers, got dtype complex"),
        ({"normals": np.ones((4, 3)) * 1j}, "normals must be real numbers, got dtype complex"),
        ({"env": (1, 2)}, r"env must be a path, a number, 3 numbers or \(H, W, 3\) pixels"),
        ({"env": -1.0}, "environment: scale must be"),
        (
            {"env": np.full((4, 8, 3), -1.0)},
            r"environment image .* must be finite and >= 0, got .* row 0, column 0",
        ),
        ({"env": "no-such-file.exr"}, "no-such-file.exr"),
    ],
)
def test_arrays_that_make_no_scene_are_refused(kwargs, says):
    given = {"vertices": CARD[0], "triangles": CARD[1]} | kwargs
    with pytest.raises(ValueError, match=says):
        vc.Scene.from_arrays(given.pop("vertices"), given.pop("triangles"), **given)


def albedo(pixels, u, v):
    """What an image shows at coordinates."""
    d = vc.SceneDescription()
    material = d.add_material(base_color=(1, 1, 1), base_texture=d.add_image(pixels))
    d.add_mesh(*CARD, uvs=np.tile([u, v], (4, 1)), material=material)
    d.add_camera((0.5, 0.5, 1), (0.5, 0.5, 0), fov_deg=10)
    frame = vc.render(vc.Scene.from_description(d), vc.Direct(), size=(1, 1))
    return frame.layers["albedo"][0, 0]


def test_a_texture_is_bilinear_repeats_and_has_its_top_row_at_v_1():
    pixels = np.array([[[1, 0, 0], [0, 1, 0]], [[0, 0, 1], [1, 1, 1]]], np.float32)
    for (u, v), expected in {
        (0.25, 0.75): pixels[0, 0],
        (0.75, 0.75): pixels[0, 1],
        (0.25, 0.25): pixels[1, 0],
        (0.75, 0.25): pixels[1, 1],
        (1.25, -0.25): pixels[0, 0],
        (0.5, 0.75): (pixels[0, 0] + pixels[0, 1]) / 2,
        (0.5, 0.5): pixels.mean((0, 1)),
        (0.0, 0.75): (pixels[0, 0] + pixels[0, 1]) / 2,
    }.items():
        np.testing.assert_allclose(albedo(pixels, u, v), expected, atol=1e-5, err_msg=str((u, v)))


@pytest.mark.parametrize("channels", [1, 2, 4])
def test_grey_images_are_grey_and_alpha_is_no_colour(channels):
    pixels = np.full((1, 1, channels), 0.25, np.float32)
    if channels > 1:
        pixels[..., -1] = 0.9
    np.testing.assert_allclose(albedo(pixels, 0, 0), 0.25)


def test_a_sphere_light_is_seen_as_a_disk_and_hides_what_is_behind():
    d = vc.SceneDescription()
    d.add_sphere_light((0, 0, 0), 1.0, (1, 2, 3))
    d.add_camera((0, 0, 5), (0, 0, 0), fov_deg=45)
    scene = vc.Scene.from_description(d)
    image = vc.render(scene, vc.Direct(), size=(64, 64), spp=16).image
    radius = 32 * np.tan(np.arcsin(1 / 5)) / np.tan(np.radians(22.5))
    assert image[..., 0].sum() == pytest.approx(np.pi * radius**2, rel=0.01)
    np.testing.assert_array_equal(image[32, 32], [1, 2, 3])
    assert not scene.visible([[0, 0, 2]], [[0, 0, -2]])[0]
    assert scene.visible([[0, 1.001, 2]], [[0, 1.001, -2]])[0]


def test_an_environment_given_to_render_replaces_the_scenes():
    scene = vc.Scene.from_arrays(np.zeros((0, 3)), np.zeros((0, 3), int), env=(1, 1, 1))
    assert vc.render(scene, vc.Direct(), size=(2, 2), env=(3, 2, 1)).image[0, 0].tolist() == [
        3,
        2,
        1,
    ]
    assert vc.render(scene, vc.Direct(), size=(2, 2)).image[0, 0].tolist() == [1, 1, 1]
    for black in (0.0, np.zeros((4, 8, 3))):
        assert not vc.render(scene, vc.Direct(), size=(2, 2), env=black).image.any()


def test_a_scene_with_a_new_environment_keeps_everything_else():
    scene = vc.Scene.from_description(described())
    other = scene.with_environment((0.1, 0.2, 0.3))
    assert other.content_hash == scene.content_hash
    assert other.triangles == scene.triangles and other.lights == scene.lights
    assert len(_core.scene_materials(other._core)) == len(_core.scene_materials(scene._core)) == 2


def test_a_mesh_turned_inside_out_by_its_instance_keeps_its_front():
    """Mirroring swaps the winding; the emitting side must stay where the object had it."""
    for flip in (1.0, -1.0):
        d = vc.SceneDescription()
        mesh = d.add_mesh(*CARD, emission=(1, 1, 1), in_world=False)
        d.add_instance([mesh], np.diag([flip, 1.0, 1.0, 1.0]))
        d.add_camera((flip * 0.5, 0.5, 2), (flip * 0.5, 0.5, 0), fov_deg=10)
        d.add_camera((flip * 0.5, 0.5, -2), (flip * 0.5, 0.5, 0), fov_deg=10)
        scene = vc.Scene.from_description(d)
        front, back = (
            vc.render(scene, vc.Direct(), size=(4, 4), camera=i).image.mean() for i in (0, 1)
        )
        assert (front, back) == (1, 0)


@pytest.mark.slow
@pytest.mark.extreme
@pytest.mark.parametrize("instanced", [False, True])
@pytest.mark.parametrize("exponent", range(-72, 47, 4))
def test_a_scene_too_small_or_too_large_for_single_precision_says_so(exponent, instanced):
    rng = np.random.default_rng(1)
    vertices = (rng.random((900, 3)) + np.repeat(rng.random((300, 3)) * 9, 3, axis=0)).astype("f4")
    triangles = np.arange(900, dtype=np.uint32).reshape(-1, 3)
    origins = (rng.random((20_000, 3)) * 10).astype("f4")
    directions = rng.normal(size=(20_000, 3)).astype("f4")

    def answers(scale):
        d = vc.SceneDescription()
        d.add_material()
        if instanced:
            d.add_mesh(vertices, triangles, in_world=False)
            d.add_instance([0], np.diag([scale, scale, scale, 1.0]))
        else:
            d.add_mesh(vertices * np.float32(scale), triangles)
        scene = vc.Scene.from_description(d)
        return scene.occluded(origins * np.float32(scale), directions), scene.warnings

    reference, none = answers(1.0)
    assert not any("spans" in text for text in none)
    if exponent >= 40:  # vertices beyond 1e12
        with pytest.raises(vc.SceneError, match="1e12 in size"):
            answers(2.0**exponent)
        return
    found, warnings = answers(2.0**exponent)
    unlike = float(np.mean(found != reference))
    warned = any("spans" in text for text in warnings)
    assert warned or unlike < 1e-3, f"{unlike:.2%} of the rays answered differently, no warning"
    # Sizes that people use are not warned of
    assert not (warned and -16 <= exponent <= 24)


def test_scenes_far_from_the_origin_are_warned_of():
    vertices = np.array(CARD[0], np.float32)
    for offset, warned in ((900, False), (2_000, True), (1e6, True)):
        scene = vc.Scene.from_arrays(vertices + np.float32(offset), CARD[1])
        assert any("times its size from the origin" in w for w in scene.warnings) == warned
    assert "leaves it 16 steps across" in scene.warnings[-1]
    point = vc.Scene.from_arrays([[1e6] * 3] * 3, [[0, 1, 2]])
    assert any("all vertices are one point" in w for w in point.warnings)
    at_home = vc.Scene.from_arrays([[0.0] * 3] * 3, [[0, 1, 2]])
    assert not any("point" in w for w in at_home.warnings)
