"""`visible_matrix` by shafts: the bits of packets, in every scene and for any number of threads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from oracles.test_oracle import area_points
from reference.built import built
from reference.isas import AVAILABLE
from viscache import _core
from viscache.settings.rays import Rays
from visibility.test_shafts import SCENES, leaves, needles, shared_scenes
from visibility.test_shafts import some_of_a_grid as half_a_grid

Array = npt.NDArray[Any]


@pytest.fixture(scope="module")
def room() -> vc.Scene:
    return built("room?triangles=3000")


def on_surfaces(scene: vc.Scene, n: int, seed: int = 1) -> Array:
    return np.asarray(area_points(scene, n, seed=seed).positions)


def in_space(scene: vc.Scene, n: int, seed: int = 2) -> Array:
    return np.random.default_rng(seed).uniform(*scene.bounds, (n, 3)).astype(np.float32)


def grid_places(n: int, height: float, step: float = 1.0) -> Array:
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    return np.stack([i * step, np.full(n * n, height), j * step], axis=1).astype(np.float32)


def by_shafts(scene: vc.Scene, x: Array, y: Array, **more: Any) -> tuple[Array, dict[str, Any]]:
    bits, work = _core.shaft_matrix(_core.ShaftScene(scene._core), scene.caster(), x, y, **more)
    return bits, work


def differences(scene: vc.Scene, x: Array, y: Array, **more: Any) -> int:
    """Number of bits that are not those of packets."""
    bits, work = by_shafts(scene, x, y, **more)
    assert work["shaft_queries"] == len(x) * len(y)
    packets = scene.visible_matrix(x, y, engine="packets")
    return int(np.unpackbits((bits ^ packets).view(np.uint8)).sum())


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("spec", ["room?triangles=3000", "cornell_box", "random_triangles"])
def test_bits_are_those_of_packets_on_every_instruction_set(spec: str, isa: str) -> None:
    scene = built(spec)
    for x in (on_surfaces(scene, 1500), in_space(scene, 700)):
        for y in (on_surfaces(scene, 70, 9), in_space(scene, 40, 8)):
            assert differences(scene, x, y, isa=isa) == 0


@pytest.mark.parametrize("shape", [(1, 1), (1, 200), (15, 3), (17, 64), (4097, 65)])
def test_matrices_of_all_shapes(room: vc.Scene, shape: tuple[int, int]) -> None:
    x, y = on_surfaces(room, shape[0]), in_space(room, shape[1])
    y[-1] = x[0]  # a pair without length
    assert differences(room, x, y) == 0
    bits, _ = by_shafts(room, x, y)
    if rest := shape[1] % 64:
        assert not (bits[:, -1] >> np.uint64(rest)).any()


def test_the_bytes_are_the_same_for_any_number_of_threads(room: vc.Scene) -> None:
    x, y = on_surfaces(room, 9000), in_space(room, 150)
    alone, work = by_shafts(room, x, y, threads=1)
    seen: list[tuple[int, int]] = []
    many, again = by_shafts(room, x, y, threads=3, progress=lambda *a: seen.append(a))
    assert alone.tobytes() == many.tobytes()
    assert {**work, "shaft_tree_s": 0} == {**again, "shaft_tree_s": 0}
    assert seen[-1] == (9, 9)  # 3 tiles of points, 3 words


@pytest.mark.parametrize("isa", AVAILABLE)
def test_segments_between_points_of_surfaces_and_through_edges(isa: str) -> None:
    """Points on edges and corners of a grid, and segments along its planes."""
    scene = half_a_grid()
    low, high, above = grid_places(9, 0.0), grid_places(9, 1.0), grid_places(17, 2.0, 0.5)
    for x, y in ((low, above), (above, low), (low, high), (high, high + np.float32(1e-3))):
        assert differences(scene, x, y, isa=isa) == 0


def test_without_bounds_bits_differ() -> None:
    """The negative control: tests at edges notice bounds of zero."""
    low, above = grid_places(9, 0.0), grid_places(9, 2.0)
    assert differences(half_a_grid(), low, above, bounds=0.0) > 30


@pytest.mark.parametrize("isa", AVAILABLE)
def test_needles_and_triangles_without_area(isa: str) -> None:
    scene = needles()
    assert differences(scene, on_surfaces(scene, 800), on_surfaces(scene, 130, 4), isa=isa) == 0


@pytest.mark.parametrize("holes", [{"alpha_texture": 0, "alpha_cutoff": 0.5}, {"opacity": 0.5}])
def test_holes_are_left_to_rays(holes: dict[str, Any]) -> None:
    scene = leaves(**holes)
    x, y = on_surfaces(scene, 1500), in_space(scene, 64)
    assert differences(scene, x, y) == 0
    solid = leaves().visible_matrix(x, y)
    assert np.count_nonzero(solid != scene.visible_matrix(x, y)) > 100


@pytest.mark.extreme
def test_points_close_together_and_far_away() -> None:
    scene = half_a_grid()
    near = np.random.default_rng(4).normal(3, 1e-5, (300, 3)).astype(np.float32)
    assert differences(scene, near, near[:70]) == 0
    far = np.array([[0, 1e5, 0], [1e15, 0, 0], [1, 3, 2]], np.float32)
    for x, y in ((grid_places(9, 0.0), far), (np.repeat(far, 20, axis=0), grid_places(9, 0.0))):
        bits, work = by_shafts(scene, x, y)
        assert work["left_to_packets"] > 0
        assert bits.tobytes() == scene.visible_matrix(x, y, engine="packets").tobytes()


def test_packets_answer_a_row_alone_as_beside_others(room: vc.Scene) -> None:
    """Segments along faces of boxes, for which coherent packets depend on the other rays."""
    x, y = on_surfaces(room, 1500), on_surfaces(room, 70, 9)
    together = room.visible_matrix(x, y, engine="packets")
    alone = np.concatenate([room.visible_matrix(p[None], y, engine="packets") for p in x])
    np.testing.assert_array_equal(together, alone)


def instanced() -> vc.Scene:
    d = vc.SceneDescription()
    corners = np.random.default_rng(2).uniform(-1, 1, (120, 3))
    triangles = np.arange(120).reshape(-1, 3)
    mesh = d.add_mesh(corners, triangles, material=d.add_material(), in_world=False)
    d.add_instance([mesh], np.eye(4))
    return vc.Scene.from_description(d)


def test_packets_of_turned_instances_answer_as_single_rays() -> None:
    """Faces of their boxes lie along axes of their own."""
    d = vc.SceneDescription()
    places = np.concatenate([grid_places(9, 0.0), grid_places(9, 1.0)])
    corners = (places.astype(float) - 4).reshape(2, 9, 9, 3)
    a, b, c = corners[:, :-1, :-1], corners[:, 1:, :-1], corners[:, :-1, 1:]
    triangles = np.stack([a, b, c], axis=3).reshape(-1, 3)
    mesh = d.add_mesh(
        triangles,
        np.arange(len(triangles)).reshape(-1, 3),
        material=d.add_material(),
        in_world=False,
    )
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    to_world = np.eye(4)
    to_world[:3, :3] = turn
    d.add_instance([mesh], to_world)
    scene = vc.Scene.from_description(d)
    x = (corners.reshape(-1, 3) @ turn.T).astype(np.float32)
    bits = scene.visible_matrix(x, x)
    one_by_one = np.stack([scene.visible(p, x) for p in x])
    found = np.unpackbits(bits.view(np.uint8), axis=1, bitorder="little")[:, : len(x)]
    np.testing.assert_array_equal(found.astype(bool), one_by_one)


def test_packets_answer_where_shafts_cannot_or_do_not_pay(room: vc.Scene) -> None:
    x, y = on_surfaces(room, 300), in_space(room, 20)
    own = vc.scenes.build("room?triangles=3000")  # a scene without a tree
    assert "too few queries" in by_shafts(own, x, y, choose=True)[1]["no_shafts"]
    shafts = own.shafts()
    shafts.memory_bytes()  # builds the tree
    few = _core.shaft_matrix(shafts, own.caster(), x, y[:11], choose=True)
    assert few[1]["no_shafts"] == "too few targets" and few[1]["left_to_packets"] == 3300
    scene = instanced()
    bits, work = by_shafts(scene, x, y)
    assert "instances" in work["no_shafts"]
    np.testing.assert_array_equal(bits, scene.visible_matrix(x, y, engine="packets"))


def test_a_trial_leaves_fine_scenes_to_packets() -> None:
    scene = built("random_triangles")
    scene.shafts().memory_bytes()
    x, y = in_space(scene, 500), in_space(scene, 100, 3)
    bits, work = _core.shaft_matrix(scene.shafts(), scene.caster(), x, y, choose=True)
    assert 0 < work["shaft_queries"] == 500 * 8 < work["left_to_packets"]
    np.testing.assert_array_equal(bits, scene.visible_matrix(x, y, engine="packets"))


def test_the_default_takes_shafts_where_points_are_dense(room: vc.Scene) -> None:
    x, y = on_surfaces(room, 12_000), in_space(room, 70)
    bits, work = _core.shaft_matrix(room.shafts(), room.caster(), x, y, choose=True)
    assert work["shaft_queries"] > 0.5 * len(x) * len(y)
    assert room.visible_matrix(x, y).tobytes() == bits.tobytes()
    for engine in ("packets", "shafts"):
        assert room.visible_matrix(x, y, engine=engine).tobytes() == bits.tobytes()


@pytest.mark.parametrize("rays", [vc.Embree(robust=False), vc.Bsp()], ids=["fast", "bsp"])
def test_other_rays_keep_packets(room: vc.Scene, rays: Rays) -> None:
    x, y = on_surfaces(room, 50), in_space(room, 20)
    packets = room.visible_matrix(x, y, rays=rays, engine="packets")
    np.testing.assert_array_equal(room.visible_matrix(x, y, rays=rays), packets)
    with pytest.raises(ValueError, match=r'rays must be vc.Embree\(\) with engine="shafts"'):
        room.visible_matrix(x, y, rays=rays, engine="shafts")


def test_an_unknown_engine_is_refused(room: vc.Scene) -> None:
    wrong: Any = "shaft"
    with pytest.raises(ValueError, match='engine must be "auto", "packets" or "shafts"'):
        room.visible_matrix(on_surfaces(room, 5), in_space(room, 2), engine=wrong)


def matrices(scene: vc.Scene) -> list[tuple[Array, Array]]:
    cuts = vc.correlation.surface_points(scene, 3000, seed=3).positions
    return [(cuts, on_surfaces(scene, 130)), (in_space(scene, 2000), cuts[:130])]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.release if n in ("hairball", "garden") else ())
        for n in sorted(vc.scenes.SCENES)
    ],
)
def test_matrices_of_built_in_scenes_have_the_bytes_of_packets(name: str) -> None:
    scene = vc.scenes.build(name)
    for x, y in matrices(scene):
        both = [scene.visible_matrix(x, y, engine=e).tobytes() for e in ("packets", "shafts")]
        assert both[0] == both[1]


@pytest.mark.release  # frames of them are compared each time, in test_shafts.py
@pytest.mark.skipif(not SCENES, reason="VISCACHE_SCENES is not set")
@pytest.mark.parametrize("path", shared_scenes(), ids=lambda p: p.parent.name)
def test_matrices_of_shared_scenes_have_the_bytes_of_packets(path: Path) -> None:
    scene = vc.load_scene(path, missing="skip")
    for x, y in matrices(scene):
        both = [scene.visible_matrix(x, y, engine=e).tobytes() for e in ("packets", "shafts")]
        assert both[0] == both[1]
