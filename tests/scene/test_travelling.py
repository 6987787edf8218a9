"""Scenes that are sent to other processes, and what notebooks show of them."""

from __future__ import annotations

import multiprocessing
import pickle
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

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
def other_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Results that this process made earlier are not reused."""
    monkeypatch.setattr(travelling, "_NEWEST", Newest())


@pytest.fixture(scope="module")
def pool() -> Iterator[ProcessPoolExecutor]:
    """One other process."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as made:
        yield made


def sent(scene: vc.Scene) -> vc.Scene:
    back: vc.Scene = pickle.loads(pickle.dumps(scene))
    assert back is not scene and back.content_hash == scene.content_hash
    assert (back.spec, back.name, back.warnings) == (scene.spec, scene.name, scene.warnings)
    a, b = (vc.render(s, vc.Direct(), size=SIZE) for s in (scene, back))
    assert a.sha256 == b.sha256
    return back


def described() -> vc.Scene:
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


def test_built_in_scenes_and_files_travel_by_their_spec(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    room = built("room?triangles=5000")
    assert len(pickle.dumps(room)) < 1000
    sent(room)
    (tmp_path / "one.obj").write_text(OBJ)
    monkeypatch.chdir(tmp_path)
    bytes_ = pickle.dumps(vc.load_scene("one.obj"))
    monkeypatch.chdir("/")
    back = pickle.loads(bytes_)
    assert back.spec == "one.obj" and back.triangles == 1


def test_scenes_of_arrays_travel_with_everything() -> None:
    back = sent(described())
    assert back.lights == described().lights
    assert [c.name for c in back.cameras] == ["front"]
    sent(vc.Scene.from_arrays(np.eye(3), [[0, 1, 2]], env=1.0))


def test_a_spec_that_does_not_give_the_scene_is_not_relied_on(tmp_path: Path) -> None:
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


def test_a_file_that_changed_on_the_way_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "one.obj"
    path.write_text(OBJ)
    bytes_ = pickle.dumps(vc.load_scene(path))
    path.write_text(OBJ.replace("1 0 0", "2 0 0"))
    with pytest.raises(vc.SceneError, match="must be the scene that was sent, its content differs"):
        pickle.loads(bytes_)


COPPER = {"metal_eta": (0.2, 0.9, 1.1), "metal_k": (3.9, 2.5, 2.1)}
GLOSSY: dict[str, Any] = {"kind": "glossy", "base_color": (0, 0, 0), "specular": (1, 1, 1)}
PLASTIC: dict[str, Any] = {"kind": "glossy", "specular": (1, 1, 1)}
#: Of triangles that differ in nothing else.
MATERIALS: tuple[dict[str, Any], ...] = (
    *(GLOSSY | COPPER | more for more in ({}, {"beckmann": True})),
    *(GLOSSY | more for more in ({}, {"beckmann": True}, {"metal_k": (1, 1, 1)})),
    *(PLASTIC | more for more in ({}, {"metallic": 0.5})),
    *(PLASTIC | {"coat": "rough", "nonlinear": more} for more in (False, True)),
    PLASTIC | {"coat": "smooth"},
    *({"kind": "dielectric", "thin": thin} for thin in (False, True)),
    *({"opacity": opacity} for opacity in (0.4, 0.41, 1)),
)


def test_materials_are_part_of_the_content_and_travel() -> None:
    triangle = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    made = [vc.Scene.from_arrays([(*triangle, material)]) for material in MATERIALS]
    hashes = [scene.content_hash for scene in made]
    assert len(set(hashes)) == len(made)
    assert [pickle.loads(pickle.dumps(scene)).content_hash for scene in made] == hashes


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
        ({"thin": True}, "only a dielectric can be thin"),
        ({"opacity": 1.5}, r"opacity must be in \[0, 1\], got 1.5"),
    ],
)
def test_materials_that_cannot_be_are_refused(wrong: dict[str, Any], said: str) -> None:
    triangle = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(ValueError, match=said):
        vc.Scene.from_arrays([(*triangle, GLOSSY | wrong)])


