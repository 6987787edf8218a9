"""Objects in a visibility field: whatever they did, it is as if it were built anew."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from vlf.field_rays import soup, unit

Array = npt.NDArray[Any]
MODES = ("overlay", "in_place")
SETTINGS = vc.Vlf(n_directions=33, n_tiles=24, bsp_depth=3, leaf_target=1, head_room=2.0)
STATIC = soup(300)


def field(mode: str, **changed: Any) -> vc.vlf.DynamicField:
    import dataclasses

    settings = dataclasses.replace(SETTINGS, **changed)
    scene = vc.Scene.from_arrays(*STATIC)
    return vc.vlf.DynamicField(scene, settings, mode=mode)  # type: ignore[arg-type]


def random_object(r: np.random.Generator) -> tuple[Array, Array]:
    n = int(r.integers(1, 12))
    vertices, triangles = soup(n, int(r.integers(1 << 30)), 0.5)
    return (vertices * 0.4).astype(np.float32), triangles


def random_place(r: np.random.Generator) -> Array:
    q = np.linalg.qr(r.normal(size=(3, 3)))[0]
    return np.concatenate([q, r.uniform(-0.8, 0.8, (3, 1))], axis=1)


def placed(vertices: Array, m: Array) -> Array:
    """As the core: in double, rounded once."""
    x, y, z = vertices.astype(float).T
    return np.stack([a * x + b * y + c * z + d for a, b, c, d in m], 1).astype(np.float32)


class Played:
    """A field after random steps, and the objects as they should be."""

    def __init__(self, mode: str, steps: int, seed: int, **changed: Any) -> None:
        r = np.random.default_rng(seed)
        self.field = field(mode, **changed)
        self.objects: dict[int, tuple[Array, Array, Array]] = {}
        done = {"insert": 0, "delete": 0, "move": 0}
        for _ in range(steps):
            what = r.choice(["insert", "delete", "move", "move"])
            if what == "insert" or not self.objects:
                vertices, triangles = random_object(r)
                number = self.field.insert(vertices, triangles)
                assert number not in self.objects
                self.objects[number] = vertices, triangles, vertices
                what = "insert"
            else:
                number = int(r.choice(list(self.objects)))
                vertices, triangles, _ = self.objects[number]
                if what == "delete":
                    self.field.delete(number)
                    del self.objects[number]
                else:
                    m = random_place(r)
                    self.field.transform(number, m)
                    self.objects[number] = vertices, triangles, placed(vertices, m)
            done[what] += 1
        assert min(done.values()) > 0.1 * steps

    def scene(self) -> tuple[vc.Scene, Array]:
        """All triangles as one scene, and the owner of each."""
        parts = [(*STATIC, -1)] + [(v, t, k) for k, (_, t, v) in sorted(self.objects.items())]
        first = np.cumsum([0] + [len(p[0]) for p in parts])
        vertices = np.concatenate([p[0] for p in parts])
        triangles = np.concatenate([p[1] + f for p, f in zip(parts, first, strict=False)])
        owner = np.concatenate([np.full(len(p[1]), p[2]) for p in parts])
        return vc.Scene.from_arrays(vertices, triangles), owner


def rays(n: int, seed: int = 0) -> tuple[Array, Array]:
    r = np.random.default_rng(seed)
    a, b = unit(r.normal(size=(2, n, 3)))
    return (2.5 * a).astype(np.float32), (1.5 * b - 2.5 * a).astype(np.float32)


@pytest.mark.slow
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("split", ["uniform", "object"])
def test_after_a_thousand_steps_it_is_as_if_built_anew(mode: str, split: str) -> None:
    played = Played(mode, 1000, seed=11, split=split)
    assert played.field.stats["objects"] == len(played.objects) > 5
    for direction in range(33):
        listed = played.field._core.listed(direction)
        np.testing.assert_array_equal(listed, played.field._core.listed_anew(direction))
        assert listed[:, 1].max() >= 300
    scene, owner = played.scene()
    fresh = vc.VisibilityField(scene, 33, 24, 3)
    o, d = rays(100_000)
    expected, found = fresh.intersect(o, d), played.field.intersect(o, d)
    np.testing.assert_array_equal(found.t, expected.t)
    np.testing.assert_array_equal(found.barycentrics, expected.barycentrics)
    hit = expected.triangle >= 0
    np.testing.assert_array_equal(found.object, np.where(hit, owner[expected.triangle], -2))
    start = np.searchsorted(owner, owner[expected.triangle])  # of each owner's triangles
    np.testing.assert_array_equal(found.triangle, np.where(hit, expected.triangle - start, -1))
    assert 0.01 < (found.object >= 0).mean() < 0.9
    np.testing.assert_array_equal(played.field.occluded(o, d), hit)
    t_max = np.random.default_rng(1).uniform(0, 2, len(o)).astype(np.float32)
    np.testing.assert_array_equal(played.field.occluded(o, d, t_max), fresh.occluded(o, d, t_max))


@pytest.mark.parametrize("mode", MODES)
def test_what_was_deleted_leaves_no_trace(mode: str) -> None:
    f = field(mode)
    before = [f._core.listed(k) for k in range(33)]
    r = np.random.default_rng(3)
    numbers = [f.insert(*random_object(r)) for _ in range(20)]
    for number in numbers[::2]:
        f.transform(number, random_place(r))
    assert any(len(f._core.listed(k)) > len(before[k]) for k in range(33))
    for number in r.permutation(numbers):
        f.delete(int(number))
    for k in range(33):
        np.testing.assert_array_equal(f._core.listed(k), before[k])


def test_both_modes_and_any_number_of_threads_give_the_same_answers() -> None:
    o, d = rays(20_000)
    answers = []
    for mode in MODES:
        f = field(mode)
        r = np.random.default_rng(5)
        for threads in (1, 2, 5, None):
            number = f.insert(*random_object(r), threads=threads)
            f.transform(number, random_place(r), threads=threads)
        answers.append(f.intersect(o, d, threads=1))
        answers.append(f.intersect(o, d, threads=3))
    assert (answers[0].object >= 0).any()
    for other in answers[1:]:
        for a, b in zip(answers[0], other, strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("mode", MODES)
def test_memory_does_not_grow_with_the_number_of_moves(mode: str) -> None:
    f = field(mode)
    r = np.random.default_rng(6)
    number = f.insert(*soup(200, 9, 0.3))
    places = [random_place(r) for _ in range(10)]

    def tour() -> int:
        for m in places:
            f.transform(number, m)
        return f.stats["bytes"]

    tour()
    second = tour()
    for _ in range(8):
        last = tour()
    assert last < 1.5 * second


@pytest.mark.parametrize("mode", MODES)
def test_objects_stay_in_the_ball(mode: str) -> None:
    f = field(mode)
    with pytest.raises(ValueError, match=r"inside the field's ball; give it more head_room"):
        f.insert([[9, 0, 0], [10, 0, 0], [9, 1, 0]], [[0, 1, 2]])
    number = f.insert([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])
    listed = f._core.listed(3)
    with pytest.raises(ValueError, match="head_room"):
        f.transform(number, [[1, 0, 0, 50], [0, 1, 0, 0], [0, 0, 1, 0]])
    np.testing.assert_array_equal(f._core.listed(3), listed)


def test_tiles_do_not_follow_objects() -> None:
    with pytest.raises(ValueError, match='fit must be "sphere" where objects move'):
        field("overlay", fit="psf_box")


def test_objects_that_are_not_there_are_refused() -> None:
    f = field("overlay")
    number = f.insert([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])
    f.delete(number)
    for call in (
        lambda: f.delete(number),
        lambda: f.transform(number, np.eye(4)),
        lambda: f.delete(-1),
        lambda: f.delete("first"),
    ):  # type: ignore[arg-type]
        with pytest.raises(
            ValueError, match="object must be one that was inserted and not deleted"
        ):
            call()
    assert f.insert([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]]) != number


def test_what_cannot_be_used_is_refused() -> None:
    f = field("in_place")
    with pytest.raises(ValueError, match=r"triangles must index vertices, row 0 has 3 of 3"):
        f.insert(np.eye(3), [[0, 1, 3]])
    with pytest.raises(ValueError, match="triangles must be in"):
        f.insert(np.eye(3), [[0, 1, -3]])
    with pytest.raises(ValueError, match="vertices must be finite"):
        f.insert(np.full((3, 3), np.nan), [[0, 1, 2]])
    number = f.insert(np.eye(3) * 0.1, [[0, 1, 2]])
    with pytest.raises(ValueError, match="matrix must be affine"):
        f.transform(number, np.eye(3))
    with pytest.raises(ValueError, match="matrix must be finite"):
        f.transform(number, np.full((3, 4), np.nan))
    with pytest.raises(ValueError, match="lazy must be false"):
        field("overlay", lazy=True)
    with pytest.raises(ValueError, match="snap must be false"):
        field("overlay", snap=True)
    with pytest.raises(ValueError, match='mode must be "overlay" or "in_place"'):
        field("both")


@pytest.mark.parametrize("mode", MODES)
def test_an_empty_object_and_an_empty_scene_do_no_harm(mode: str) -> None:
    scene = vc.Scene.from_description(vc.SceneDescription())
    f = vc.vlf.DynamicField(scene, vc.Vlf(n_directions=9, n_tiles=8), mode=mode)  # type: ignore[arg-type]
    nothing = f.insert(np.zeros((0, 3)), np.zeros((0, 3), int))
    number = f.insert([[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0]], [[0, 1, 2]])
    found = f.intersect([[0.1, 0.1, 0.5], [0.9, 0.9, 0.5]], [[0, 0, -1.0]] * 2)
    assert found.object.tolist() == [number, -2] and found.t[0] == pytest.approx(0.5)
    f.delete(nothing)
    f.delete(number)
    assert not f.occluded([[0.1, 0.1, 0.5]], [[0, 0, -1.0]])[0]
