"""Objects in a visibility field: whatever they did, it is as if it were built anew."""

import dataclasses
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


def field(mode, **changed):
    settings = dataclasses.replace(SETTINGS, **changed)
    return vc.vlf.DynamicField(vc.Scene.from_arrays(*STATIC), settings, mode=mode)


def random_object(r):
    n = int(r.integers(1, 12))
    vertices, triangles = soup(n, int(r.integers(1 << 30)), 0.5)
    return (vertices * 0.4).astype(np.float32), triangles


def random_place(r):
    q = np.linalg.qr(r.normal(size=(3, 3)))[0]
    return np.concatenate([q, r.uniform(-0.8, 0.8, (3, 1))], axis=1)


def placed(vertices, m):
    """As the core: in double, rounded once."""
    x, y, z = vertices.astype(float).T
    return np.stack([a * x + b * y + c * z + d for a, b, c, d in m], 1).astype(np.float32)


class Played:
    """A field after random steps, and the objects as they should be."""

    def __init__(self, mode, steps, seed, **changed):
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

    def scene(self):
        """All triangles as one scene, and the owner of each."""
        parts = [(*STATIC, -1)] + [(v, t, k) for k, (_, t, v) in sorted(self.objects.items())]
        first = np.cumsum([0] + [len(p[0]) for p in parts])
        vertices = np.concatenate([p[0] for p in parts])
        triangles = np.concatenate([p[1] + f for p, f in zip(parts, first, strict=False)])
        owner = np.concatenate([np.full(len(p[1]), p[2]) for p in parts])
        return vc.Scene.from_arrays(vertices, triangles), owner


def rays(n, seed=0):
    r = np.random.default_rng(seed)
    a, b = unit(r.normal(size=(2, n, 3)))
    return (2.5 * a).astype(np.float32), (1.5 * b - 2.5 * a).astype(np.float32)


@pytest.mark.slow
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("split", ["uniform", "object"])
def test_after_a_thousand_steps_it_is_as_if_built_anew(mode, split):
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
def test_what_was_deleted_leaves_no_trace(mode):
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


def test_both_modes_and_any_number_of_threads_give_the_same_answers():
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
def test_memory_does_not_grow_with_the_number_of_moves(mode):
    f = field(mode)
    r = np.random.default_rng(6)
    number = f.insert(*soup(200, 9, 0.3))
    places = [random_place(r) for _ in range(10)]

    def tour():
        for m in places:
            f.transform(number, m)
        return f.stats["bytes"]

    tour()
    second = tour()
    for _ in range(8):
        last = tour()
    assert last < 1.5 * second


SMALL = ([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])


@pytest.mark.parametrize(
    ("method", "given", "says"),
    [
        ("insert", (np.eye(3), [[0, 1, 3]]), r"triangles must index vertices, row 0 has 3 of 3"),
        ("insert", (np.eye(3), [[0, 1, -3]]), "triangles must be in"),
        ("insert", (np.full((3, 3), np.nan), [[0, 1, 2]]), "vertices must be finite"),
        ("insert", (np.eye(3) + 9, [[0, 1, 2]]), "ball; give it more head_room"),
        ("transform", (0, np.eye(3)), "matrix must be affine"),
        ("transform", (0, np.full((3, 4), np.nan)), "matrix must be finite"),
        ("transform", (0, np.eye(4)[:3] + 50 * np.eye(4)[3]), "head_room"),
        ("transform", (1, np.eye(4)), "object must be one that was inserted and not deleted"),
        *(
            ("delete", (number,), "object must be one that was inserted and not deleted")
            for number in (1, -1, "first")
        ),
    ],
)
@pytest.mark.parametrize("mode", MODES)
def test_what_cannot_be_used_is_refused(mode, method, given, says):
    f = field(mode)
    assert [f.insert(*SMALL), f.insert(*SMALL)] == [0, 1]
    f.delete(1)
    listed = f._core.listed(3)
    with pytest.raises(ValueError, match=says):
        getattr(f, method)(*given)
    np.testing.assert_array_equal(f._core.listed(3), listed)
    assert f.insert(*SMALL) == 2


@pytest.mark.parametrize(
    ("mode", "changed", "says"),
    [
        ("overlay", {"lazy": True}, "lazy must be false"),
        ("overlay", {"snap": True}, "snap must be false"),
        ("overlay", {"fit": "psf_box"}, 'fit must be "sphere" where objects move'),
        ("both", {}, 'mode must be "overlay" or "in_place"'),
    ],
)
def test_fields_that_cannot_hold_objects_are_refused(mode, changed, says):
    with pytest.raises(ValueError, match=says):
        field(mode, **changed)


@pytest.mark.parametrize("mode", MODES)
def test_an_empty_object_and_an_empty_scene_do_no_harm(mode):
    scene = vc.Scene.from_description(vc.SceneDescription())
    f = vc.vlf.DynamicField(scene, vc.Vlf(n_directions=9, n_tiles=8), mode=mode)
    nothing = f.insert(np.zeros((0, 3)), np.zeros((0, 3), int))
    number = f.insert([[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0]], [[0, 1, 2]])
    found = f.intersect([[0.1, 0.1, 0.5], [0.9, 0.9, 0.5]], [[0, 0, -1.0]] * 2)
    assert found.object.tolist() == [number, -2] and found.t[0] == pytest.approx(0.5)
    f.delete(nothing)
    f.delete(number)
    assert not f.occluded([[0.1, 0.1, 0.5]], [[0, 0, -1.0]])[0]