def test_a_scene_that_is_sent_often_is_made_once() -> None:
    bytes_ = pickle.dumps(described())
    assert pickle.loads(bytes_) is pickle.loads(bytes_)


@pytest.mark.parametrize(
    "spec", ["cornell_box", "room?triangles=3000", "garden?triangles=20000", "hairball"]
)
def test_built_in_scenes_come_back_from_their_arrays(spec: str) -> None:
    made = vc.scenes.build(spec)
    description = pickle.loads(pickle.dumps(_core.description_of(made._core)))
    assert vc.Scene.from_description(description).content_hash == made.content_hash


def rendered(scene: vc.Scene) -> str:
    return vc.render(scene, vc.Direct(), size=SIZE, threads=1).sha256


def test_pools_of_processes_take_scenes(pool: ProcessPoolExecutor) -> None:
    scene = described()
    assert list(pool.map(rendered, [scene, scene])) == [rendered(scene)] * 2
    parts = vc.tiles.render(scene, vc.Direct(), size=SIZE, executor=pool, parts=2)
    assert parts.sha256 == rendered(scene)
    given: dict[str, Any] = {"over": {"c_e": [4]}, "size": SIZE, "metrics": ["rel_l1"]}
    table, here = (vc.sweep(scene, "direct", executor=e, **given) for e in (pool, None))
    assert table.rel_l1.values == here.rel_l1.values


@pytest.mark.extreme
@pytest.mark.parametrize("damage", [b"", b"\x00" * 8, b"text that is no scene"])
def test_other_bytes_are_no_description(damage: bytes) -> None:
    with pytest.raises(vc.SceneError, match="the bytes "):
        vc.SceneDescription.__new__(vc.SceneDescription).__setstate__(damage)


def test_a_notebook_shows_a_scene() -> None:
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
def test_a_scene_without_lights_or_triangles_shows_what_there_is(scene: Any, shown: str) -> None:
    assert shown in scene()._repr_html_()


def test_what_goes_wrong_in_the_thumbnail_is_said_in_its_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fails(scene: vc.Scene) -> str:
        raise MemoryError("too <large>")

    monkeypatch.setattr(vc.Scene, "_picture", staticmethod(fails))
    text = vc.scenes.slits()._repr_html_()
    assert "no picture: too &lt;large&gt;" in text and "triangles" in text


def test_cameras_travel(pool: ProcessPoolExecutor) -> None:
    made = vc.look_at((1.5, 1.2, 2.5), (0.1, 0.2, 0.0), up=(0.1, 1.0, 0.3), fov_deg=33)
    made.name, made.width, made.height, made.fov_is_horizontal = "side", 48, 32, True
    back = pickle.loads(pickle.dumps(made))
    for name in ("name", "origin", "right", "up", "forward", "width", "height"):
        assert getattr(back, name) == getattr(made, name), name
    assert (back.fov_rad, back.fov_is_horizontal) == (made.fov_rad, True)
    scene = vc.scenes.cube_on_plane()
    frames = [vc.render(scene, "direct", camera=c, size=SIZE) for c in (made, back)]
    assert frames[0].sha256 == frames[1].sha256
    there = pool.submit(vc.render, scene, "direct", camera=made, size=SIZE).result()
    assert there.sha256 == frames[0].sha256


def test_a_camera_of_nonsense_is_refused_when_it_arrives() -> None:
    made = vc.look_at((1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    name, origin, _, up, forward, *rest = made.__getstate__()
    broken = type(made).__new__(type(made))  # type: ignore[call-arg]
    with pytest.raises((ValueError, vc.SceneError), match="must be finite and differ"):
        broken.__setstate__((name, origin, [0.0, 0.0, 0.0], up, forward, *rest))


def test_a_sweep_takes_a_camera_of_ones_own(pool: ProcessPoolExecutor, tmp_path: Path) -> None:
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
