"""`visible_matrix` by shafts: threads, points that packets answer, and which engine is chosen.

That its bits are those of packets is in test_shafts.py.
"""

import numpy as np
import pytest

import viscache as vc
from oracles.test_oracle import area_points
from viscache import _core
from viscache.oracles.points import unpack
from visibility.test_shafts import (
    count_of_differences,
    differences,
    grid_points,
    positions,
    some_of_a_grid,
)


def on_surfaces(scene, n, seed=1):
    return positions(area_points(scene, n, seed=seed))


def in_space(scene, n, seed=2):
    return np.random.default_rng(seed).uniform(*scene.bounds, (n, 3)).astype(np.float32)


def by_shafts(scene, x, y, **more):
    return _core.shaft_matrix(_core.ShaftScene(scene._core), scene.caster(), x, y, **more)


def test_the_bytes_are_the_same_for_any_number_of_threads(room):
    x, y = on_surfaces(room, 9000), in_space(room, 150)
    alone, work = by_shafts(room, x, y, threads=1)
    seen = []
    many, again = by_shafts(room, x, y, threads=3, progress=lambda *a: seen.append(a))
    assert alone.tobytes() == many.tobytes()
    assert {**work, "shaft_tree_s": 0} == {**again, "shaft_tree_s": 0}
    assert seen[-1] == (9, 9)  # 3 tiles of points, 3 words


@pytest.mark.extreme
def test_points_close_together_and_far_away():
    scene, low = some_of_a_grid(), positions(grid_points(9, 0.0, 1.0))
    near = np.random.default_rng(4).normal(3, 1e-5, (300, 3)).astype(np.float32)
    assert differences(scene, near, near[:70]) == 0
    far = np.array([[0, 1e5, 0], [1e15, 0, 0], [1, 3, 2]], np.float32)
    for x, y in ((low, far), (np.repeat(far, 20, axis=0), low)):
        bits, work = by_shafts(scene, x, y)
        assert work["left_to_packets"] > 0
        assert bits.tobytes() == scene.visible_matrix(x, y, engine="packets").tobytes()


def test_packets_answer_a_row_alone_as_beside_others(room):
    """Segments along faces of boxes, for which coherent packets depend on the other rays."""
    x, y = on_surfaces(room, 1500), on_surfaces(room, 70, 9)
    together = room.visible_matrix(x, y, engine="packets")
    alone = np.concatenate([room.visible_matrix(p[None], y, engine="packets") for p in x])
    np.testing.assert_array_equal(together, alone)


def instanced():
    d = vc.SceneDescription()
    corners = np.random.default_rng(2).uniform(-1, 1, (120, 3))
    triangles = np.arange(120).reshape(-1, 3)
    mesh = d.add_mesh(corners, triangles, material=d.add_material(), in_world=False)
    for shift in (0.0, 1.5):
        d.add_instance([mesh], np.eye(4) + np.outer(np.eye(4)[0], [0, 0, 0, shift]))
    return vc.Scene.from_description(d)


def test_packets_of_turned_instances_answer_as_single_rays():
    """Faces of their boxes lie along axes of their own."""
    d = vc.SceneDescription()
    corners = np.stack([positions(grid_points(9, y, 1.0)) for y in (0, 1)]).astype(float) - 4
    corners = corners.reshape(2, 9, 9, 3)
    a, b, c = corners[:, :-1, :-1], corners[:, 1:, :-1], corners[:, :-1, 1:]
    triangles = np.stack([a, b, c], axis=3).reshape(-1, 3)
    faces = np.arange(len(triangles)).reshape(-1, 3)
    mesh = d.add_mesh(triangles, faces, material=d.add_material(), in_world=False)
    to_world = np.eye(4)
    to_world[:3, :3] = turn = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    d.add_instance([mesh], to_world)
    scene = vc.Scene.from_description(d)
    x = (corners.reshape(-1, 3) @ turn.T).astype(np.float32)
    one_by_one = np.stack([scene.visible(p, x) for p in x])
    np.testing.assert_array_equal(unpack(scene.visible_matrix(x, x), len(x)), one_by_one)


def test_packets_answer_where_shafts_cannot_or_do_not_pay(room):
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
    refused = _core.ShaftScene(scene._core)
    assert "instances" in refused.refusal
    with pytest.raises(RuntimeError, match="instances"):
        refused.memory_bytes()
    eyes = vc.EyePoints(x, np.broadcast_to([0.0, 1, 0], x.shape))
    assert count_of_differences(scene, eyes, vc.FarEnds.points(y)) == 0


def test_the_default_takes_shafts_where_points_are_dense(room):
    x, y = on_surfaces(room, 12_000), in_space(room, 70)
    bits, work = _core.shaft_matrix(room.shafts(), room.caster(), x, y, choose=True)
    assert work["shaft_queries"] > 0.5 * len(x) * len(y)
    assert room.visible_matrix(x, y).tobytes() == bits.tobytes()
    for engine in ("packets", "shafts"):
        assert room.visible_matrix(x, y, engine=engine).tobytes() == bits.tobytes()


@pytest.mark.parametrize("rays", [vc.Embree(robust=False), vc.Bsp()], ids=["fast", "bsp"])
def test_other_rays_keep_packets(room, rays):
    x, y = on_surfaces(room, 50), in_space(room, 20)
    packets = room.visible_matrix(x, y, rays=rays, engine="packets")
    np.testing.assert_array_equal(room.visible_matrix(x, y, rays=rays), packets)
    with pytest.raises(ValueError, match=r'rays must be vc.Embree\(\) with engine="shafts"'):
        room.visible_matrix(x, y, rays=rays, engine="shafts")


def test_an_unknown_engine_is_refused(room):
    with pytest.raises(ValueError, match='engine must be "auto", "packets" or "shafts"'):
        room.visible_matrix(on_surfaces(room, 5), in_space(room, 2), engine="shaft")  # type: ignore[arg-type]
