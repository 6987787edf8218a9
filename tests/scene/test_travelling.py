"""Scenes that are sent to other processes, and what notebooks show of them."""

import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import viscache as vc
from reference.built import built
from viscache import _core
from viscache.base.sharing import Newest
from viscache.scenes import travelling

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
SIZE = (24, 16)


@pytest.fixture(autouse=True)
def other_process(monkeypatch):
    """Results that this process made earlier are not reused."""
    monkeypatch.setattr(travelling, "_NEWEST", Newest())


@pytest.fixture(scope="module")
def pool():
    """One other process."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as made:
        yield made


def sent(scene):
    back = pickle.loads(pickle.dumps(scene))
    assert back is not scene and back.content_hash == scene.content_hash
    assert (back.spec, back.name, back.warnings) == (scene.spec, scene.name, scene.warnings)
    a, b = (vc.render(s, vc.Direct(), size=SIZE) for s in (scene, back))
    assert a.sha256 == b.sha256
    return back


def described():
    d = vc.SceneDescription()
    d.name = "described"
    texture = d.add_image(np.random.default_rng(0).random((4, 4, 3)))
    grey = d.add_material(base_color=(0.6, 0.6, 0.6), base_texture=texture)
    corners = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], dtype=float)
    uvs = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
    quad = np.array([[0, 2, 1], [0, 3, 2]], np.uint32)
    d.add_mesh(corners, quad, material=grey, uvs=uvs)
    leaf = d.add_mesh(0.2 * corners, quad, material=grey, uvs=uvs, in_world=False)
    for k in range(3):
        d.add_instance([leaf], [[1, 0, 0, 0.3 * k], [0, 1, 0, 0.4], [0, 0, 1, 0]])
    d.add_point_light((0.0, 2.0, 0.0), (10.0, 10.0, 10.0))
    d.add_sphere_light((1.0, 3.0, 0.0), 0.2, (5.0, 5.0, 5.0))
    d.add_directional_light((0.0, 1.0, 0.2), (1.0, 1.0, 1.0))
    d.set_environment((0.3, 0.3, 0.3))
    d.add_camera((0.0, 2.0, 4.0), (0.0, 0.0, 0.0), name="front")
    d.warn("made:1", "is only a test")
    return vc.Scene.from_description(d)


def test_built_in_scenes_and_files_travel_by_their_spec(tmp_path, monkeypatch):
    room = built("room?triangles=5000")
    assert len(pickle.dumps(room)) < 1000
    sent(room)
    (tmp_path / "one.obj").write_text(OBJ)
    monkeypatch.chdir(tmp_path)
    bytes_ = pickle.dumps(vc.load_scene("one.obj"))
    monkeypatch.chdir("/")
    back = pickle.loads(bytes_)
    assert back.spec == "one.obj" and back.triangles == 1


def test_scenes_of_arrays_travel_with_everything():
    back = sent(described())
    assert back.lights == described().lights
    assert [c.name for c in back.cameras] == ["front"]
    sent(vc.Scene.from_arrays(np.eye(3), [[0, 1, 2]], env=1.0))


def test_a_spec_that_does_not_give_the_scene_is_not_relied_on(tmp_path):
    lit = vc.scenes.cube_on_plane().with_environment(3.0)
    assert lit.spec == "cube_on_plane"
    sent(lit)
    path = tmp_path / "one.obj"
    path.write_text(OBJ)
    scene = vc.load_scene(path, env=1.0)
    sent(scene)
    plain = vc.load_scene(path)
    path.unlink()
    sent(plain)


def test_a_file_that_changed_on_the_way_is_refused(tmp_path):
    path = tmp_path / "one.obj"
    path.write_text(OBJ)
    bytes_ = pickle.dumps(vc.load_scene(path))
    path.write_text(OBJ.replace("1 0 0", "2 0 0"))
    with pytest.raises(vc.SceneError, match="must be the scene that was sent, its content differs"):
        pickle.loads(bytes_)


COPPER = {"metal_eta": (0.2, 0.9, 1.1), "metal_k": (3.9, 2.5, 2.1)}
GLOSSY = {"kind": "glossy", "base_color": (0, 0, 0), "specular": (1, 1, 1)}
PLASTIC = {"kind": "glossy", "specular": (1, 1, 1)}
#: Of triangles that differ in nothing else.
MATERIALS = (
    *(GLOSSY | COPPER | more for more in ({}, {"beckmann": True})),
    *(GLOSSY | more for more in ({}, {"beckmann": True}, {"metal_k": (1, 1, 1)})),
    *(PLASTIC | more for more in ({}, {"metallic": 0.5})),
    *(PLASTIC | {"coat": "rough", "nonlinear": more} for more in (False, True)),
    PLASTIC | {"coat": "smooth"},
    *({"kind": "dielectric", "thin": thin} for thin in (False, True)),
    *({"kind": "dielectric", "transmission": tint} for tint in ((1, 0.5, 1), (1, 1, 0.5))),
    *(GLOSSY | {"specular": (0.04,) * 3, "coat": "fresnel_mix", "f90": more} for more in (0.9, 1)),
    *({"opacity": opacity} for opacity in (0.4, 0.41, 1)),
)


def with_image(material, **image):
    d = vc.SceneDescription()
    d.add_image(np.float32([[[0.5] * 3, [0] * 3], [[0] * 3, [0.5] * 3]]), **image)
    d.add_material(**material)
    d.add_mesh(*TRIANGLE)
    return vc.Scene.from_description(d)


def with_light(**cone):
    d = vc.SceneDescription()
    d.add_mesh(*TRIANGLE)
    d.add_point_light((1, 2, 3), (4, 5, 6), **cone)
    return vc.Scene.from_description(d)


TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
ROUGH = {"kind": _core.MaterialKind.GLOSSY}
#: In each group, scenes that differ in one thing alone.
GROUPS = {
    "materials": lambda: [vc.Scene.from_arrays([(*TRIANGLE, material)]) for material in MATERIALS],
    "borders": lambda: [
        with_image({"base_texture": 0}, wrap=wrap)
        for wrap in (("repeat",) * 2, ("mirror", "repeat"), ("repeat", "mirror"), ("clamp",) * 2)
    ],
    "filters": lambda: [
        with_image({"base_texture": 0}, nearest=nearest) for nearest in (True, False)
    ],
    "images of roughness": lambda: [
        with_image(ROUGH | more)
        for more in ({}, {"metallic_roughness_texture": 0}, {"roughness_texture": 0})
    ],
    "cones": lambda: [
        with_light(),
        *(with_light(axis=(0, 0, -2), cone_deg=(10, outer)) for outer in (25, 26)),
    ],
}


@pytest.mark.parametrize("group", GROUPS)
def test_what_a_scene_looks_like_is_part_of_its_content_and_travels(group):
    made = GROUPS[group]()
    back = [pickle.loads(pickle.dumps(scene)) for scene in made]
    hashes = [scene.content_hash for scene in made]
    assert len(set(hashes)) == len(made)
    assert [scene.content_hash for scene in back] == hashes
    assert [s.lights for s in back] == [s.lights for s in made]
    images = [[_core.description_of(s._core).images for s in scenes] for scenes in (made, back)]
    assert images[0] == images[1]


def test_a_light_has_its_cone_and_the_geometry_has_none():
    point, spot, _ = GROUPS["cones"]()
    assert [s.lights[0]["kind"] for s in (point, spot)] == ["point", "spot"]
    assert spot.lights[0]["axis"] == [0, 0, -1] and spot.lights[0]["falloff"] == "smooth"
    assert spot.lights[0]["cone_deg"] == pytest.approx((10, 25), rel=1e-4)
    assert point.geometry_hash == spot.geometry_hash
    with pytest.raises(ValueError, match="wrap must be two of"):
        with_image({}, wrap=("repeat", "zero"))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"metal_eta": (1, 0, 1)}, "not both 0"),
        ({"metal_k": (1, 1, 2e4)}, "metal_eta and metal_k must be in"),
        ({"metal_k": (1, 1, 1), "base_color": (0.1, 0, 0)}, "only mirrors and glossy materials"),
        ({"metal_k": (1, 1, 1), "kind": "diffuse"}, "only mirrors and glossy materials"),
        ({"beckmann": True, "kind": "mirror"}, "only a glossy material"),
        ({"beckmann": True, "coat": "rough"}, "only a glossy material"),
        ({"metallic": 1.5}, "metallic must be in"),
        ({"metallic": 0.5, "kind": "diffuse"}, "only a glossy material"),
        ({"coat": "smooth", "kind": "diffuse"}, "only a glossy material has a coat"),
        ({"coat": "wet"}, "coat of a material must be one of"),
        ({"nonlinear": True}, "nonlinear needs a coat"),
        ({"thin": True}, "only a dielectric or a fresnel_mix can be thin"),
        ({"f90": 0.5}, "only a fresnel_mix has f90"),
        ({"kind": "glossy", "coat": "fresnel_mix", "f90": 0.5}, "f90 must be in"),
        ({"transmission": (1, 1, 2)}, "transmission must be in"),
        ({"opacity": 1.5}, r"opacity must be in \[0, 1\], got 1.5"),
    ],
)
def test_materials_that_cannot_be_are_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        vc.Scene.from_arrays([(*TRIANGLE, GLOSSY | wrong)])


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"metallic_roughness_texture": 1}, "texture must be -1 or in"),
        ({"roughness_texture": 0, "metallic_roughness_texture": 0}, "exclude each other"),
        ({"roughness_texture": 0, "coat": _core.CoatKind.ROUGH}, "without a coat"),
    ],
)
def test_wrong_images_of_roughness_are_refused(wrong, said):
    with pytest.raises(vc.SceneError, match=said):
        with_image(ROUGH | wrong)


def test_a_scene_that_is_sent_often_is_made_once():
    bytes_ = pickle.dumps(described())
    assert pickle.loads(bytes_) is pickle.loads(bytes_)


@pytest.mark.parametrize("spec", ["cornell_box", "room?triangles=3000", "garden?triangles=20000"])
def test_built_in_scenes_come_back_from_their_arrays(spec):
    made = vc.scenes.build(spec)
    description = pickle.loads(pickle.dumps(_core.description_of(made._core)))
    assert vc.Scene.from_description(description).content_hash == made.content_hash


def rendered(scene):
    return vc.render(scene, vc.Direct(), size=SIZE, threads=1).sha256


def test_pools_of_processes_take_scenes(pool):
    scene = described()
    assert list(pool.map(rendered, [scene, scene])) == [rendered(scene)] * 2
    parts = vc.tiles.render(scene, vc.Direct(), size=SIZE, executor=pool, parts=2)
    assert parts.sha256 == rendered(scene)
    given = {"over": {"c_e": [4]}, "size": SIZE, "metrics": ["rel_l1"]}
    table, here = (vc.sweep(scene, "direct", executor=e, **given) for e in (pool, None))
    assert table.rel_l1.values == here.rel_l1.values


@pytest.mark.extreme
@pytest.mark.parametrize("damage", [b"", b"\x00" * 8, b"text that is no scene"])
def test_other_bytes_are_no_description(damage):
    with pytest.raises(vc.SceneError, match="the bytes "):
        vc.SceneDescription.__new__(vc.SceneDescription).__setstate__(damage)


def test_a_notebook_shows_a_scene():
    text = described()._repr_html_()
    picture = ("data:image/png;base64,", "thumbnail")
    table = ("<td>8</td>", "front", "1 point", "1 sphere", "bounds")
    for wanted in (*picture, *table, "described", "is only a test"):
        assert wanted in text, wanted


@pytest.mark.parametrize(
    ("scene", "shown"),
    [
        (lambda: vc.Scene.from_arrays(np.eye(3), [[0, 1, 2]]), "alt='normals'"),
        (lambda: vc.Scene.from_arrays(np.zeros((0, 3)), np.zeros((0, 3), int)), "no triangles"),
        (lambda: vc.scenes.slits(), "alt='thumbnail'"),
    ],
)
def test_a_scene_without_lights_or_triangles_shows_what_there_is(scene, shown):
    assert shown in scene()._repr_html_()


def test_what_goes_wrong_in_the_thumbnail_is_said_in_its_place(monkeypatch):
    def fails(scene):
        raise MemoryError("too <large>")

    monkeypatch.setattr(vc.Scene, "_picture", staticmethod(fails))
    text = vc.scenes.slits()._repr_html_()
    assert "no picture: too &lt;large&gt;" in text and "triangles" in text


def made_camera(kind):
    if kind == "orthographic":
        return vc.orthographic((1.5, 1.2, 2.5), (0.1, 0.2, 0.0), height=3.5)
    made = vc.look_at((1.5, 1.2, 2.5), (0.1, 0.2, 0.0), up=(0.1, 1.0, 0.3), fov_deg=33)
    made.name, made.width, made.height, made.fov_is_horizontal = "side", 48, 32, True
    if kind == "shifted":
        made.shift_x, made.shift_y = 0.2, -0.1
    return made


PARTS = "name origin right up forward width height fov_is_horizontal view_height shift_x shift_y"


@pytest.mark.parametrize("kind", ["perspective", "orthographic", "shifted"])
def test_cameras_travel(pool, kind):
    made = made_camera(kind)
    back = pickle.loads(pickle.dumps(made))
    assert [getattr(back, part) for part in PARTS.split()] == [
        getattr(made, part) for part in PARTS.split()
    ]
    assert back.fov_rad == made.fov_rad
    frames = [vc.render("cube_on_plane", "direct", camera=c, size=SIZE) for c in (made, back)]
    assert frames[0].sha256 == frames[1].sha256
    there = pool.submit(vc.render, "cube_on_plane", "direct", camera=made, size=SIZE).result()
    assert there.sha256 == frames[0].sha256


@pytest.mark.parametrize(
    ("part", "value", "says"),
    [
        ("shift_x", float("nan"), "the shift must be finite"),
        ("view_height", -1, "view_height must be finite and >= 0"),
    ],
)
def test_parts_of_cameras_count_and_are_checked(part, value, says):
    made = made_camera("orthographic")
    before = vc.render("cube_on_plane", "direct", camera=made, size=SIZE).sha256
    setattr(made, part, 3.6)
    assert vc.render("cube_on_plane", "direct", camera=made, size=SIZE).sha256 != before
    setattr(made, part, value)
    with pytest.raises(ValueError, match=says):
        vc.render("cube_on_plane", "direct", camera=made, size=SIZE)


def test_a_camera_of_nonsense_is_refused_when_it_arrives():
    made = vc.look_at((1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    name, origin, _, up, forward, *rest = made.__getstate__()
    broken = type(made).__new__(type(made))  # type: ignore[call-arg]
    with pytest.raises((ValueError, vc.SceneError), match="must be finite and differ"):
        broken.__setstate__((name, origin, [0.0, 0.0, 0.0], up, forward, *rest))


def test_a_sweep_takes_a_camera_of_ones_own(pool, tmp_path):
    over, given = {"c_e": [4]}, {"size": SIZE, "metrics": ["rel_l1"], "directory": tmp_path}
    near, far = (vc.look_at((d, d, d), (0.0, 0.0, 0.0)) for d in (2.0, 4.0))
    vc.sweep("cube_on_plane", "direct", over=over, camera=near, executor=pool, **given)
    frames = tmp_path / "frames"
    assert len(list(frames.iterdir())) == 2
    vc.sweep("cube_on_plane", "direct", over=over, camera=near, **given)
    assert len(list(frames.iterdir())) == 2
    vc.sweep("cube_on_plane", "direct", over=over, camera=far, **given)
    assert len(list(frames.iterdir())) == 4
    kept = {vc.Frame.load(p).sha256 for p in frames.iterdir()}
    assert vc.render("cube_on_plane", "direct", camera=near, size=SIZE).sha256 in kept
